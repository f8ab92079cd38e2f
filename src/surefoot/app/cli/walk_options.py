"""What a walk's controller is given: what it knows of the ground, and how its commands reach the motors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import options, parsing
from surefoot.base.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.app.cli.scenario_file import ScenarioFile
    from surefoot.mechanics import Terrain
    from surefoot.motion import Controller

KNOWLEDGE = ("exact", "map", "blind")
ASSUMED = 0.6
"""Friction that is believed in until a foot slides, with `believed_mu: auto`."""


@dataclass(frozen=True)
class Beliefs:
    """What the controller believes.

    Attributes
    ----------
    mu
        Friction [-] that it starts from.
    watch
        Whether it believes in less where feet slide.
    terrain
        Its knowledge of the terrain, a name of `KNOWLEDGE`.
    """

    mu: float
    watch: bool
    terrain: str

    def ground(self, terrain: Terrain) -> Terrain:
        """Return the ground that the controller plans on."""
        from surefoot.motion.ground.terrain_knowledge import controller_ground

        return controller_ground(self.terrain, terrain)

    def senses(self, said: ScenarioFile) -> dict[str, Any]:
        """Return what the scenario says of the senses; only with exact knowledge the filter has a map."""
        from surefoot.worlds.running.height_scan import RangeSensor
        from surefoot.worlds.running.sensors import SensorModel

        sensors = None
        if said.estimator == "inekf":
            sensors = SensorModel().scaled(1.0 if said.noise is None else said.noise)
            sensors = sensors if self.terrain == "exact" else replace(sensors, heights=False)
        return {"sensors": sensors, "scanner": RangeSensor() if self.terrain == "map" else None}


KINDS = ("torques", "targets")
"""What drives can be commanded."""
WORLD_RATE = 1000
"""Steps of the world in a second."""


@dataclass(frozen=True)
class Wiring:
    """How commands reach the motors.

    Attributes
    ----------
    targets
        Whether joints get targets.
    every
        Steps of the world in a step of the controller.
    latency
        Delay that is allowed for [s]; None to measure it.
    dropouts
        (start, duration) of times without a fresh state [s].
    """

    targets: bool = False
    every: int = 1
    latency: float | None = None
    dropouts: tuple[tuple[float, float], ...] = ()

    @property
    def plain(self) -> bool:
        """Whether nothing was asked for."""
        return not self.targets and self.every == 1 and self.latency is None and not self.dropouts

    @property
    def dt(self) -> float:
        """Length of the controller's step [s]."""
        return self.every / WORLD_RATE

    def around(self, controller: Controller, robot: Any) -> Controller:
        """Return what commands the motors, for a controller with steps of `dt`."""
        from surefoot.motion.drive.joint_targets import CommandHold, JointTargetController
        from surefoot.motion.drive.latency_compensation import LatencyCompensation
        from surefoot.motion.drive.watchdog import Watchdog

        step = 1.0 / WORLD_RATE
        if self.targets:
            controller = JointTargetController(controller, robot, step, self.every)
        elif self.every > 1:
            controller = CommandHold(controller, self.every)
        if self.latency is None or self.latency > 0.0:
            controller = LatencyCompensation(controller, robot, step, self.latency)
        if self.dropouts or self.targets:
            controller = Watchdog(controller, robot, step)
        return controller


@dataclass(frozen=True, kw_only=True)
class WalkOptions(options.RunOptions):
    """What a walk is asked for."""

    gait: Annotated[
        str | None,
        typer.Option(
            help="stand, trot, walk, pace, bound, flying_trot (on two feet stand, walk), auto (by speed); "
            "None for trot, on two feet walk."
        ),
    ] = None
    planner: Annotated[
        str, typer.Option(help="convex, which follows the gait, or contact-implicit, which takes none.")
    ] = "convex"
    velocity: Annotated[str, typer.Option(help="VX,VY,WZ: forward, left [m/s], yaw rate [rad/s].")] = (
        "0.5,0,0"
    )
    terrain_knowledge: Annotated[
        str,
        typer.Option(
            help="exact: the controller knows the terrain; map: a height map from a sensor; blind: touch."
        ),
    ] = "exact"
    dropout: Annotated[
        list[str] | None, typer.Option(help="T:DURATION without a fresh state [s]; repeatable.")
    ] = None
    commands: Annotated[
        str, typer.Option(help="torques, or targets: joint angles, speeds, gains and torques for the drives.")
    ] = "torques"

    keep_states: Annotated[
        float | None, typer.Option(help="Keep all that lasts in the log, every so many seconds [s].")
    ] = None
    resume: Annotated[
        Path | None,
        typer.Option(help="A log that has kept states, or its folder: go on with its walk."),
    ] = None
    at: Annotated[
        float | None, typer.Option(help="With --resume: from the last state that was kept at this time [s].")
    ] = None

    def command(self, said: ScenarioFile) -> Any:
        """Return the commanded velocity over time."""
        from surefoot.motion import VelocityCommand

        if said.velocity_file is not None:
            return VelocityCommand.read(said.velocity_file)
        return VelocityCommand.constant(*parsing.velocity(self.velocity))

    def beliefs(self, said: ScenarioFile) -> Beliefs:
        """Return what the controller believes.

        Raises
        ------
        ProblemError
            For an unknown word, or a planner that cannot do with less than the truth.
        """
        check_name("--terrain-knowledge", self.terrain_knowledge, KNOWLEDGE)
        watch, believed = isinstance(said.believed_mu, str), said.believed_mu
        if self.planner != "convex" and (watch or self.terrain_knowledge != "exact"):
            given = "believed_mu: auto" if watch else f"--terrain-knowledge {self.terrain_knowledge}"
            raise ProblemError(f"{given} goes with --planner convex")
        if isinstance(believed, str):
            return Beliefs(ASSUMED, True, self.terrain_knowledge)
        return Beliefs(self.mu if believed is None else believed, False, self.terrain_knowledge)

    def wiring(self, said: ScenarioFile) -> Wiring:
        """Return how commands reach the motors, or raise for what options and scenario cannot mean."""
        texts = self.dropout or ()
        dropouts = tuple(parsing.dropout(text) for text in texts)
        parsing.within_run("--dropout", texts, (start for start, _ in dropouts), self.duration)
        check_name("--commands", self.commands, KINDS)
        every = round(WORLD_RATE / said.control_rate)
        if abs(every * said.control_rate - WORLD_RATE) > 1e-6 * WORLD_RATE:
            raise ProblemError(
                f"control_rate must be 1000 over a whole number, as 500 or 250, got {said.control_rate:g}"
            )
        latency = None if isinstance(said.latency, str) else said.latency
        return Wiring(self.commands == "targets", every, latency, dropouts)
