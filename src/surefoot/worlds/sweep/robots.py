"""A robot walks: robot, world, what is wrong with them, what is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.mechanics import Actuators, FlatTerrain, Robot, Terrain, load_robot, real_actuators
from surefoot.worlds.interface.world_names import WORLDS, make_world
from surefoot.worlds.sweep.ground_settings import GroundExperiment
from surefoot.worlds.sweep.sample_experiment import number

if TYPE_CHECKING:
    from surefoot.motion import Controller
    from surefoot.records import Log

MOTORED = ("mujoco", "mujoco-exact", "rigid")
"""Worlds whose joints have motors."""
PUSH_LENGTH = 0.2
"""Length of a push [s]."""


@dataclass(frozen=True)
class WalkTrial(GroundExperiment):
    """A robot walks under the walking controller; it survives if `surefoot walk` would call it "walked".

    Unlike there, its controller gets the true state; of what is drawn it knows only `believed_mu` and the
    terrain.

    Attributes
    ----------
    payload
        Point mass on the base [kg].
    motor_strength, delay, noise
        Torque given over torque asked for; between measurement and torques [s]; of the sensors, 1 for
        ordinary ones.
    armature, joint_damping, joint_friction
        Factors of the figures of `real_actuators`; motors are ideal where none is given.
    push_x, push_y, push_time
        Push on the base: forward, left [N], for 0.2 s from this time on [s].
    believed_mu
        Friction that the controller believes in.
    robot, world
        A known robot's name; a name of `surefoot.worlds.interface.world_names.WORLDS`.
    duration
        Simulated time [s].
    gait
        A name of `surefoot.motion.gaits.library.gait_names()`.
    speed
        Commanded forward velocity [m/s].
    """

    columns: ClassVar[Mapping[str, str]] = {
        "survived": "bool",  # walked as it was commanded
        "outcome": "text",  # in a word
        "laws_broken": "float",  # how many
        "slip": "float",  # furthest that a loaded foot slid [m]
        "sink": "float",  # deepest overlap [m]
        "ground_work": "float",  # that the ground's normal forces give while feet rise out of it [J]
        "cone_use": "float",  # highest use of the friction cone
        "torque_use": "float",  # highest share of a torque limit
        "tilt": "float",  # largest [deg]
        "end_time": "float",  # of the run [s]
        "velocity": "float",  # mean forward velocity after 2 s, or of all if it ended before [m/s]
    }

    payload: float = number(0.0, 0.0, 1e4, "kg")
    motor_strength: float = number(1.0, 0.0, 10.0, "x nominal")
    delay: float = number(0.0, 0.0, 1.0, "s")
    noise: float = number(0.0, 0.0, 100.0)
    armature: float | None = number(None, 0.0, 1e3, "x nominal")
    joint_damping: float | None = number(None, 0.0, 1e3, "x nominal")
    joint_friction: float | None = number(None, 0.0, 1e3, "x nominal")
    push_x: float = number(0.0, -1e5, 1e5, "N")
    push_y: float = number(0.0, -1e5, 1e5, "N")
    believed_mu: float = number(0.6, 0.0, 1e3)
    robot: str = "go2"
    world: str = "mujoco"  # type: ignore[misc]
    duration: float = number(4.0, 0.1, 600.0, "s")
    push_time: float = number(1.0, 0.0, 600.0, "s")
    gait: str = "trot"
    speed: float = number(0.5, -10.0, 10.0, "m/s")

    def __post_init__(self) -> None:
        from surefoot.motion import gait_names

        if not isinstance(self.robot, str) or "/" in self.robot or self.robot.endswith((".urdf", ".xml")):
            raise ProblemError(f"robot must be the name of a known robot, got {shown(self.robot)}")
        check_name("world", self.world, WORLDS)  # a list would not be hashable
        super().__post_init__()
        if (
            self.world not in MOTORED
            and (self.armature, self.joint_damping, self.joint_friction) != (None,) * 3
        ):
            raise ProblemError(f"armature is of the worlds {', '.join(MOTORED)}, got {self.world}")
        check_name("gait", self.gait, [name for name in gait_names() if name != "stand"])
        if (self.push_x or self.push_y) and self.push_time >= self.duration:
            raise ProblemError(f"push_time {self.push_time:g} s is after the end, {self.duration:g} s")

    def check(self) -> None:
        """Refuse robots that are not known, or that the controller cannot drive."""
        self._begin(known_robot(self.robot), FlatTerrain())

    def run(self, seed: int) -> dict[str, Any]:
        """Return how the robot walked."""
        from surefoot.records import summarise_walk
        from surefoot.worlds.mujoco.engine_warnings import engine_warnings
        from surefoot.worlds.running.faults import Faults
        from surefoot.worlds.running.run import run
        from surefoot.worlds.running.scenario import Push, Scenario

        robot, terrain = known_robot(self.robot), self.ground(seed)
        controller, start = self._begin(robot, terrain)
        world = make_world(
            self.world, self.alter_masses(robot), terrain, self.mu, payload=self.payload,
            **self._motors(robot), **self.ground_options(),
        )  # fmt: skip
        faults = Faults(noise=self.noise, delay=self.delay, strength=self.motor_strength)
        force = (self.push_x, self.push_y, 0.0)
        pushes = [Push(self.push_time, force, PUSH_LENGTH)] if any(force) else []
        scenario = Scenario(self.duration, self.mu, pushes, seed=seed, faults=faults, start=start)
        with engine_warnings():  # not into the worker's folder: the results tell of a lost state
            log = run(world, controller, scenario)
        summary = summarise_walk(log)
        return {
            "survived": bool(summary.success),
            "outcome": summary.outcome,
            "laws_broken": float(len(summary.laws_broken)),
            "slip": max(foot.slip for foot in summary.feet),
            "sink": max(0.0, summary.laws.penetration_max),
            "ground_work": ground_work(log),
            "cone_use": summary.laws.cone_use_max,
            "torque_use": summary.torque_use_max,
            "tilt": summary.tilt_max_deg,
            "end_time": summary.duration,
            "velocity": summary.velocity.forward.measured,
        }

    def _begin(self, robot: Robot, terrain: Terrain) -> tuple[Controller, FloatArray]:
        """Return the controller and where the robot starts."""
        from surefoot.motion import VelocityCommand, WalkingController, WalkSettings
        from surefoot.worlds.running.walk_terrain import start_pose

        command, settings = VelocityCommand.constant(self.speed), WalkSettings(mu=self.believed_mu)
        controller = WalkingController(robot, command, self.gait, terrain, settings)
        return controller, start_pose(robot, terrain)

    def _motors(self, robot: Robot) -> dict[str, Actuators]:
        """Return the world's option for motors with other figures; none where no setting says so."""
        figures = self.armature, self.joint_damping, self.joint_friction
        if figures == (None, None, None):
            return {}
        motors = real_actuators(robot)
        own = zip(figures, (motors.armature, motors.damping, motors.friction), strict=True)
        armature, damping, friction = (figure if f is None else f * figure for f, figure in own)
        return {"actuators": replace(motors, armature=armature, damping=damping, friction=friction)}


@lru_cache(maxsize=4)
def known_robot(name: str) -> Robot:
    """Return a robot, loaded once by each worker."""
    return load_robot(name)


def ground_work(log: Log) -> float:
    """Return the work of normal forces on rising feet [J]: soft ground gives it back, rigid has none."""
    forces, velocities = np.asarray(log["forces"]), np.asarray(log["contact_velocities"])
    power = np.maximum(forces[..., 2] * velocities[..., 2], 0.0)
    return float(power.sum() * log.fact("dt"))
