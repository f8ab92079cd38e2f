"""Print the tables of docs/three-methods.md.

Run: python -m benchmarks.three_methods [--starts N] [--quick] [--json].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import options, show, table
from benchmarks.three_methods.methods import METHODS, Outcome, solve_task
from benchmarks.three_methods.task import IN_LESS_TIME, SHORT, JumpTask, hopper_jump


def start_table(task: JumpTask, starts: int) -> Table:
    """Return how the methods do from their own start and from random ones."""
    columns = ("method", "own start", "CPU s", "iterations", "cost", "law residual", "misses by",
               "random starts", "CPU s, median", "cost, median")  # fmt: skip
    rows = []
    for name, method in METHODS.items():
        own = solve_task(method, task, task.problem, None)
        many = [solve_task(method, task, task.problem, seed) for seed in range(starts)]
        solved = [o for o in many if o.solved]
        rows.append((
            name, _said(own), f"{own.seconds:.1f}", f"{own.iterations}", f"{own.cost:.3g}",
            f"{own.law_residual:.1e}", f"{own.miss:.1e}", f"{len(solved)} of {starts}",
            _median([o.seconds for o in many], ".1f"), _median([o.cost for o in solved], ".3g"),
        ))  # fmt: skip
    return table(columns, rows, f"{task.name}: from its own start, and from {starts} random ones")


def change_table(task: JumpTask, only: int | None = None) -> Table:
    """Return what the methods make of a changed task, with nothing else changed."""
    rows = []
    for change, changed in list(task.variations.items())[:only]:
        problem = changed(task.problem)
        outcomes = [solve_task(method, task, problem, None) for method in METHODS.values()]
        rows.append((change, *(f"{_said(o)}, {o.seconds:.1f} s" for o in outcomes)))
    title = f"{task.name}: the task is changed, the schedule and the settings are not"
    return table(("change", *METHODS), rows, title)


def schedule_table(task: JumpTask, schedules: Sequence[tuple[int, int]]) -> Table:
    """Return what becomes of schedules by hand where the task has to be done in less time."""
    rows = []
    problem = task.variations[IN_LESS_TIME](task.problem)
    for take_off, touchdown in schedules:
        by_hand = replace(task, take_off=take_off, touchdown=touchdown)
        outcome = solve_task(METHODS["given schedule"], by_hand, problem, None)
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
