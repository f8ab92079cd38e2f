"""`surefoot bench walk`: the MPC step on exact cones against QP solvers with pyramids and Clarabel."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras
from surefoot.app.cli.console import progress_bar

if TYPE_CHECKING:
    from benchmarks.timing import Timing
    from benchmarks.walk.race import MpcRow, WalkBench

QUICK_SCENES, QUICK_CALLS = ("trot", "limit"), 4
WIDTH = 150
"""Columns that the tables need."""


def walk(
    quick: Annotated[bool, typer.Option("--quick", help="Two scenes and few calls.")] = False,
    scene: Annotated[list[str] | None, typer.Option(help="Only this scene; may be repeated.")] = None,
    calls: Annotated[int, typer.Option(min=10, max=100_000, help="Calls per scene and method.")] = 150,
    horizon: Annotated[int, typer.Option(min=2, max=100, help="Steps of the horizon.")] = 10,
    robot: Annotated[
        list[str] | None, typer.Option(help="Robot whose steps are timed; may be repeated.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Time the MPC step (ours, QP solvers with pyramids, Clarabel) and a walking controller's whole step."""
    from benchmarks.walk.race import measure
    from surefoot.mechanics.robot import load_robot

    for name in robot or ["go2"]:
        extras.require((*extras.robot_packages(name), "mujoco", "clarabel", "qpsolvers"))
        load_robot(name)  # unknown ones before long work
    names = scene or (list(QUICK_SCENES) if quick else None)
    with progress_bar(not json, "bench walk", 1.0) as show:
        bench = measure(names, QUICK_CALLS if quick else calls, horizon, robot or ["go2"], show)
    report(asdict(bench), json, lambda console: _print(console, bench), WIDTH)


def _print(console: Console, bench: WalkBench) -> None:
    """Print one table per scene, and what its columns mean."""
    from benchmarks.problems.walking import choose_scenes
    from benchmarks.walk.race import ACCURACY

    names = (
        "method", "run as", "median [µs]", "p99", "worst", "ratio", "error [N]", "to exact [N]",
        "outside [N]", "lost", "cost",
    )  # fmt: skip
    for scene in choose_scenes(list(dict.fromkeys(row.scene for row in bench.rows))):
        title = f"{scene.name}: {scene.title}; {bench.horizon} steps, {bench.calls} calls"
        cells = [_cells(row) for row in bench.rows if row.scene == scene.name]
        console.print(table(names, cells, title, left=2))
    steps = [(s.robot, s.call, *_times(s.timing), str(s.timing.calls)) for s in bench.steps]
    heads = ("robot", "call", "median [µs]", "p99", "worst", "calls")
    console.print(table(heads, steps, "on the inputs of a real walk", left=2))
    console.print(
        "ratio: median time over ours. error: distance of all forces to the method's own optimum, 95th "
        f"percentile (! where not within {ACCURACY} N). to exact: the first step's forces to the optimum on "
        "exact cones, likewise. outside: largest violation of an exact cone or a bound. lost: friction left "
        "unused where the optimum uses all. cost: above the exact optimum's. Our time is the whole call from "
        "Python, model included; a rival's is its own update and solve, with its matrices ready.",
        soft_wrap=True,
    )


def _times(timing: Timing) -> list[str]:
    return [f"{1e6 * t:.0f}" for t in (timing.median, timing.p99, timing.worst)]


def _cells(row: MpcRow) -> list[str]:
    lost = "-" if row.lost != row.lost else f"{100.0 * max(row.lost, 0.0):.1f} %"
    return [
        row.method,
        row.variant,
        *_times(row.timing),
        f"{row.ratio:.1f}",
        f"{row.error:.1g}" + ("" if row.accurate else " !"),
        f"{row.first_error:.2g}",
        f"{row.violation:.1g}",
        lost,
        f"{100.0 * max(row.cost, 0.0):.2g} %",
    ]
