"""Print the tables and draw the picture of docs/reports/gradients.md.

Run: python -m benchmarks.gradients [--quick] [--out FOLDER] [--json].
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from benchmarks.gradients.estimators import Grid, Task, compare, of_landing, of_system
from benchmarks.gradients.landing import Landing
from benchmarks.gradients.pictures import draw_landscapes
from benchmarks.gradients.search import race
from benchmarks.gradients.tasks import Ball, Block, Hopper, Slide
from benchmarks.printing import options, show, table

SMOOTHINGS, STIFFNESSES = np.array([1e-3, 1e-2, 1e-1]), np.array([1e3, 1e4])
"""[W] and [N/m]; the middle smoothing and the last stiffness are drawn."""


def tasks() -> list[Task]:
    """Return the tasks, the robot's last."""
    return [*(of_system(s) for s in (Ball(), Block(), Hopper(), Slide())), of_landing(Landing())]


def bias_table(grid: Grid, points: int) -> Table:
    """Return the table of biases and spreads of a task."""
    names = ("method", "bias, exact slope", "bias, smoothed loss", "spread of a sample", "wrong way")
    found = compare(grid, points, SMOOTHINGS, STIFFNESSES)
    rows = [(method, *(f"{100 * x:.3g} %" for x in numbers)) for method, *numbers in found]
    return table(names, rows, f"{grid.task.name}: slopes at {points} points")


def search_table(grid: Grid, starts: int, iterations: int) -> Table:
    """Return the table of the searches of a task."""
    begin, rows = time.process_time(), []
    for row in race(grid, starts, iterations):
        spent = (time.process_time() - begin) / starts
        arrived, off = f"{row.arrived} of {row.starts}", f"{100 * row.off:.2g} %"
        rows.append((row.method, arrived, off, f"{row.rollouts}", f"{spent:.2f}"))
        begin = time.process_time()
    names = ("method", "arrived", "off the best (median)", "rollouts", "CPU s a search")
    return table(names, rows, f"{grid.task.name}: {iterations} steps downhill from {starts} starts")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables of every task and draw the picture."""
    parser = options(__doc__, "one task, few points")
    parser.add_argument("--out", type=Path, help="folder for the picture")
    given = parser.parse_args(arguments)
    chosen = tasks()[1:2] if given.quick else tasks()
    fine, points, starts, iterations = (25, 5, 2, 4) if given.quick else (151, 21, 4, 20)
    console, grids = Console(stderr=given.json), list[Grid]()

    def tables() -> Iterator[Table]:
        for task in chosen:
            with Progress(console=console, transient=True) as progress:
                bar = progress.add_task(task.name, total=fine)
                grids.append(Grid(task, fine, partial(progress.advance, bar)))
            yield bias_table(grids[-1], points)
            yield search_table(grids[-1], starts, iterations)

    show(tables(), given.json, console)
    if given.out is not None:
        given.out.mkdir(parents=True, exist_ok=True)
        smoothing, stiffness = float(SMOOTHINGS[1]), float(STIFFNESSES[-1])
        console.print(f"picture: {draw_landscapes(grids, smoothing, stiffness, given.out / 'gradients.png')}")


if __name__ == "__main__":
    main()
