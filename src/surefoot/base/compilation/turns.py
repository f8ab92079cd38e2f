"""Of several processes that miss the same kernel one compiles it, and the others wait for their turn."""

from __future__ import annotations

import contextlib
import os
import time
import zlib
from collections.abc import Callable
from typing import Any

from surefoot.base.compilation.progress import LOG


def _import_fcntl() -> Any:
    """Return the module of locks; None on Windows, which has no such locks."""
    try:
        import fcntl
    except ImportError:
        return None
    return fcntl


fcntl = _import_fcntl()
PATIENCE = 300.0
"""How long a process waits for one that compiles the same kernel [s]; that one may have been stopped."""
_locks: dict[str, int] = {}
"""Folder to its open lock file, kept open: to close a file ends all locks that the process has on it."""


class Turn:
    """The right to compile one kernel: a byte of one file per folder is its lock.

    Parameters
    ----------
    folder
        Where the kernel's compiled code is kept.
    file
        Name of the kernel's index there.
    make_folder
        Called before the lock file is opened; raises OSError where nobody may write.
    """

    def __init__(self, folder: str, file: str, make_folder: Callable[[], None]) -> None:
        self._folder, self._make_folder = folder, make_folder
        self._byte, self._held = zlib.crc32(file.encode()), False

    def wait(self, name: str) -> None:
        """Wait until no other process compiles the kernel of that name."""
        if fcntl is None:  # every process compiles for itself
            return
        until = time.monotonic() + PATIENCE
        with contextlib.suppress(OSError):  # nowhere to write: every process compiles for itself
            self._make_folder()
            if (lock := _locks.get(self._folder)) is None:
                path = os.path.join(self._folder, "kernels.lock")
                lock = _locks[self._folder] = os.open(path, os.O_RDWR | os.O_CREAT)
            while time.monotonic() < until:
                with contextlib.suppress(BlockingIOError, PermissionError):
                    # one byte per kernel: different kernels of a folder compile at the same time
                    fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, self._byte)
                    self._held = True
                    return
                time.sleep(0.02)
            LOG.info("another process has been compiling %s for %g s", name, PATIENCE)

    def end(self) -> None:
        """Let the next process have the kernel: it is compiled and kept, or it failed to compile."""
        if self._held:
            fcntl.lockf(_locks[self._folder], fcntl.LOCK_UN, 1, self._byte)
            self._held = False
