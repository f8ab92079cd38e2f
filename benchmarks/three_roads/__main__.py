"""Print the tables of docs/three-roads.md.

Run: python -m benchmarks.three_roads [--starts N] [--quick] [--json].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import options, show, table
from benchmarks.three_roads.roads import ROADS, Outcome, travel
from benchmarks.three_roads.task import IN_LESS_TIME, SHORT, JumpTask, hopper_jump


def start_table(task: JumpTask, starts: int) -> Table:
    """Return how the roads do from their own start and from random ones."""
    columns = ("road", "own start", "CPU s", "iterations", "cost", "law residual", "misses by",
               "random starts", "CPU s, median", "cost, median")  # fmt: skip
    rows = []
    for name, road in ROADS.items():
        own = travel(road, task, task.problem, None)
        many = [travel(road, task, task.problem, seed) for seed in range(starts)]
        solved = [o for o in many if o.solved]
        rows.append((
            name, _said(own), f"{own.seconds:.1f}", f"{own.iterations}", f"{own.cost:.3g}",
            f"{own.law_residual:.1e}", f"{own.miss:.1e}", f"{len(solved)} of {starts}",
            _median([o.seconds for o in many], ".1f"), _median([o.cost for o in solved], ".3g"),
        ))  # fmt: skip
    return table(columns, rows, f"{task.name}: from its own start, and from {starts} random ones")


def change_table(task: JumpTask, only: int | None = None) -> Table:
    """Return what the roads make of a changed task, with nothing else changed."""
    rows = []
    for change, changed in list(task.variations.items())[:only]:
        problem = changed(task.problem)
        outcomes = [travel(road, task, problem, None) for road in ROADS.values()]
        rows.append((change, *(f"{_said(o)}, {o.seconds:.1f} s" for o in outcomes)))
    title = f"{task.name}: the task is changed, the schedule and the settings are not"
    return table(("change", *ROADS), rows, title)


def schedule_table(task: JumpTask, schedules: Sequence[tuple[int, int]]) -> Table:
    """Return what becomes of schedules by hand where the task has to be done in less time."""
    rows = []
    problem = task.variations[IN_LESS_TIME](task.problem)
    for take_off, touchdown in schedules:
        by_hand = replace(task, take_off=take_off, touchdown=touchdown)
        outcome = travel(ROADS["given schedule"], by_hand, problem, None)
        rows.append((str(take_off), str(touchdown), f"{_said(outcome)}, {outcome.seconds:.1f} s"))
    columns = ("take-off", "touchdown", "given schedule")
    return table(columns, rows, f"{task.name}, {IN_LESS_TIME}: schedules by hand")


def _said(outcome: Outcome) -> str:
    if outcome.solved:
        return "solved"
    return f"misses by {outcome.miss:.2g}" if np.isfinite(outcome.miss) else "lost"


def _median(values: Sequence[float], form: str) -> str:
    return format(float(np.median(values)), form) if values else "-"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = options(__doc__, "two random starts, one change")
    parser.add_argument("--starts", type=int, default=10)
    given = parser.parse_args(arguments)
    show(_tables(hopper_jump(), given.starts, given.quick), given.json, Console(width=160))


def _tables(task: JumpTask, starts: int, quick: bool) -> Iterator[Table]:
    yield start_table(task, 2 if quick else starts)
    yield change_table(task, 1 if quick else None)
    if not quick:
        yield schedule_table(task, SHORT)


if __name__ == "__main__":
    main()
