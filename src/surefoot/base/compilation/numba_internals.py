"""What relies on private parts of Numba: no other file imports them, but for `uncounted`.

What is relied upon is said where it is used, and `check` looks whether it is there; `RELIES_ON` is the list.
All of it is the same in Numba 0.61.0, 0.64.0 and 0.68.1, the versions that it was tried with (2026-11-25).
With a version outside `choice.KNOWN`, or where `check` fails, kernels are compiled by `plain`: that costs
time at the first call and nothing else. `compilation/test_numba_internals.py` says what to do then.
"""

from __future__ import annotations

import contextlib
import inspect
import os
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.core import (
    cgutils,  # get_null_value(type): a null of an LLVM type
    types,  # Dispatcher: the type of a kernel that is given as an argument; takes the kernel
)
from numba.core.caching import FunctionCache, IndexDataCacheFile  # what keeps compiled code on disk: `Cache`
from numba.core.codegen import JITCodeLibrary  # a function's LLVM module on its way to machine code: `Part`
from numba.core.compiler import Compiler  # the pipeline, whose `state.library` may be set beforehand
from numba.core.datamodel import models, register_default  # OpaqueModel: a value that is a pointer or null
from numba.core.dispatcher import OmittedArg  # `value`: stands for a default among a call's arguments
from numba.core.environment import Environment, lookup_environment  # what compiled code knows of its module
from numba.core.imputils import lower_constant  # how a global is written into code, by its type
from numba.core.registry import CPUDispatcher  # what `numba.njit` returns: `Kernel`
from numba.core.runtime import rtsys  # Numba's runtime, without which loaded code cannot run
from numba.extending import _Intrinsic  # _defn: the Python function of an intrinsic

from surefoot.base.compilation.cold_start import NotKept, cold_start
from surefoot.base.compilation.progress import LOG, progress
from surefoot.base.compilation.tree import KernelTree
from surefoot.base.compilation.turns import Turn

RELIES_ON: tuple[tuple[Any, str, str], ...] = (
    (JITCodeLibrary, "_optimize_final_module", "self"),
    (JITCodeLibrary, "_finalize_final_module", "self"),
    (JITCodeLibrary, "_finalize_dynamic_globals", "self"),
    (JITCodeLibrary, "_ensure_finalized", "self"),
    (JITCodeLibrary, "get_pointer_to_function", "self name"),
    (JITCodeLibrary, "codegen", ""),
    (Compiler, "define_pipelines", "self"),
    (CPUDispatcher, "__init__", "self py_func locals targetoptions pipeline_class"),
    (CPUDispatcher, "compile", "self sig"),
    (CPUDispatcher, "_compile_for_args", "self args kws"),
    (CPUDispatcher, "get_call_template", "self args kws"),
    (CPUDispatcher, "get_overload", "self sig"),
    (FunctionCache, "__init__", "self py_func"),
    (FunctionCache, "load_overload", "self sig target_context"),
    (FunctionCache, "_load_overload", "self sig target_context"),
    (FunctionCache, "save_overload", "self sig data"),
    (FunctionCache, "_index_key", "self sig codegen"),
    (IndexDataCacheFile, "__init__", "self cache_path filename_base source_stamp"),
    (IndexDataCacheFile, "load", "self key"),
    (IndexDataCacheFile, "_load_index", "self"),
    (IndexDataCacheFile, "_load_data", "self name"),
    (IndexDataCacheFile, "_data_path", "self name"),
    (Environment, "_memo", ""),
    (_Intrinsic, "_register", "self"),
    (OmittedArg, "__init__", "self value"),
    (lookup_environment, "", "env_name"),
    (cgutils.get_null_value, "", "ltype"),
    (rtsys, "initialize", "ctx"),
)
"""(owner, name, parameters) of what is called or replaced; "" for the owner itself, or for no function."""


def check() -> None:
    """Raise TypeError where a private part of Numba is absent or takes other arguments than it did."""
    for owner, name, parameters in RELIES_ON:
        path = f"{getattr(owner, '__module__', '')}.{getattr(owner, '__qualname__', owner)} {name}".strip()
        part = getattr(owner, name, None) if name else owner
        if part is None:
            raise TypeError(f"{path} has gone")
        if parameters and (found := " ".join(inspect.signature(part).parameters)) != parameters:
            raise TypeError(f"{path} takes ({found}), not ({parameters})")


# --- parts: a kernel that is called by kernels is translated, and left to its caller to optimise and compile


class Part(JITCodeLibrary):  # type: ignore[misc]
    """The translated code of a kernel that is called by kernels, to be linked into theirs as it is.

    Relied upon: a library that is linked into another gives its module as `_optimize_final_module` left it,
    and `finalize` calls the two methods that do nothing here.
    """

    def _optimize_final_module(self) -> None:
        """Leave that to the caller, who has more to go by."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, for nothing here can be called."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Part:
        """Itself, whose `set_env` has nowhere to write to."""
        return self

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing; see `Cache.save_overload`."""


class PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's pipeline, into a `Part`. Relied upon: passes write to `state.library` if there is one."""

    def define_pipelines(self) -> Any:
        """Return the usual passes, and give them a `Part` to write to."""
        name = self.state.func_id.func_qualname
        self.state.library = Part(self.state.targetctx.codegen(), name)
        return super().define_pipelines()


# --- the cache: Numba's files, in Numba's places, keyed by the code of a whole tree


def _environment(module: str, constants: list[Any], name: str) -> Environment:
    """Return what compiled code of a module knows of it: only constants, as nopython code asks for no more.

    Numba would import the module: 0.2 s for those of its own that kernels have had a function of. Relied
    upon: `_rebuild_env` is called with these arguments, and `_memo` is where environments are looked up.
    """
    found = lookup_environment(name)
    if found is None:
        known = sys.modules.get(module)
        found = Environment({"__name__": module} if known is None else vars(known))
        found.consts[:] = constants
        found.env_name = name
        Environment._memo[name] = found
    return found


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        return _environment if name == "_rebuild_env" else super().find_class(module, name)


class KernelFiles(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's files, of which machine code is read.

    What LLVM made it from is kept beside it, for functions that are compiled into their callers. It takes
    most of the time to load, and no kernel asks for it: a caller compiles its whole tree. Relied upon: data
    are (library, description, ...), the library (name, "object", (machine code, LLVM's code)).
    """

    def _load_index(self) -> Any:
        # Numba reads an index whole before it asks what code it is of: an earlier one may name types that
        # have gone or moved.
        with contextlib.suppress(AttributeError, ImportError):
            return super()._load_index()
        return {}

    def _load_data(self, name: str) -> Any:
        with open(self._data_path(name), "rb") as file:
            library, described, *more = _Unpickler(file).load()
        if library[1] == "object":
            defined = f'define void @"{described.llvm_cpython_wrapper_name}"() {{ ret void }}'
            library = (*library[:2], (library[2][0], llvm.parse_assembly(defined).as_bitcode()))
        return (library, described, *more)


_caches: list[Cache] = []


class Cache(FunctionCache):  # type: ignore[misc]
    """Numba's files with compiled code, where Numba keeps them, one index per kernel, keyed by its tree.

    Code beside the sources is read where nobody may write to it, too: an administrator can run `surefoot
    warmup` for all. What cannot be written is compiled again by the next process, and no error.

    Of several processes that miss the same kernel one compiles it and the others wait. (Numba's index is
    read, changed and written: two that compile one kernel for different types may leave the code of one
    under the types of the other.) Relied upon: `_impl.locator` knows the folder, `_cache_file` the files.
    """

    def __init__(self, py_func: Any, tree: KernelTree) -> None:
        super().__init__(py_func)
        self._tree = tree
        # no line number in the name, or every change of a file would leave old code behind
        name = self._impl.get_filename_base(f"{py_func.__module__}.{py_func.__qualname__}", "")
        name = name.replace(f"-{self._impl.locator.get_disambiguator()}.", ".")
        beside = os.path.join(os.path.dirname(py_func.__code__.co_filename), "__pycache__")
        self._cache_file = KernelFiles(self._cache_path, name, tree.key)
        self.turn = Turn(self._cache_path, name, self._impl.locator.ensure_cache_path)
        _caches.append(self)
        # where the sources' folder may not be written to, what it holds is read
        elsewhere = beside != self._cache_path and not numba.config.CACHE_DIR
        self._beside = KernelFiles(beside, name, tree.key) if elsewhere else None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what was compiled for argument types, or None.

        Code on disk needs Numba's runtime, not its implementations of Python and NumPy, which take 0.3 s to
        load: they come with a kernel that has to be compiled.
        """
        rtsys.initialize(target_context)
        found = self._load_overload(sig, target_context)
        if found is None and cold_start.allowed:
            raise NotKept(self._tree.name)
        if found is None:
            # after the wait another process may have compiled and kept it
            self.turn.wait(self._tree.name)
            found = super().load_overload(sig, target_context)
        if found is None:
            progress.start(self._tree)
        return found

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        with contextlib.suppress(OSError, EOFError, pickle.UnpicklingError):
            if (found := super()._load_overload(sig, target_context)) is not None or self._beside is None:
                return found
            data = self._beside.load(self._index_key(sig, target_context.codegen()))
            return None if data is None else self._impl.rebuild(target_context, data)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what has been compiled."""
        for env in data._find_referenced_environments():  # of the parts, which had no place for them yet
            data.library.codegen.set_env(env.env_name, env)
        try:
            super().save_overload(sig, data)
        except OSError as error:
            LOG.info("compiled code is not kept: %s", error)
        progress.end(self._tree)


# --- kernels, as Python sees them and as other kernels do


class KernelType(types.Dispatcher):
    """A kernel given to a kernel as an argument: its type says which, and its value is nothing."""


register_default(KernelType)(models.OpaqueModel)


@lower_constant(KernelType)  # type: ignore[untyped-decorator]
def _no_address(context: Any, builder: Any, kind: KernelType, kernel: Any) -> Any:
    """Return null, where Numba would write the object's address into code that could then not be kept."""
    return context.get_dummy_value()


class _PartDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel as other kernels see it."""

    def compile(self, sig: Any) -> Any:
        found = super().compile(sig)
        progress.passed(self.py_func)
        return found


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A compiled function; called from Python it is the top of its own tree.

    It may not call itself. Relied upon: `_numba_type_` is what a value says of its type, `compile` looks into
    `_cache`, and callers ask `get_call_template` and `get_overload` for what they link.
    """

    _cache: Any

    def __init__(self, py_func: Any, locals: Any = None, targetoptions: Any = None, **options: Any) -> None:
        super().__init__(py_func, locals, targetoptions, **options)
        self._tree: KernelTree | None = None
        self._part: CPUDispatcher | None = None

    @property
    def _numba_type_(self) -> KernelType:
        return KernelType(self)

    @property
    def tree(self) -> KernelTree:
        """What this kernel is compiled from."""
        if self._tree is None:
            self._tree = KernelTree.below(self, _insides)
        return self._tree

    def compile(self, sig: Any) -> Any:
        """Compile for argument types, or load what has been compiled before; return the compiled function."""
        if self._tree is None:
            try:
                self._cache = Cache(self.py_func, self.tree)
            except RuntimeError as error:  # nowhere to write to
                LOG.warning("%s", error)
        try:
            return super().compile(sig)
        finally:
            if isinstance(self._cache, Cache):
                self._cache.turn.end()

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        """Return what is called with such arguments. Relied upon: that may be a function of Python."""
        if cold_start.inside:  # a kernel that Python was given as an argument
            return _without_omitted(cold_start.in_python(self))
        compile_for = super()._compile_for_args
        try:
            return compile_for(*args, **kws)
        except NotKept:
            return _without_omitted(cold_start.callable_of(self, lambda: compile_for(*args, **kws)))

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what a kernel that calls this one is given of it."""
        return self._for_kernels().get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return what a kernel that calls this one links."""
        return self._for_kernels().get_overload(sig)

    def _for_kernels(self) -> CPUDispatcher:
        if self._part is None:
            # what only kernels call needs no way in from Python or C
            options = {**self.targetoptions, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
            self._part = _PartDispatcher(self.py_func, {}, options, pipeline_class=PartCompiler)
        return self._part


def _without_omitted(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that takes what stands for a default as its value."""
    return lambda *given: function(*(g.value if isinstance(g, OmittedArg) else g for g in given))


def _insides(value: Any) -> tuple[FunctionType | CodeType, str] | None:
    """Return what a compiled function or an intrinsic is made from, and with which options."""
    if isinstance(value, CPUDispatcher):
        return value.py_func, repr(sorted(value.targetoptions.items()))
    if isinstance(value, _Intrinsic):
        return value._defn.__code__, ""
    return None


def compiled(function: Any, releasing: bool = False, folded: bool = False) -> Any:
    """Return the kernel of a function; see `kernels` for what it may be asked.

    Relied upon: options that Numba's manual does not have, `no_cfunc_wrapper` (no second way in, from C) and
    `forceinline` (LLVM's alwaysinline).
    """
    # Numba hands a `forceinline` that is not said on from the first caller: it is said of every kernel
    options: dict[str, Any] = {
        "nopython": True, "error_model": "numpy", "no_cfunc_wrapper": True, "forceinline": folded,
    }  # fmt: skip
    if releasing:
        options["nogil"] = True
    return Kernel(function, {}, options)


def entry_point(kernel: Any, types: tuple[Any, ...]) -> Callable[..., Any]:
    """Return a kernel's function for one choice of types. Relied upon: `compile` returns it."""
    try:
        return kernel.compile(types)  # type: ignore[no-any-return]
    except NotKept:
        return cold_start.callable_of(kernel, lambda: kernel.compile(types))


# --- what there is to say


def cache_folders() -> list[str]:
    """Return where the compiled code of the kernels that have been called is kept."""
    return sorted({cache.cache_path for cache in _caches})


def kept_files(package: Path) -> list[Path]:
    """Return the files of compiled code, beside a package's sources or where Numba keeps it."""
    folders = {*map(Path, cache_folders()), *package.rglob("__pycache__")}
    return [file for folder in folders for file in folder.glob("surefoot.*.nbc")]
