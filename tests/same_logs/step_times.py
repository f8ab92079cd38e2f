"""What a walking controller's step costs in two trees, by `surefoot bench walk` in CPU time, in turn."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from statistics import median
from typing import NamedTuple

from tests.same_logs.recording import environment

CALL = "whole step"
"""Row of the benchmark: all that the controller does between a state and its torques."""
PROGRAM = """
import runpy, sys, time
time.perf_counter = time.thread_time  # other work on the machine costs no time of this thread
sys.argv = ["surefoot", "bench", "walk", "--quick", "--scene", "trot", "--json"]
runpy.run_module("surefoot", run_name="__main__")
"""


class StepTime(NamedTuple):
    """CPU time of a step over a walk [µs]."""

    median: float
    p99: float


def step_time(tree: Path) -> StepTime:
    """Return what a tree's benchmark says; its kernels are compiled already, or its time says nothing."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=tree, env=environment(tree), capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    timing = next(row for row in json.loads(done.stdout)["steps"] if row["call"] == CALL)["timing"]
    return StepTime(1e6 * timing["median"], 1e6 * timing["p99"])


def race(first: Path, second: Path, pairs: int) -> None:
    """Print both trees' step times: every pair of runs, each tree first in every other one, and medians."""
    trees, times = (first.resolve(), second.resolve()), (list[StepTime](), list[StepTime]())
    for tree in trees:
        step_time(tree)  # compiles
    for k in range(pairs):
        for at in (0, 1) if k % 2 == 0 else (1, 0):
            times[at].append(step_time(trees[at]))
        print(f"pair {k + 1}: " + ", ".join(_said(each[-1]) for each in times), flush=True)
    middle = [StepTime(*(median(column) for column in zip(*each, strict=True))) for each in times]
    for tree, each in zip(trees, middle, strict=True):
        print(f"{tree}: {_said(each)}")
    ratios = [second / first for first, second in zip(*middle, strict=True)]
    print(f"second over first: median {ratios[0]:.3f}, p99 {ratios[1]:.3f}")


def _said(time: StepTime) -> str:
    return f"median {time.median:.1f} p99 {time.p99:.1f} us"
