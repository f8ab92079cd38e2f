"""A robot stands or walks: robot, world, what is wrong with them, what is measured."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from surefoot.errors import ProblemError, check_name
from surefoot.simulation.worlds import WORLDS, make_world
from surefoot.sweep.experiment import number
from surefoot.sweep.grounded import Grounded
from surefoot.terrain import FlatTerrain, Terrain

if TYPE_CHECKING:
    from surefoot.audit import RunSummary
    from surefoot.control.controller import Controller
    from surefoot.log import Log
    from surefoot.robot import Robot

PUSH_LENGTH = 0.2
"""Length of a push [s]."""


@dataclass(frozen=True)
class RobotRun(Grounded):
    """A robot under a controller that knows nothing of what is drawn, but `believed_mu` and the terrain.

    Attributes
    ----------
    payload
        Point mass on the base [kg].
    motor_strength, delay, noise
        Torque given over torque asked for; between measurement and torques [s]; of the sensors, 1 for
        ordinary ones.
    push_x, push_y, push_time
        Push on the base: forward, left [N], for 0.2 s from this time on [s].
    believed_mu
        Friction that the controller believes in.
    robot, world
        A known robot's name; a name of `surefoot.simulation.worlds.WORLDS`.
    duration
        Simulated time [s].
    """

    columns: ClassVar[Mapping[str, str]] = {
        "survived": "bool",  # stood, or walked as it was commanded
        "outcome": "text",  # in a word
        "laws_broken": "float",  # how many
        "slip": "float",  # furthest that a loaded foot slid [m]
        "sink": "float",  # deepest overlap [m]
        "ground_work": "float",  # that the ground's normal forces give while feet rise out of it [J]
        "cone_use": "float",  # highest use of the friction cone
        "torque_use": "float",  # highest share of a torque limit
        "tilt": "float",  # largest [deg]
        "end_time": "float",  # of the run [s]
    }

    payload: float = number(0.0, 0.0, 1e4, "kg")
    motor_strength: float = number(1.0, 0.0, 10.0, "x nominal")
    delay: float = number(0.0, 0.0, 1.0, "s")
    noise: float = number(0.0, 0.0, 100.0)
    push_x: float = number(0.0, -1e5, 1e5, "N")
    push_y: float = number(0.0, -1e5, 1e5, "N")
    believed_mu: float = number(0.6, 0.0, 1e3)
    robot: str = "go2"
    world: str = "mujoco"  # type: ignore[misc]
    duration: float = number(3.0, 0.1, 600.0, "s")
    push_time: float = number(1.0, 0.0, 600.0, "s")

    def __post_init__(self) -> None:
        if not isinstance(self.robot, str) or "/" in self.robot or self.robot.endswith((".urdf", ".xml")):
            raise ProblemError(f"robot must be the name of a known robot, got {self.robot!r:.60}")
        check_name("world", self.world, WORLDS)  # a list would not be hashable
        super().__post_init__()
        if (self.push_x or self.push_y) and self.push_time >= self.duration:
            raise ProblemError(f"push_time {self.push_time:g} s is after the end, {self.duration:g} s")

    def check(self) -> None:
        """Refuse robots that are not known, or that the controller cannot drive."""
        self._begin(known_robot(self.robot), FlatTerrain())

    def run(self, seed: int) -> dict[str, Any]:
        """Return how the robot stood or walked."""
        from surefoot.simulation.engine_warnings import engine_warnings
        from surefoot.simulation.faults import Faults
        from surefoot.simulation.run import run
        from surefoot.simulation.scenario import Push, Scenario

        robot, terrain = known_robot(self.robot), self.ground(seed)
        controller, start = self._begin(robot, terrain)
        world = make_world(
            self.world, self.altered(robot), terrain, self.mu, payload=self.payload, **self.ground_options()
        )
        faults = Faults(noise=self.noise, delay=self.delay, strength=self.motor_strength)
        force = (self.push_x, self.push_y, 0.0)
        pushes = [Push(self.push_time, force, PUSH_LENGTH)] if any(force) else []
        scenario = Scenario(self.duration, self.mu, pushes, seed=seed, faults=faults, **start)
        with engine_warnings():  # not into the worker's folder: the results tell of a lost state
            log = run(world, controller, scenario)
        summary, more = self._judge(log)
        return {
            "survived": bool(summary.success),
            "outcome": summary.outcome,
            "laws_broken": float(len(summary.laws_broken)),
            "slip": max(foot.slip for foot in summary.feet),
            "sink": max(0.0, summary.laws.penetration_max),
            "ground_work": ground_work(log),
            "cone_use": summary.laws.cone_use_max,
            "torque_use": summary.torque_use_max,
            "end_time": summary.duration,
            **more,
        }

    @abstractmethod
    def _begin(self, robot: Robot, terrain: Terrain) -> tuple[Controller, dict[str, Any]]:
        """Return the controller, and the start and end of its scenario."""

    @abstractmethod
    def _judge(self, log: Log) -> tuple[RunSummary, dict[str, Any]]:
        """Return the summary of a run, its tilt and what only this experiment measures."""


@dataclass(frozen=True)
class StandTrial(RobotRun):
    """A robot stands under the standing controller; it survives if `surefoot stand` would call it "stood"."""

    columns: ClassVar[Mapping[str, str]] = {
        **RobotRun.columns,
        "moved": "float",  # the base, from where it started to where it ended [m]
    }
    chunk: ClassVar[int] = 2

    def _begin(self, robot: Robot, terrain: Terrain) -> tuple[Controller, dict[str, Any]]:
        from surefoot.control.standing import StandingController
        from surefoot.control.standing_plan import StandingPlan
        from surefoot.robot import place
        from surefoot.simulation.scenario import STANDING_FALL, START_DEPTH

        q = place(robot, terrain)
        plan = StandingPlan(robot, terrain, q, [])
        controller = StandingController(robot, plan, terrain, q, self.believed_mu)
        return controller, {"start": q, "depth": START_DEPTH, "fall": STANDING_FALL}

    def _judge(self, log: Log) -> tuple[RunSummary, dict[str, Any]]:
        from surefoot.audit import summarise_stand

        summary = summarise_stand(log)
        return summary, {"tilt": summary.base.tilt_max_deg, "moved": summary.base.position_end}


@dataclass(frozen=True)
class WalkTrial(RobotRun):
    """A robot walks under the walking controller; it survives if `surefoot walk` would call it "walked".

    Unlike there, its controller gets the true state.

    Attributes
    ----------
    gait
        A name of `surefoot.gait_names()`.
    speed
        Commanded forward velocity [m/s].
    """

    columns: ClassVar[Mapping[str, str]] = {
        **RobotRun.columns,
        "velocity": "float",  # mean forward velocity after 2 s, or of all if it ended before [m/s]
    }

    gait: str = "trot"
    speed: float = number(0.5, -10.0, 10.0, "m/s")
    duration: float = number(4.0, 0.1, 600.0, "s")

    def __post_init__(self) -> None:
        from surefoot.stance.gait_library import gait_names

        super().__post_init__()
        walks = [name for name in gait_names() if name != "stand"]
        check_name("gait", self.gait, walks)

    def _begin(self, robot: Robot, terrain: Terrain) -> tuple[Controller, dict[str, Any]]:
        from surefoot.control.walking import WalkingController, WalkSettings
        from surefoot.control.walking_body import VelocityCommand
        from surefoot.simulation.walk_terrain import start_pose

        command, settings = VelocityCommand.constant(self.speed), WalkSettings(mu=self.believed_mu)
        controller = WalkingController(robot, command, self.gait, terrain, settings)
        return controller, {"start": start_pose(robot, terrain)}

    def _judge(self, log: Log) -> tuple[RunSummary, dict[str, Any]]:
        from surefoot.audit import summarise_walk

        summary = summarise_walk(log)
        return summary, {"tilt": summary.tilt_max_deg, "velocity": summary.velocity.forward.measured}


@lru_cache(maxsize=4)
def known_robot(name: str) -> Robot:
    """Return a robot, loaded once by each worker."""
    from surefoot.robot import load_robot

    return load_robot(name)


def ground_work(log: Log) -> float:
    """Return the work of normal forces on rising feet [J]: soft ground gives it back, rigid has none."""
    forces, velocities = np.asarray(log["forces"]), np.asarray(log["contact_velocities"])
    power = np.maximum(forces[..., 2] * velocities[..., 2], 0.0)
    return float(power.sum() * log.fact("dt"))
