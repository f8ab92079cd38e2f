"""Options that several commands have in common, each defined once, and the checks of those of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from surefoot.app.cli import parsing
from surefoot.app.cli.robots import is_file
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError
from surefoot.worlds.interface.world_names import WORLDS

if TYPE_CHECKING:
    from surefoot.app.cli.scenario_file import ScenarioFile
    from surefoot.mechanics import Terrain
    from surefoot.worlds.running.scenario import Scenario

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
PictureOut: TypeAlias = Annotated[Path, typer.Option(help="Parent of the new folder for pictures.")]
Jobs: TypeAlias = Annotated[int | None, typer.Option(min=1, help="Processes; all cores by default.")]
Picture: TypeAlias = Annotated[bool, typer.Option("--picture/--no-picture", help="Draw pictures.")]
AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")]
Friction: TypeAlias = Annotated[float, typer.Option(help="Friction of the ground.")]
Duration: TypeAlias = Annotated[float, typer.Option(help="Simulated time [s].")]
Seed: TypeAlias = Annotated[
    int | None, typer.Option(help="Seed of a small random velocity at the start and of all noise.")
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
    def is_default(self) -> bool:
        """Whether no option changes the ground."""
        return self.terrain is None and self.slope is None

    def read(self) -> Terrain:
        """Return the terrain, flat by default."""
        from surefoot.mechanics import read_terrain

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
    hd: Annotated[bool, typer.Option("--hd", help="Film it in 1080 lines instead of 720.")] = False
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw plots and a report.")] = True
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False


@dataclass(frozen=True, kw_only=True)
class RunOptions(Ground, Physics, Leaving):
    """What a simulated run is of: a robot on its ground, and what happens to it."""

    robot: RobotName = None
    feet: FootFrames = None
    mu: Friction = 0.6
    push: Annotated[list[str] | None, typer.Option(help="T:FX,FY,FZ:DURATION [s, N, s]; repeatable.")] = None
    payload: Annotated[
        str,
        typer.Option(
            help="KG or KG@X,Y,Z: mass and its place on the base, which no controller knows [kg], [m]."
        ),
    ] = "0"
    seed: Seed = None
    scenario: Annotated[
        Path | None,
        typer.Option(help="A YAML file of ice, faults, soft ground, ...; see docs/scenarios.md."),
    ] = None
    duration: Duration = 10.0
    view: Annotated[
        bool,
        typer.Option(
            "--view", help="Show it in a window, in real time; arrows or WASD, Q, E and space steer a walk."
        ),
    ] = False

    @property
    def payload_mass(self) -> tuple[float, tuple[float, float, float]]:
        """Mass of the payload [kg] and its place in base axes [m]."""
        return parsing.payload(self.payload)

    @property
    def world_file(self) -> str | None:
        """The robot's file where that is the world, too: MJCF, in MuJoCo."""
        from surefoot.mechanics.robot.mjcf import is_mjcf

        mjcf = self.robot is not None and is_file(self.robot) and is_mjcf(Path(self.robot))
        return self.robot if mjcf and self.world in ("mujoco", "mujoco-exact") else None

    def check(self, shortest: float, planner: str = "convex") -> None:
        """Refuse, before any work, numbers that no run can have, and what cannot be shown.

        Parameters
        ----------
        shortest
            Least duration that says something [s].
        planner
            Who would be steered from a window.
        """
        if self.view:
            from surefoot.app.cli import live

            live.check(planner)
        parsing.friction("--mu", self.mu)
        real_number("--duration", self.duration, low=shortest, high=parsing.LONGEST_RUN)
        parsing.seed(self.seed)
        _ = self.payload_mass

    def happening(self, said: ScenarioFile, **more: Any) -> Scenario:
        """Return what happens to the robot, or raise for what lies past the end."""
        from surefoot.worlds.running.scenario import Ice, IcePatch, Scenario

        texts, given = self.push or (), [parsing.ice(entry) for entry in said.ice]
        pushes = [parsing.push(text) for text in texts]
        changes = [one for one in given if isinstance(one, Ice)]
        patches = [one for one in given if isinstance(one, IcePatch)]
        parsing.within_run("--push", texts, (event.start for event in pushes), self.duration)
        begins = [one.start for one in changes]
        parsing.within_run("ice", [f"from {start:g}" for start in begins], begins, self.duration)
        return Scenario(self.duration, self.mu, pushes, changes, self.seed, patches=patches, **more)


def require(robot: str | None, packages: Sequence[str], leaving: Leaving) -> None:
    """Raise for all optional packages at once if one that a run cannot do without is missing."""
    from surefoot.app.cli import extras

    drawn = ["matplotlib"] if leaving.report else []
    needed = (*extras.robot_packages(robot), *packages)
    extras.require(needed, (*(extras.FILM if leaving.video else ()), *drawn))
