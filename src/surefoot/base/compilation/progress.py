"""Says which tree of kernels is being compiled and how far it is, through the standard library's logging."""

from __future__ import annotations

import logging
import time
from types import FunctionType
from typing import Any

from surefoot.base.compilation.tree import KernelTree

LOG = logging.getLogger("surefoot.compilation")
"""Says what is compiled: the first time that takes long in a process at level WARNING, the others at INFO,
and the way through a tree at DEBUG. A record's `kernel` is the top of the tree, `share` what is done of it.
"""
LONG = 2.0
"""A compilation that should take longer than this [s] is worth a warning."""
RATE = 3.5e-4
"""Seconds per byte of Python's code in a tree of kernels, on a core of 3 GHz: a rough guess."""
AHEAD = "`surefoot warmup` compiles everything ahead."


class CompilationProgress:
    """Says through `LOG` which tree is being compiled and how far it is; counts what was."""

    def __init__(self) -> None:
        self.compiled = 0
        self._running: list[tuple[KernelTree, set[FunctionType], float]] = []
        self._warned = False

    def start(self, tree: KernelTree) -> None:
        """Say that a tree was not found on disk."""
        self._running.append((tree, set(), time.perf_counter()))
        seconds, others = RATE * tree.size, len(tree.functions) - 1
        level = logging.WARNING if seconds > LONG and not self._warned else logging.INFO
        self._warned = self._warned or level == logging.WARNING
        more = f" and {others} kernels below it" if others else ""
        often = f", once per machine: about {seconds:.0f} s. {AHEAD}" if seconds > LONG else ""
        self._say(level, 0.0, f"compiling {tree.name}{more}{often}")

    def passed(self, function: Any) -> None:
        """Say that one of its kernels is translated."""
        if self._running and function not in self._running[-1][1]:
            tree, done, _ = self._running[-1]
            done.add(function)
            # translating is taken for 0.7 of the way; the optimiser, at the end, says nothing of its own
            share = sum(len(f.__code__.co_code) for f in done) / max(tree.size, 1)
            self._say(logging.DEBUG, min(0.7 * share, 0.7), f"translated {function.__name__}")

    def end(self, tree: KernelTree) -> None:
        """Say that it is compiled."""
        self.compiled += 1
        while self._running and self._running[-1][0] is not tree:  # what failed to compile
            self._running.pop()
        if self._running:
            seconds = time.perf_counter() - self._running[-1][2]
            self._say(logging.DEBUG, 1.0, f"compiled {tree.name} in {seconds:.1f} s")
            self._running.pop()

    def _say(self, level: int, share: float, text: str) -> None:
        extra = {"kernel": self._running[-1][0].name, "share": share}
        LOG.log(level, "%s", text, extra=extra)


progress = CompilationProgress()


def compiled_so_far() -> int:
    """Return how many kernels this process has compiled, not loaded, for Python to call."""
    return progress.compiled
