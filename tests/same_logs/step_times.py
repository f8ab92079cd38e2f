"""What a walking controller's step costs in two trees, by `surefoot bench walk` in CPU time, in turn."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import NamedTuple

from tests.same_logs.recording import environment

CALL = "whole step"
"""Row of the benchmark: all that the controller does between a state and its torques."""
PROGRAM = """
import contextlib, io, runpy, sys, time
time.perf_counter = time.thread_time  # other work on the machine costs no time of this thread
sys.argv = ["surefoot", "bench", "walk", "--quick", "--scene", "trot", "--json"]
for line in sys.stdin:
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.suppress(SystemExit):
        runpy.run_module("surefoot", run_name="__main__")
    print(told.getvalue().replace("\\n", " "), flush=True)
"""


class StepTime(NamedTuple):
    """CPU time of a step over a walk [µs]."""

    median: float
    p99: float


class Bench:
    """A tree's benchmark in a process of its own, which waits between runs: a machine's speed changes by a
    third within a minute, and runs that follow each other at once are told apart best.

    Parameters
    ----------
    tree
        Folder of the sources.
    """

    def __init__(self, tree: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM], cwd=tree, env=environment(tree), text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.communicate()

    def run(self) -> StepTime:
        """Return what the benchmark says now."""
        asked, told = self._process.stdin, self._process.stdout
        assert asked is not None
        assert told is not None
        print(file=asked, flush=True)
        rows = json.loads(told.readline())["steps"]
        timing = next(row for row in rows if row["call"] == CALL)["timing"]
        return StepTime(1e6 * timing["median"], 1e6 * timing["p99"])


def race(first: Path, second: Path, pairs: int) -> None:
    """Print both trees' step times: pairs of runs, each tree first in every other one, and their medians."""
    trees, times = (first.resolve(), second.resolve()), (list[StepTime](), list[StepTime]())
    with ExitStack() as stack:
        benches = [stack.enter_context(Bench(tree)) for tree in trees]
        for bench in benches:
            bench.run()  # compiles or loads what the others measure
        for k in range(pairs):
            for at in (0, 1) if k % 2 == 0 else (1, 0):
                times[at].append(benches[at].run())
            print(f"pair {k + 1}: " + ", ".join(_said(each[-1]) for each in times), flush=True)
    for tree, each in zip(trees, times, strict=True):
        print(f"{tree}: {_said(StepTime(*(median(column) for column in zip(*each, strict=True))))}")
    ratios = [(b.median / a.median, b.p99 / a.p99) for a, b in zip(*times, strict=True)]
    middle = [median(column) for column in zip(*ratios, strict=True)]
    print(f"second over first, median of the pairs: median {middle[0]:.3f}, p99 {middle[1]:.3f}")


def _said(time: StepTime) -> str:
    return f"median {time.median:.1f} p99 {time.p99:.1f} us"
