"""`surefoot bench speeds`: how fast robots walk within the limits of their joints."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli.console import progress_bar
from surefoot.app.cli.output import check_out

if TYPE_CHECKING:
    from benchmarks.walk.speeds import SpeedRow

ROBOTS = "robots"
"""Stands for all the other robots, each at its own pace."""
WIDTH = 150
"""Columns that the table needs."""


def speeds(
    robot: Annotated[str, typer.Option(help="A robot, or 'robots' for others at 0.5 sqrt(g h).")] = "go2",
    gait: Annotated[str, typer.Option(help="Gait by name.")] = "trot",
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Runs of each velocity.")] = 20,
    world: Annotated[str, typer.Option(help="mujoco or rigid.")] = "mujoco",
    quick: Annotated[bool, typer.Option("--quick", help="One velocity, one seed.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Walk at a ladder of velocities; print velocity errors, slip, joint speeds, torques and their rates."""
    from benchmarks.walk.speeds import LADDER, measure, pace_of
    from benchmarks.walks import QUADRUPEDS
    from surefoot.app.cli import extras

    check_out(out)
    names = QUADRUPEDS if robot == ROBOTS else (robot,)
    for name in names:
        extras.require((*extras.robot_packages(name), *(("mujoco",) if world == "mujoco" else ())))
    if quick:
        names, seeds = names[:1], 1
    rows: list[SpeedRow] = []
    for name in names:
        ladder = LADDER if name == "go2" else (pace_of(name),)
        with progress_bar(not as_json, f"walk {name}", 1.0) as show:
            some = ladder[1:2] if quick and len(ladder) > 1 else ladder
            rows += measure(name, some, seeds, world, gait, show)
    record = [asdict(row) for row in rows]
    report(record, as_json, lambda console: _print(console, rows), WIDTH, out, "speeds")


def _print(console: Console, rows: list[SpeedRow]) -> None:
    names = (
        "robot", "wanted", "walked", "good", "lawful", "error", "slip [mm]", "joint speed", "torque",
        "rate [N m/ms]", "99.9 %", "laws",
    )  # fmt: skip
    cells = []
    for row in rows:
        wanted = ", ".join(f"{v:g}" for v in row.wanted)
        if row.wanted != row.commanded:
            wanted += " -> " + ", ".join(f"{v:.3g}" for v in row.commanded)
        cells.append((
            row.robot, wanted, f"{row.walked} of {row.seeds}", str(row.good), str(row.lawful),
            f"{row.error:.3f}", f"{1e3 * row.slip:.1f}", f"{row.speed_use:.2f}", f"{row.torque_use:.2f}",
            f"{row.rate:.1f}", f"{row.usual_rate:.1f}", "; ".join(row.laws) or "none",
        ))  # fmt: skip
    console.print(table(names, cells, "Velocities within limits; worst of all seeds", texts=["laws"]))
    console.print(
        "good: upright, velocity over the last 2.5 s within 3 % or 0.02, slip under 10 mm, joint speeds "
        "within limits. rate: largest change of a torque in a step, and that exceeded in 0.1 % of the steps.",
        soft_wrap=True,
    )
