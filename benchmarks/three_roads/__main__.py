"""Print the tables of docs/three-roads.md.

Run: python -m benchmarks.three_roads [--task hopper|go2] [--starts N] [--quick] [--json].
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import show
from benchmarks.three_roads.roads import ROADS, Outcome, travel
from benchmarks.three_roads.task import IN_LESS_TIME, SHORT, TASKS, JumpTask


def start_table(task: JumpTask, starts: int) -> Table:
    """Return how the roads do from their own start and from random ones."""
    table = Table(title=f"{task.name}: from its own start, and from {starts} random ones")
    columns = ("road", "own start", "CPU s", "iterations", "cost", "law residual", "misses by",
               "random starts", "CPU s, median", "cost, median")  # fmt: skip
    for name in columns:
        table.add_column(name, justify="left" if name == "road" else "right")
    for name, road in ROADS.items():
        own = travel(road, task, task.problem, None)
        many = [travel(road, task, task.problem, seed) for seed in range(starts)]
        solved = [o for o in many if o.solved]
        table.add_row(
            name, _said(own), f"{own.seconds:.1f}", f"{own.iterations}", f"{own.cost:.3g}",
            f"{own.law_residual:.1e}", f"{own.miss:.1e}", f"{len(solved)} of {starts}",
            _median([o.seconds for o in many], ".1f"), _median([o.cost for o in solved], ".3g"),
        )  # fmt: skip
    return table


def change_table(task: JumpTask, only: int | None = None) -> Table:
    """Return what the roads make of a changed task, with nothing else changed."""
    table = Table(title=f"{task.name}: the task is changed, the schedule and the settings are not")
    table.add_column("change")
    for name in ROADS:
        table.add_column(name, justify="right")
    for change, changed in list(task.variations.items())[:only]:
        problem = changed(task.problem)
        outcomes = [travel(road, task, problem, None) for road in ROADS.values()]
        table.add_row(change, *(f"{_said(o)}, {o.seconds:.1f} s" for o in outcomes))
    return table


def schedule_table(task: JumpTask, schedules: Sequence[tuple[int, int]]) -> Table:
    """Return what becomes of schedules by hand where the task has to be done in less time."""
    table = Table(title=f"{task.name}, {IN_LESS_TIME}: schedules by hand")
    for column in ("take-off", "touchdown", "given schedule"):
        table.add_column(column, justify="right")
    problem = task.variations[IN_LESS_TIME](task.problem)
    for take_off, touchdown in schedules:
        by_hand = replace(task, take_off=take_off, touchdown=touchdown)
        outcome = travel(ROADS["given schedule"], by_hand, problem, None)
        table.add_row(str(take_off), str(touchdown), f"{_said(outcome)}, {outcome.seconds:.1f} s")
    return table


def _said(outcome: Outcome) -> str:
    if outcome.solved:
        return "solved"
    return f"misses by {outcome.miss:.2g}" if np.isfinite(outcome.miss) else "lost"


def _median(values: Sequence[float], form: str) -> str:
    return format(float(np.median(values)), form) if values else "-"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.three_roads", description=__doc__)
    parser.add_argument("--task", choices=sorted(TASKS), default="hopper")
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--quick", action="store_true", help="two random starts, one change")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    show(_tables(TASKS[given.task](), given.starts, given.quick), given.json, Console(width=160))


def _tables(task: JumpTask, starts: int, quick: bool) -> Iterator[Table]:
    yield start_table(task, 2 if quick else starts)
    yield change_table(task, 1 if quick else None)
    if IN_LESS_TIME in task.variations and not quick:
        yield schedule_table(task, SHORT)


if __name__ == "__main__":
    main()
