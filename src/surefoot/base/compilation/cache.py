"""Compiled code on disk: Numba's files, in Numba's places, keyed by what they were made from."""

from __future__ import annotations

import contextlib
import os
import pickle
import sys
import time
import zlib
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.environment import Environment, lookup_environment
from numba.core.runtime import rtsys

from surefoot.base.compilation.progress import LOG, progress
from surefoot.base.compilation.tree import KernelTree

if sys.platform != "win32":
    import fcntl

PATIENCE = 300.0
"""How long a process waits for one that compiles the same kernel [s]; that one may have been stopped."""
_caches: list[Cache] = []
_locks: dict[str, int] = {}
"""Folder to its open lock file, kept open: to close a file ends all locks that the process has on it."""


def _environment(module: str, constants: list[Any], name: str) -> Environment:
    """Return what compiled code of a module knows of it: only constants, as nopython code asks for no more.

    Numba would import the module: 0.2 s for those of its own that kernels have had a function of.
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


class _KernelFiles(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's files, of which machine code is read.

    What LLVM made it from is kept beside it, for functions that are compiled into their callers. It takes
    most of the time to load, and no kernel asks for it: a caller compiles its whole tree.
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


class Cache(FunctionCache):  # type: ignore[misc]
    """Numba's files with compiled code, where Numba keeps them, one index per kernel, keyed by its tree.

    Code beside the sources is read where nobody may write to it, too: an administrator can run `surefoot
    warmup` for all. What cannot be written is compiled again by the next process, and no error.

    Of several processes that miss the same kernel one compiles it and the others wait. (Numba's index is
    read, changed and written: two that compile one kernel for different types may leave the code of one
    under the types of the other.)
    """

    def __init__(self, py_func: Any, tree: KernelTree) -> None:
        super().__init__(py_func)
        self._tree = tree
        self._turn: tuple[int, int] | None = None
        # no line number in the name, or every change of a file would leave old code behind
        name = self._impl.get_filename_base(f"{py_func.__module__}.{py_func.__qualname__}", "")
        name = name.replace(f"-{self._impl.locator.get_disambiguator()}.", ".")
        beside = os.path.join(os.path.dirname(py_func.__code__.co_filename), "__pycache__")
        self._cache_file = _KernelFiles(self._cache_path, name, tree.key)
        _caches.append(self)
        # where the sources' folder is not Numba's choice (it may not be written to)
        # code kept there is read all the same
        elsewhere = beside != self._cache_path and not numba.config.CACHE_DIR
        self._beside = _KernelFiles(beside, name, tree.key) if elsewhere else None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what was compiled for argument types, or None.

        Code on disk runs without Numba's implementations of Python and NumPy, which take 0.3 s to load: only
        its runtime must be there. They come with a kernel that has to be compiled.
        """
        rtsys.initialize(target_context)
        found = self._load_overload(sig, target_context)
        if found is None:
            # after the wait another process may have compiled and kept it
            self._await_turn()
            found = super().load_overload(sig, target_context)
        if found is None:
            progress.start(self._tree)
        return found

    def _await_turn(self) -> None:
        """Wait until no other process compiles this kernel: a byte of one file per folder is its lock."""
        if sys.platform == "win32":  # has no such locks: there, every process compiles for itself
            return
        byte, until = zlib.crc32(self._cache_file._index_name.encode()), time.monotonic() + PATIENCE
        with contextlib.suppress(OSError):  # nowhere to write: every process compiles for itself
            self._impl.locator.ensure_cache_path()
            if (lock := _locks.get(self._cache_path)) is None:
                path = os.path.join(self._cache_path, "kernels.lock")
                lock = _locks[self._cache_path] = os.open(path, os.O_RDWR | os.O_CREAT)
            while time.monotonic() < until:
                with contextlib.suppress(BlockingIOError, PermissionError):
                    # one byte per kernel: different kernels of a folder compile at the same time
                    fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
                    self._turn = lock, byte
                    return
                time.sleep(0.02)
            LOG.info("another process has been compiling %s for %g s", self._tree.name, PATIENCE)

    def end_turn(self) -> None:
        """Let the next process have this kernel: it is compiled and kept, or it failed to compile."""
        if self._turn is not None:
            lock, byte = self._turn
            fcntl.lockf(lock, fcntl.LOCK_UN, 1, byte)
            self._turn = None

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


def cache_folders() -> list[str]:
    """Return where the compiled code of the kernels that have been called is kept."""
    return sorted({cache.cache_path for cache in _caches})
