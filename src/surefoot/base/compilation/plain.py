"""Kernels as ordinary `numba.njit(cache=True)`: without private parts of Numba, slower to compile.

Numba compiles a kernel anew when its own file has changed, and keeps it otherwise, even where what it calls
in other files has changed. So code is kept in a folder that is named by the text of all sources of this
package and of those beside the kernel: after an edit everything is compiled again.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np

import surefoot
from surefoot.base.compilation import in_python
from surefoot.base.compilation.progress import LOG

PACKAGE = Path(surefoot.__file__).parent
FOLDERS = 3
"""Folders of earlier sources that are left: another checkout may use them."""
_changing_place = threading.RLock()
_kernels: list[Any] = []
_releasing: set[Any] = set()
"""Functions of kernels that release the interpreter's lock."""


def compiled(function: Any, releasing: bool = False, folded: bool = False) -> Any:
    """Return `numba.njit` of a function; the function where Numba is switched off (NUMBA_DISABLE_JIT=1).

    `folded` has no say: LLVM folds small functions into their callers without being told.
    """
    if numba.config.DISABLE_JIT:
        function.py_func = function
        return function
    if releasing:
        _releasing.add(function)
    return _njit(function)


def entry_point(kernel: Any, types: tuple[Any, ...]) -> Callable[..., Any]:
    """Return the function of a kernel for one choice of types, which compiles nothing more.

    Numba would refuse an array that may not be written: such a one is copied.
    """
    if numba.config.DISABLE_JIT:
        return kernel  # type: ignore[no-any-return]
    call = _njit(kernel.py_func, types)
    return lambda *given: call(*[_writable(value) for value in given])


def _writable(value: Any) -> Any:
    return value.copy() if isinstance(value, np.ndarray) and not value.flags.writeable else value


def _njit(function: Any, *signature: Any) -> Any:
    """Return Numba's own compiled function: for all types, or for those given alone."""
    options: dict[str, Any] = {"error_model": "numpy", "nogil": function in _releasing}
    if getattr(function, "takes_kernels", False):
        options["inline"] = "always"
    with _kept_in(_folder(str(Path(function.__code__.co_filename).parent))) as kept:
        try:
            made = numba.njit(*signature, cache=kept, **options)(function)
        except RuntimeError:  # a function that is in no file has no place in Numba's cache
            made = numba.njit(*signature, **options)(function)
    _kernels.append(made)
    return made


@contextlib.contextmanager
def _kept_in(folder: str | None) -> Iterator[bool]:
    """Have Numba keep in a folder what is decorated meanwhile: it looks at NUMBA_CACHE_DIR then."""
    if folder is None:
        yield False
        return
    with _changing_place:
        before, numba.config.CACHE_DIR = numba.config.CACHE_DIR, folder
        try:
            yield True
        finally:
            numba.config.CACHE_DIR = before


@cache
def _folder(beside: str) -> str | None:
    """Return where code is kept that is made from this package and the sources in a folder, or None."""
    said = hashlib.sha256(_package_hash())
    if not Path(beside).is_relative_to(PACKAGE):
        _feed(said, sorted(Path(beside).glob("*.py")))
    for root in _roots():
        folder = root / f"plain-{said.hexdigest()[:16]}"
        with contextlib.suppress(OSError):
            new = not folder.is_dir()
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            if new:
                _remove_old(root)
            return str(folder)
    LOG.warning("compiled code is not kept: there is no folder to write to")
    return None


def _roots() -> list[Path]:
    """Return the folders that are tried: the one asked for, or beside the sources, then the user's."""
    if numba.config.CACHE_DIR:
        return [Path(numba.config.CACHE_DIR)]
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    return [PACKAGE / "__pycache__", Path(users).expanduser() / "surefoot"]


def _remove_old(root: Path) -> None:
    """Remove the folders of sources that have gone, but for the newest few."""
    made = sorted(root.glob("plain-*"), key=lambda folder: folder.stat().st_mtime)
    for folder in made[: -FOLDERS - 1]:
        shutil.rmtree(folder, ignore_errors=True)


@cache
def _package_hash() -> bytes:
    said = hashlib.sha256(numba.__version__.encode())
    _feed(said, sorted(PACKAGE.rglob("*.py")))
    return said.digest()


def _feed(said: Any, files: list[Path]) -> None:
    for file in files:
        with contextlib.suppress(OSError):  # an editor's file that has gone meanwhile
            said.update(file.read_bytes())
            said.update(b"\0")


borrowed, window, keep = compiled(in_python.borrowed), compiled(in_python.window), compiled(in_python.keep)


def cache_folders() -> list[str]:
    """Return where the compiled code of the kernels that have been imported is kept."""
    return sorted({str(kernel.stats.cache_path) for kernel in _kernels if kernel.stats.cache_path})


def kept_files(package: Path) -> list[Path]:
    """Return the files of compiled code of a package's sources as they are."""
    folder = _folder(str(package)) if _kernels else None
    return [] if folder is None else sorted(Path(folder).rglob("*.nbc"))


def compiled_so_far() -> int:
    """Return how many kernels this process has compiled, not loaded, those below others included."""
    return sum(sum(kernel.stats.cache_misses.values()) for kernel in _kernels)
