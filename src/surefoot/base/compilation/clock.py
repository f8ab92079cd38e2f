"""A clock that stands still while kernels are compiled.

It uses the one part of `numba.core` that is documented for programs to use, Numba's "Event API".
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any


class _CompilingTime(threading.local):
    """How long a thread has had Numba's compiler, or waited for it: nested calls count once."""

    depth, since, total = 0, 0.0, 0.0
    after: Callable[[], None] | None = None

    def start(self) -> None:
        """Stop the clock."""
        if self.depth == 0:
            self.since = time.perf_counter()
        self.depth += 1

    def end(self) -> None:
        """Let the clock go on, where it is the last end."""
        self.depth -= 1
        if self.depth == 0:
            self.total += time.perf_counter() - self.since
        if self.depth == 0 and self.after is not None:
            after, self.after = self.after, None
            after()


_compiling = _CompilingTime()


def _listen() -> None:
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:
            _compiling.start()

        def on_end(self, event: Any) -> None:
            _compiling.end()

    event.register("numba:compiler_lock", Listener())


# on a Numba without it the clock counts compiling, too: a bound on time may end a first call early
with contextlib.suppress(Exception):
    _listen()


@contextlib.contextmanager
def compiling() -> Iterator[None]:
    """Let the clock of this thread stand still for what takes the place of compiling."""
    _compiling.start()
    try:
        yield
    finally:
        _compiling.end()


def working_time() -> float:
    """Return a clock [s] that stands still while this thread compiles kernels or loads compiled ones.

    Bounds on time are kept by it: what is compiled once per machine counts against nobody's `max_time`.
    """
    return time.perf_counter() - _compiling.total


def after_kernel(call: Callable[[], None]) -> bool:
    """Let a call wait for the kernel that this thread compiles; return False, and do nothing, if it does not.

    For handlers of signals: what they raise inside LLVM's callbacks is swallowed, since C calls these.
    """
    if _compiling.depth == 0:
        return False
    _compiling.after = call
    return True
