"""What the commands that simulate share: their options, the checks of those, the scenario they make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

if TYPE_CHECKING:
    from surefoot.simulation.scenario import Scenario

Friction: TypeAlias = Annotated[float, typer.Option(help="Friction of the ground.")]
Duration: TypeAlias = Annotated[float, typer.Option(help="Simulated time [s].")]
Payload: TypeAlias = Annotated[
    str,
    typer.Option(help="KG or KG@X,Y,Z: mass and its place on the base that no controller is told [kg], [m]."),
]
Pushes: TypeAlias = Annotated[
    list[str] | None, typer.Option(help="T:FX,FY,FZ:DURATION [s, N, s]; repeatable.")
]
IcePatches: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        help="T:MU, friction from time T [s] on, or X0,Y0,X1,Y1:MU, friction in a rectangle [m]; repeatable."
    ),
]
Seed: TypeAlias = Annotated[
    int | None, typer.Option(help="Seed of a small random velocity at the start and of all noise.")
]


@dataclass(frozen=True)
class Leaving:
    """What a run leaves, and where."""

    out: Annotated[Path, typer.Option(help="Parent of the run's new folder.")] = Path("runs")
    video: Annotated[bool, typer.Option("--video/--no-video", help="Film the run.")] = True
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw plots and a report.")] = True
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False


def check_numbers(mu: float, duration: float, shortest: float, seed: int | None) -> None:
    """Refuse numbers that no run can have; `shortest` is the least duration that says something [s]."""
    from surefoot.cli import parsing

    parsing.friction("--mu", mu)
    parsing.duration(duration, shortest)
    parsing.seed(seed)


def scenario_of(
    duration: float,
    mu: float,
    push: list[str] | None,
    ice: list[str] | None,
    seed: int | None,
    **more: Any,
) -> Scenario:
    """Return what happens to the robot, or raise for what lies past the end."""
    from surefoot.cli import parsing
    from surefoot.simulation.scenario import Ice, IcePatch, Scenario

    pushes, given = parsing.each(parsing.push, push), parsing.each(parsing.ice, ice)
    changes = [one for one in given if isinstance(one, Ice)]
    patches = [one for one in given if isinstance(one, IcePatch)]
    parsing.within_run("--push", push, [event.start for event in pushes], duration)
    timed = [text for text, one in zip(ice or [], given, strict=True) if isinstance(one, Ice)]
    parsing.within_run("--ice", timed, [event.start for event in changes], duration)
    return Scenario(duration, mu, pushes, changes, seed, patches=patches, **more)


def require(robot: str | None, urdf: Path | None, packages: Sequence[str], leaving: Leaving) -> None:
    """Raise for all optional packages at once if one that a run cannot do without is missing."""
    from surefoot.cli import extras

    named = robot if urdf is None else str(urdf.absolute())
    needed = (*extras.robot_packages(named), *packages)
    drawn = ["matplotlib"] if leaving.report else []
    extras.require(needed, (*(extras.FILM if leaving.video else ()), *drawn))
