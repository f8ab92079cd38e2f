"""Print the tables and draw the picture of docs/gradients.md.

Run: python -m benchmarks.gradients [--quick] [--out FOLDER] [--json].
"""

from __future__ import annotations

import argparse
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
from benchmarks.printing import show

SMOOTHINGS, STIFFNESSES = np.array([1e-3, 1e-2, 1e-1]), np.array([1e3, 1e4])
"""[W] and [N/m]; the middle smoothing and the last stiffness are drawn."""


def tasks() -> list[Task]:
    """Return the tasks, the robot's last."""
    return [*(of_system(s) for s in (Ball(), Block(), Hopper(), Slide())), of_landing(Landing())]


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title)
    for name in ("road", *columns):
        table.add_column(name, justify="left" if name == "road" else "right")
    return table


def bias_table(grid: Grid, points: int) -> Table:
    """Return the table of biases and spreads of a task."""
    names = ("bias, exact slope", "bias, smoothed loss", "spread of a sample", "wrong way")
    table = _table(f"{grid.task.name}: slopes at {points} points", *names)
    for row in compare(grid, points, SMOOTHINGS, STIFFNESSES):
        numbers = (row.bias_exact, row.bias_smoothed, row.spread, row.wrong_way)
        table.add_row(row.road, *(f"{100 * x:.3g} %" for x in numbers))
    return table


def search_table(grid: Grid, starts: int, iterations: int) -> Table:
    """Return the table of the searches of a task."""
    names = ("arrived", "off the best (median)", "rollouts", "CPU s a search")
    table = _table(f"{grid.task.name}: {iterations} steps downhill from {starts} starts", *names)
    begin = time.process_time()
    for row in race(grid, starts, iterations):
        spent = (time.process_time() - begin) / starts
        arrived, off = f"{row.arrived} of {row.starts}", f"{100 * row.off:.2g} %"
        table.add_row(row.road, arrived, off, f"{row.rollouts}", f"{spent:.2f}")
        begin = time.process_time()
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables of every task and draw the picture."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gradients", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one task, few points")
    parser.add_argument("--out", type=Path, help="folder for the picture")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
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
