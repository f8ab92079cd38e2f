"""Options that several commands have in common, each defined once, and the checks of those of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from surefoot.arrays import real_number
from surefoot.cli import parsing
from surefoot.errors import ProblemError
from surefoot.simulation.worlds import WORLDS

if TYPE_CHECKING:
    from surefoot.cli.scenario_file import ScenarioFile
    from surefoot.simulation.scenario import Scenario
    from surefoot.terrain import Terrain

RobotName: TypeAlias = Annotated[
    str | None,
    typer.Argument(help="A known robot (default go2), a .urdf or an .xml (MJCF) file.", metavar="ROBOT"),
]
FootFrames: TypeAlias = Annotated[
    str | None, typer.Option(help="Foot frames of a robot's file, comma-separated.")
]
LogRobot: TypeAlias = Annotated[
    str | None, typer.Option(help="Name or file of the robot, where the log does not name it.")
]
Facets: TypeAlias = Annotated[str, typer.Option(help="Sides of friction pyramids, or 'exact'.")]
Fit: TypeAlias = Annotated[str, typer.Option(help="Pyramids inside or around the cones: inner or outer.")]
PictureOut: TypeAlias = Annotated[Path, typer.Option(help="Parent of the new folder for pictures.")]
Picture: TypeAlias = Annotated[bool, typer.Option("--picture/--no-picture", help="Draw pictures.")]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Friction: TypeAlias = Annotated[float, typer.Option(help="Friction of the ground.")]
Duration: TypeAlias = Annotated[float, typer.Option(help="Simulated time [s].")]
Payload: TypeAlias = Annotated[
    str,
    typer.Option(help="KG or KG@X,Y,Z: mass and its place on the base, which no controller knows [kg], [m]."),
]
Pushes: TypeAlias = Annotated[
    list[str] | None, typer.Option(help="T:FX,FY,FZ:DURATION [s, N, s]; repeatable.")
]
Seed: TypeAlias = Annotated[
    int | None, typer.Option(help="Seed of a small random velocity at the start and of all noise.")
]
ScenarioPath: TypeAlias = Annotated[
    Path | None,
    typer.Option("--scenario", help="A YAML file of ice, faults, soft ground, ...; see docs/scenarios.md."),
]
View: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--view", help="Show it in a window, in real time; arrows or WASD, Q, E and space steer a walk."
    ),
]


@dataclass(frozen=True)
class Physics:
    """Which physics a run obeys."""

    world: Annotated[str, typer.Option(help=f"Physics: {' or '.join(WORLDS)}.")] = "mujoco"
    collision: Annotated[
        str,
        typer.Option(help="What may touch (mujoco, rigid): feet alone, or full, the whole robot and itself."),
    ] = "feet"
    actuators: Annotated[
        str,
        typer.Option(help="ideal, or real: rotors, friction and torque-speed curves (mujoco, rigid)."),
    ] = "ideal"


@dataclass(frozen=True, kw_only=True)
class Ground:
    """The ground under a robot."""

    terrain: Annotated[
        str | None,
        typer.Option(
            help="flat, slope:DEG, stairs:HEIGHT,DEPTH, rough:SEED,HEIGHT or pit:START,LENGTH,DEPTH [m]."
        ),
    ] = None
    slope: Annotated[
        float | None, typer.Option(help="A slope that rises along +x [deg]: --terrain slope:DEG.")
    ] = None

    @property
    def unsaid(self) -> bool:
        """Whether nothing was said of it."""
        return self.terrain is None and self.slope is None

    def read(self) -> Terrain:
        """Return the terrain, flat where nothing was said."""
        from surefoot.terrain import read_terrain

        if self.slope is None or self.terrain is not None:
            if self.slope is not None:
                raise ProblemError("--slope and --terrain both say what the ground is; give one of them")
            return read_terrain(self.terrain or "flat", "--terrain")
        slope = real_number("--slope", self.slope, low=-80.0, high=80.0)
        return read_terrain(f"slope:{slope!r}" if slope else "flat", "--slope")


@dataclass(frozen=True)
class Leaving:
    """What a run leaves, and where."""

    out: Annotated[Path, typer.Option(help="Parent of the run's new folder.")] = Path("runs")
    video: Annotated[bool, typer.Option("--video/--no-video", help="Film the run.")] = True
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw plots and a report.")] = True
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False


def check_numbers(mu: float, duration: float, shortest: float, seed: int | None) -> None:
    """Refuse numbers that no run can have; `shortest` is the least duration that says something [s]."""
    parsing.friction("--mu", mu)
    parsing.duration(duration, shortest)
    parsing.seed(seed)


def scenario_of(
    duration: float, mu: float, push: list[str] | None, seed: int | None, said: ScenarioFile, **more: Any
) -> Scenario:
    """Return what happens to the robot, or raise for what lies past the end."""
    from surefoot.simulation.scenario import Ice, IcePatch, Scenario

    pushes, given = [parsing.push(text) for text in push or ()], [parsing.ice(entry) for entry in said.ice]
    changes = [one for one in given if isinstance(one, Ice)]
    patches = [one for one in given if isinstance(one, IcePatch)]
    parsing.within_run("--push", push or (), (event.start for event in pushes), duration)
    begins = [one.start for one in changes]
    parsing.within_run("ice", [f"from {start:g}" for start in begins], begins, duration)
    return Scenario(duration, mu, pushes, changes, seed, patches=patches, **more)


def require(robot: str | None, packages: Sequence[str], leaving: Leaving) -> None:
    """Raise for all optional packages at once if one that a run cannot do without is missing."""
    from surefoot.cli import extras

    drawn = ["matplotlib"] if leaving.report else []
    needed = (*extras.robot_packages(robot), *packages)
    extras.require(needed, (*(extras.FILM if leaving.video else ()), *drawn))
