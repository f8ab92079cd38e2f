"""`surefoot bench faults`: the largest level of every fault that a trotting robot survives."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli.console import progress_bar
from surefoot.app.cli.output import check_out

QUICK_FAULTS = ("payload", "delay")

if TYPE_CHECKING:
    from benchmarks.faults import FaultRow


def faults(
    robot: Annotated[str, typer.Argument(help="A known robot.")] = "go2",
    fault: Annotated[list[str] | None, typer.Option(help="Only this kind; may be repeated.")] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Trials per level.")] = 20,
    duration: Annotated[float, typer.Option(min=2.5, max=60.0, help="Length of a trial [s].")] = 5.0,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes.")] = 1,
    estimator: Annotated[str, typer.Option(help="Where the state is from: inekf or truth.")] = "inekf",
    quick: Annotated[bool, typer.Option("--quick", help="Two faults, one short trial per level.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Trot through pushes, ice, loads, noise, delay, weak motors and holes; print what is survived.

    A level counts as survived when the robot falls in none of the seeds.
    """
    from benchmarks.faults import measure
    from surefoot.app.cli import extras

    check_out(out)
    extras.require((*extras.robot_packages(robot), "mujoco"))
    if quick:
        fault, seeds, duration = fault or list(QUICK_FAULTS), 1, 2.5
    with progress_bar(not as_json, "bench faults", 1.0) as show:
        rows = measure(robot, fault, seeds, duration, jobs, show, estimator)
    record = {
        "robot": robot,
        "estimator": estimator,
        "seeds": seeds,
        "duration": duration,
        "faults": [asdict(row) for row in rows],
    }
    title = f"{robot} trotting at 0.5 m/s: largest level survived by all of {seeds} seeds"
    report(record, as_json, lambda console: _print(console, title, rows), out=out, name="faults")


def _print(console: Console, title: str, rows: list[FaultRow]) -> None:
    names = ("fault", "survived", "not survived", "unit", "levels tried (survivors / trials)")
    cells = []
    for row in rows:
        tried = ", ".join(f"{level:g}: {ok}/{count}" for level, ok, count in row.tried)
        survived = "none" if row.survived is None else f"{row.survived:g}"
        beyond = "-" if row.next_level is None else f"{row.next_level:g}"
        cells.append((row.title, survived, beyond, row.unit, tried))
    console.print(table(names, cells, title, texts=names[3:]))
