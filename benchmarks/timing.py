"""Timing that can be compared: one core, warmed up, median and 99th percentile."""

from __future__ import annotations

import gc
import os
import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.motion.control.controller import Command, Controller, RobotState

Answer = TypeVar("Answer")
Key = TypeVar("Key", bound=Hashable)


@dataclass(frozen=True)
class Timing:
    """Wall time per call [s]."""

    median: float
    p99: float
    worst: float
    calls: int

    @staticmethod
    def of(seconds: ArrayLike) -> Timing:
        """Summarise the wall times of single calls [s]."""
        s = np.asarray(seconds, dtype=np.float64)
        return Timing(float(np.median(s)), float(np.percentile(s, 99)), float(s.max()), int(s.size))


@contextmanager
def one_core() -> Iterator[None]:
    """Pin the process to one core (the last it may use) and hold the garbage collector meanwhile."""
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    collecting = gc.isenabled()
    try:
        if cores:
            os.sched_setaffinity(0, {max(cores)})
        gc.disable()
        yield
    finally:
        if cores:
            os.sched_setaffinity(0, cores)
        if collecting:
            gc.enable()


def best_of(
    function: Callable[[Any], Answer], items: Sequence[Any], passes: int = 1, warm_up: int = 20,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[FloatArray, list[Answer]]:  # fmt: skip
    """Return the least time of `function(item)` over some passes (items,) [s], and the last answers.

    The least, for the rest is other work on the machine. `warm_up` calls on the first items come before.
    """
    for item in items[:warm_up]:
        function(item)
    seconds = np.full(len(items), np.inf)
    answers: list[Answer] = []
    for _ in range(passes):
        answers = []
        for k, item in enumerate(items):
            start = clock()
            answer = function(item)
            seconds[k] = min(seconds[k], clock() - start)
            answers.append(answer)
    return seconds, answers


def least_time(
    function: Callable[[], Any], repeats: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return the time of the fastest of so many calls [s]."""
    return float(best_of(lambda _: function(), [None], repeats, warm_up=0, clock=clock)[0][0])


def time_calls(function: Callable[[Any], Any], items: Sequence[Any], warm_up: int = 20) -> Timing:
    """Time `function(item)` for every item, after `warm_up` calls on the first items."""
    return Timing.of(best_of(function, items, warm_up=warm_up)[0])


def interleaved(
    calls: Mapping[Key, Callable[[int], Any]], budget: float = 0.1, most: int = 200, least: int = 3
) -> dict[Key, Timing]:
    """Time functions of a turn's number in turns, so that other work on the machine strikes all alike.

    Parameters
    ----------
    calls
        What to time, by name.
    budget
        About how long each may take in all [s].
    most, least
        Bounds on the number of calls of each; one that takes ten budgets is made once.
    """
    clock = time.perf_counter
    seconds: dict[Key, list[float]] = {key: [] for key in calls}
    spent = dict.fromkeys(calls, 0.0)
    block = 10  # calls in a row: the first of a block pays for cold caches
    for turn in range(0, most, block):
        for key, call in calls.items():
            for k in range(turn, turn + block):
                if spent[key] > budget and (k >= least or spent[key] > 10.0 * budget):
                    break
                start = clock()
                call(k)
                took = clock() - start
                seconds[key].append(took)
                spent[key] += took
    return {key: Timing.of(s) for key, s in seconds.items()}


class Stopwatch(Controller):
    """A controller whose steps are timed.

    Parameters
    ----------
    inner
        The controller.

    Attributes
    ----------
    cpu, wall
        Processor and wall time of every step so far [s].
    """

    def __init__(self, inner: Controller) -> None:
        self.inner = inner
        self.channels, self.facts = inner.channels, inner.facts
        self.cpu: list[float] = []
        self.wall: list[float] = []

    def reset(self) -> None:
        """Forget the past."""
        self.inner.reset()
        self.cpu.clear()
        self.wall.clear()

    def warm_up(self, state: RobotState) -> None:
        """Compile or load all that a step calls."""
        self.inner.warm_up(state)

    def step(self, state: RobotState) -> Command:
        """Return the controller's command."""
        wall, cpu = time.perf_counter(), time.process_time()
        command = self.inner.step(state)
        self.cpu.append(time.process_time() - cpu)
        self.wall.append(time.perf_counter() - wall)
        return command
