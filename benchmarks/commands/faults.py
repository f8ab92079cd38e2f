"""`surefoot bench faults`: the largest level of every fault that a trotting robot survives."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from surefoot.cli.console import plain_console
from surefoot.cli.estimators import EstimatorName
from surefoot.cli.output import check_out, new_run_folder, to_json
from surefoot.cli.progress import progress_bar

QUICK_FAULTS = ("payload", "delay")

if TYPE_CHECKING:
    from benchmarks.faults import FaultRow


def faults(
    robot: Annotated[str, typer.Argument(help="A known robot.")] = "go2",
    fault: Annotated[list[str] | None, typer.Option(help="Only this kind; may be repeated.")] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Trials per level.")] = 20,
    duration: Annotated[float, typer.Option(min=2.5, max=60.0, help="Length of a trial [s].")] = 5.0,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes.")] = 1,
    estimator: EstimatorName = "inekf",
    quick: Annotated[bool, typer.Option("--quick", help="Two faults, one short trial per level.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Trot through pushes, ice, loads, noise, delay, weak motors and holes; print what is survived.

    A level counts as survived when the robot falls in none of the seeds.
    """
    from benchmarks.faults import measure
    from surefoot.cli import extras

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
    if as_json:
        print(to_json(record))
    else:
        _print(robot, seeds, rows)
    if out is not None:
        folder = new_run_folder(out, "bench-faults")
        (folder / "faults.json").write_text(to_json(record) + "\n", encoding="utf-8")
        typer.echo(f"written: {folder / 'faults.json'}", err=True)


def _print(robot: str, seeds: int, rows: list[FaultRow]) -> None:
    from rich.table import Table

    table = Table(title=f"{robot} trotting at 0.5 m/s: largest level survived by all of {seeds} seeds")
    for name in ("fault", "survived", "not survived", "unit", "levels tried (survivors / trials)"):
        table.add_column(name, justify="right" if name in ("survived", "not survived") else "left")
    for row in rows:
        tried = ", ".join(f"{level:g}: {ok}/{count}" for level, ok, count in row.tried)
        values = ["none" if v is None else f"{v:g}" for v in (row.survived, row.next_level)]
        table.add_row(row.title, values[0], values[1] if row.next_level is not None else "-", row.unit, tried)
    plain_console().print(table)
