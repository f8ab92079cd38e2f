"""How kernels are compiled: every tree of calls once, and kept on disk under the code that it was made from.

Numba compiles every function on its own: optimises it, makes machine code of it, wraps it for Python, and
does so again for each caller that it is linked into. Here a kernel that is called by a kernel is only
translated (`_Part`); optimisation and machine code come once, for the kernel that Python calls, with the whole
tree in one module. That halves the time of a first call and changes no result.

Numba keeps compiled code as long as the kernel's own file is the same. Here the key is the code itself: that of
the kernel, of all kernels that it calls and of the constants that they read, wherever they are written.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

LOG = logging.getLogger("surefoot.compilation")
"""Says what is compiled: a level of WARNING for what takes long, INFO else; DEBUG for the way through a tree.

A record's `share` is how much of the tree is done, 0 at the start and 1 at the end.
"""
LONG = 2.0
"""A compilation that should take longer than this [s] is told as a warning."""
RATE = 1.7e-4
"""Seconds per byte of Python's code in a tree of kernels, on a core of 3 GHz."""
_FORMAT = 1
"""Part of every key: to be raised when this file compiles otherwise than before."""
_HOOKS = ("_optimize_final_module", "_finalize_final_module", "get_pointer_to_function", "codegen")
_WHOLE_TREES = all(hasattr(JITCodeLibrary, name) for name in _HOOKS)
"""Whether this Numba has what `_Part` overrides; else kernels compile one by one, as Numba does."""


class _Part(JITCodeLibrary):  # type: ignore[misc]
    """The translated code of a kernel that is called by kernels, to be linked into theirs as it is."""

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
    def codegen(self) -> _Part:
        """Itself, whose `set_env` has nowhere to write to."""
        return self

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing; see `_Cache.save_overload`."""


class _PartCompiler(Compiler):  # type: ignore[misc]
    """Numba's pipeline, into a `_Part`."""

    def define_pipelines(self) -> Any:
        name = self.state.func_id.func_qualname
        self.state.library = _Part(self.state.targetctx.codegen(), name)
        return super().define_pipelines()


class _PartDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel as other kernels see it."""

    def compile(self, sig: Any) -> Any:
        found = super().compile(sig)
        _progress.passed(self.py_func)
        return found


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A compiled function; called from Python it is the top of its own tree.

    It may not call itself.
    """

    def __init__(self, py_func: Any, locals: Any = None, targetoptions: Any = None, **options: Any) -> None:
        super().__init__(py_func, locals, targetoptions, **options)
        self._tree: Tree | None = None
        self._part: CPUDispatcher | None = None

    @property
    def tree(self) -> Tree:
        """What this kernel is compiled from."""
        if self._tree is None:
            self._tree = Tree.below(self)
        return self._tree

    def compile(self, sig: Any) -> Any:
        """Compile for argument types, or load what has been compiled before; return the compiled function."""
        if not isinstance(self._cache, _Cache):
            self._cache = _Cache(self.py_func, self.tree)
        return super().compile(sig)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        return self._for_kernels().get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        return self._for_kernels().get_overload(sig)

    def _for_kernels(self) -> CPUDispatcher:
        if self._part is None:
            options = {**self.targetoptions, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
            more = {"pipeline_class": _PartCompiler} if _WHOLE_TREES else {}
            self._part = _PartDispatcher(self.py_func, {}, options, **more)
        return self._part


@dataclass
class Tree:
    """A kernel and all that it calls.

    Attributes
    ----------
    functions
        The Python functions.
    key
        Hash of their code and of the constants that they read, of the versions that compile them.
    """

    functions: list[FunctionType] = field(default_factory=list)
    key: str = ""

    @classmethod
    def below(cls, kernel: Kernel) -> Tree:
        """Return the tree of a kernel."""
        tree, feed = cls(), hashlib.sha256()
        versions = numba.__version__, llvmlite.__version__, np.__version__, _FORMAT, _WHOLE_TREES
        feed.update(repr(versions).encode())
        for text in tree._of_value(kernel, ()):
            feed.update(text)
            feed.update(b"\0")
        tree.key = feed.hexdigest()
        return tree

    @property
    def size(self) -> int:
        """Bytes of Python's code, which the time to compile follows."""
        return sum(len(f.__code__.co_code) for f in self.functions)

    def _of_value(self, value: Any, names: Iterable[str]) -> Iterable[bytes]:
        """Return what there is to say of a value that a function reads; `names` are those in its code."""
        if isinstance(value, CPUDispatcher):
            yield repr(sorted(value.targetoptions.items())).encode()
            value = value.py_func
        if isinstance(value, FunctionType):
            yield f"{value.__module__}.{value.__qualname__}".encode()
            if value not in self.functions:
                self.functions.append(value)
                yield from self._of_function(value)
        elif isinstance(value, ModuleType):
            yield value.__name__.encode()
            if value.__name__.partition(".")[0] == __name__.partition(".")[0]:
                for name in names:
                    if name in vars(value):
                        yield from self._of_value(vars(value)[name], names)
        elif isinstance(value, (tuple, list)):
            yield f"{type(value).__qualname__} {len(value)}".encode()
            for item in value:
                yield from self._of_value(item, names)
        elif isinstance(value, np.ndarray):
            yield f"{value.dtype} {value.shape} {value.strides}".encode() + value.tobytes()
        elif isinstance(value, type):
            yield f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}".encode()
        elif isinstance(value, (frozenset, set)):
            yield repr(sorted(map(repr, value))).encode()
        else:
            text = repr(value)
            yield f"{type(value)} {'' if ' at 0x' in text else text}".encode()

    def _of_function(self, function: FunctionType) -> Iterable[bytes]:
        codes = list(_codes(function.__code__))
        for code in codes:
            yield code.co_code
            yield repr((code.co_names, code.co_varnames, code.co_argcount, code.co_flags)).encode()
            for constant in code.co_consts:
                if not isinstance(constant, CodeType):
                    yield from self._of_value(constant, ())
        yield from self._of_value(function.__defaults__ or (), ())
        names = sorted({name for code in codes for name in code.co_names})
        for name in names:
            if name in function.__globals__:
                yield name.encode()
                yield from self._of_value(function.__globals__[name], names)


def _codes(code: CodeType) -> Iterable[CodeType]:
    """Return a function's code and that of the functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's files with compiled code, where Numba keeps them, one index per kernel, keyed by its tree.

    Code beside the sources is read where nobody may write to it, too: an administrator can run `surefoot
    warmup` for all. What cannot be written is compiled again by the next process, and no error.
    """

    def __init__(self, py_func: Any, tree: Tree) -> None:
        super().__init__(py_func)
        self._tree = tree
        # no line number in the name, or every change of a file would leave old code behind
        name = self._impl.get_filename_base(f"{py_func.__module__}.{py_func.__qualname__}", "")
        name = name.replace(f"-{self._impl.locator.get_disambiguator()}.", ".")
        beside = os.path.join(os.path.dirname(py_func.__code__.co_filename), "__pycache__")
        self._cache_file = IndexDataCacheFile(self._cache_path, name, tree.key)
        elsewhere = beside != self._cache_path and not numba.config.CACHE_DIR
        self._beside = IndexDataCacheFile(beside, name, tree.key) if elsewhere else None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        found = super().load_overload(sig, target_context)
        if found is None:
            _progress.start(self._tree)
        return found

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        with contextlib.suppress(OSError):
            if (found := super()._load_overload(sig, target_context)) is not None or self._beside is None:
                return found
            data = self._beside.load(self._index_key(sig, target_context.codegen()))
            return None if data is None else self._impl.rebuild(target_context, data)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        for env in data._find_referenced_environments():  # of the parts, which had no place for them yet
            data.library.codegen.set_env(env.env_name, env)
        try:
            super().save_overload(sig, data)
        except OSError as error:
            LOG.info("compiled code is not kept: %s", error)
        _progress.end(self._tree)


class _Progress:
    """Says through `LOG` which kernel is being compiled and how far it is."""

    def __init__(self) -> None:
        self._trees: list[tuple[Tree, set[FunctionType], float]] = []

    def start(self, tree: Tree) -> None:
        self._trees.append((tree, set(), time.perf_counter()))
        seconds, calls = RATE * tree.size, len(tree.functions) - 1
        LOG.log(
            logging.WARNING if seconds > LONG else logging.INFO,
            "compiling %s%s, once; about %.0f s (`surefoot warmup` compiles everything ahead)",
            tree.functions[0].__name__,
            f" and the {calls} kernels that it calls" if calls else "",
            max(seconds, 1.0),
            extra={"share": 0.0, "kernel": tree.functions[0].__name__},
        )

    def passed(self, function: Any) -> None:
        if not self._trees or function in self._trees[-1][1]:
            return
        tree, done, _ = self._trees[-1]
        done.add(function)
        share = sum(len(f.__code__.co_code) for f in done) / max(tree.size, 1)
        LOG.debug("translated %s", function.__name__, extra={"share": min(0.7 * share, 1.0)})

    def end(self, tree: Tree) -> None:
        while self._trees:
            last, _, start = self._trees.pop()
            if last is tree:
                name, seconds = tree.functions[0].__name__, time.perf_counter() - start
                LOG.debug("compiled %s in %.1f s", name, seconds, extra={"share": 1.0, "kernel": name})
                break


_progress = _Progress()
