"""`surefoot bench walk`: the MPC step on exact cones against QP solvers with pyramids and Clarabel."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from surefoot.cli import extras
from surefoot.cli.console import plain_console
from surefoot.cli.output import check_out, new_run_folder, to_json
from surefoot.cli.progress import progress_bar

if TYPE_CHECKING:
    from benchmarks.walk.race import MpcRow, WalkBench

QUICK_SCENES, QUICK_CALLS = ("trot", "limit"), 4
PAGE_WIDTH = 150
"""Width of tables that do not go to a terminal."""


def walk(
    quick: Annotated[bool, typer.Option("--quick", help="Two scenes and few calls.")] = False,
    scene: Annotated[list[str] | None, typer.Option(help="Only this scene; may be repeated.")] = None,
    calls: Annotated[int, typer.Option(min=10, max=100_000, help="Calls per scene and method.")] = 150,
    horizon: Annotated[int, typer.Option(min=2, max=40, help="Steps of the horizon.")] = 10,
    robot: Annotated[
        list[str] | None, typer.Option(help="Robot whose steps are timed; may be repeated.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write a picture and the JSON to a new folder below this one.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Time the MPC step (ours, QP solvers with pyramids, Clarabel) and a walking controller's whole step."""
    from benchmarks.walk.race import measure
    from surefoot.robot import load_robot

    check_out(out)
    for name in robot or ["go2"]:
        extras.require((*extras.robot_packages(name), "mujoco", "clarabel", "qpsolvers"))
        load_robot(name)  # unknown ones before long work
    names = scene or (list(QUICK_SCENES) if quick else None)
    with progress_bar(not json, "bench walk", 1.0) as show:
        bench = measure(names, QUICK_CALLS if quick else calls, horizon, robot or ["go2"], show)
    if json:
        print(to_json(asdict(bench)))
    else:
        _print(bench)
    if out is not None:
        from benchmarks.walk.pictures import plot_mpc_bench

        folder = new_run_folder(out, "bench-walk")
        (folder / "walk.json").write_text(to_json(asdict(bench)) + "\n", encoding="utf-8")
        typer.echo(f"picture: {plot_mpc_bench(bench, folder)}", err=True)


def _print(bench: WalkBench) -> None:
    """Print one table per scene, and what its columns mean."""
    from benchmarks.walk.race import ACCURACY
    from surefoot.problems.walking import choose_scenes

    console = plain_console(width=None if sys.stdout.isatty() else PAGE_WIDTH)
    for scene in choose_scenes(list(dict.fromkeys(row.scene for row in bench.rows))):
        table = Table(
            "method", "run as", "median [µs]", "p99", "worst", "ratio", "error [N]", "to exact [N]",
            "outside [N]", "lost", "cost",
            title=f"{scene.name}: {scene.title}; {bench.horizon} steps, {bench.calls} calls",
        )  # fmt: skip
        for row in bench.rows:
            if row.scene == scene.name:
                table.add_row(*_cells(row))
        console.print(table)
    table = Table(
        "robot", "call", "median [µs]", "p99", "worst", "calls", title="on the inputs of a real walk"
    )
    for step in bench.steps:
        times = (f"{1e6 * t:.0f}" for t in (step.timing.median, step.timing.p99, step.timing.worst))
        table.add_row(step.robot, step.call, *times, str(step.timing.calls))
    console.print(table)
    console.print(
        "ratio: median time over ours. error: distance of all forces to the method's own optimum, 95th "
        f"percentile (! where not within {ACCURACY} N). to exact: the first step's forces to the optimum on "
        "exact cones, likewise. outside: largest violation of an exact cone or a bound. lost: friction left "
        "unused where the optimum uses all. cost: above the exact optimum's. Our time is the whole call from "
        "Python, model included; a rival's is its own update and solve, with its matrices ready.",
        soft_wrap=True,
    )


def _cells(row: MpcRow) -> list[str]:
    lost = "-" if row.lost != row.lost else f"{100.0 * max(row.lost, 0.0):.1f} %"
    return [
        row.method,
        row.variant,
        f"{1e6 * row.timing.median:.0f}",
        f"{1e6 * row.timing.p99:.0f}",
        f"{1e6 * row.timing.worst:.0f}",
        f"{row.ratio:.1f}",
        f"{row.error:.1g}" + ("" if row.accurate else " !"),
        f"{row.first_error:.2g}",
        f"{row.violation:.1g}",
        lost,
        f"{100.0 * max(row.cost, 0.0):.2g} %",
    ]
