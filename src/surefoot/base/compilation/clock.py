"""A clock that stands still while kernels are compiled.

It uses the one part of `numba.core` that is documented for programs to use, Numba's "Event API".
"""

from __future__ import annotations

import contextlib
import threading
import time
from typing import Any


class _CompilingTime(threading.local):
    """How long a thread has had Numba's compiler, or waited for it: nested calls count once."""

    depth, since, total = 0, 0.0, 0.0

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


def working_time() -> float:
    """Return a clock [s] that stands still while this thread compiles kernels or loads compiled ones.

    Bounds on time are kept by it: what is compiled once per machine counts against nobody's `max_time`.
    """
    return time.perf_counter() - _compiling.total
