"""`surefoot bench rigid`: a robot dropped in the rigid world and in MuJoCo, with the same controller."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli import extras
from surefoot.app.cli.console import show
from surefoot.base.arrays import real_number

if TYPE_CHECKING:
    from benchmarks.rigid_world import DropResult


def rigid(
    robot: Annotated[str, typer.Argument(help="A known robot.")] = "go2",
    height: Annotated[float, typer.Option(min=0.0, help="Height of the drop [m].")] = 0.3,
    seconds: Annotated[float, typer.Option(min=1.0, help="Simulated time until rest is judged [s].")] = 4.0,
    quick: Annotated[bool, typer.Option("--quick", help="Judge rest after one second.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Drop a robot with the standing controller: cost of a simulated second, resting force, energy."""
    from benchmarks.rigid_world import drop

    extras.require((*extras.robot_packages(robot), "mujoco"))
    seconds = 1.0 if quick else real_number("--seconds", seconds, low=1.0, high=3600.0)
    real_number("--height", height, low=0.0, high=100.0)
    results = [drop(world, robot, height, seconds) for world in ("rigid", "mujoco")]
    title = f"{robot} dropped from {height:g} m, dt = 1 ms"
    show([asdict(r) for r in results], json, lambda console, _: _print(console, title, results))


def _print(console: Console, title: str, results: list[DropResult]) -> None:
    rows = {
        "wall time of 1 s, controller included": [f"{r.wall:.3f} s" for r in results],
        "world step, median (99 %)": [
            f"{1e6 * r.step.median:.0f} ({1e6 * r.step.p99:.0f}) µs" for r in results
        ],
        "controller step, median (99 %)": [
            f"{1e6 * r.controller.median:.0f} ({1e6 * r.controller.p99:.0f}) µs" for r in results
        ],
        "most contact points at once": [str(r.contacts) for r in results],
        "resting force against m g, worst": [f"{100 * r.weight_error:.3f} %" for r in results],
        "deepest penetration": [f"{1e3 * r.penetration:.4f} mm" for r in results],
        "energy made from nothing": [
            "-" if r.energy_made != r.energy_made else f"{max(0.0, r.energy_made):.1e} J" for r in results
        ],
        "speed at the end": [f"{r.rest_speed:.4f}" for r in results],
    }
    cells = [(name, *values) for name, values in rows.items()]
    console.print(table(("", *(r.world for r in results)), cells, title))
    console.print(f"rigid / mujoco wall time: {results[0].wall / results[1].wall:.2f}")
