"""What standing and walking samples share: robot, world, what is wrong with them, what is measured."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from surefoot.errors import ProblemError, unknown_name
from surefoot.simulation.worlds import WORLDS, make_world
from surefoot.sweep.bodies import BODY, GROUNDS, altered, check_ground, ground_options
from surefoot.sweep.experiments.experiment import Experiment
from surefoot.sweep.space import Sample, Space
from surefoot.terrain import Terrain

if TYPE_CHECKING:
    from surefoot.audit import RunSummary
    from surefoot.control.controller import Controller
    from surefoot.log import Log
    from surefoot.robot import Robot
    from surefoot.simulation.scenario import Scenario
    from surefoot.simulation.world import World

PUSH_LENGTH = 0.2
"""Length of a push [s]."""


@dataclass(frozen=True)
class RobotRun(Experiment):
    """A robot under a controller that knows nothing of what is drawn, but `believed_mu` and the terrain.

    Attributes
    ----------
    robot
        A known robot's name.
    world
        A name of `surefoot.simulation.worlds.WORLDS`.
    duration
        Simulated time [s].
    mu
        Friction where the sweep does not draw it.
    believed_mu
        Friction that the controller believes in where the sweep does not draw it.
    push_time
        When pushes begin [s]; they last 0.2 s.
    """

    parameters: ClassVar[tuple[str, ...]] = (
        "mu", "believed_mu", "restitution", "stiffness", "damping", "time_constant", "damping_ratio", *BODY,
        "payload", "motor_strength", "delay", "noise", "push_x", "push_y", *GROUNDS,
    )  # fmt: skip
    columns: ClassVar[Mapping[str, str]] = {
        "survived": "bool",  # stood, or walked as it was told
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
    packages: ClassVar[tuple[str, ...]] = ("pin", "example-robot-data")
    limits: ClassVar[Mapping[str, tuple[float, float]]] = {
        "duration": (0.1, 600.0), "mu": (0.0, 1e3), "believed_mu": (0.0, 1e3), "push_time": (0.0, 600.0),
    }  # fmt: skip

    robot: str = "go2"
    world: str = "mujoco"
    duration: float = 3.0
    mu: float = 0.6
    believed_mu: float = 0.6
    push_time: float = 1.0

    def __post_init__(self) -> None:
        if not isinstance(self.robot, str) or "/" in self.robot or self.robot.endswith((".urdf", ".xml")):
            raise ProblemError(f"robot must be the name of a known robot, got {self.robot!r:.60}")
        if self.world not in tuple(WORLDS):  # a list would not be hashable
            raise ProblemError(unknown_name("world", self.world, WORLDS))
        super().__post_init__()

    def check(self, space: Space) -> None:
        """Refuse what the world does not have, and robots that are not known."""
        super().check(space)
        check_ground(self.world, space)
        if {"push_x", "push_y"} & set(space.names) and self.push_time >= self.duration:
            raise ProblemError(f"push_time {self.push_time:g} s is after the end, {self.duration:g} s")
        known_robot(self.robot)

    def log(self, sample: Sample, robot: Robot, terrain: Terrain, controller: Controller, **more: Any) -> Log:
        """Run a sample: its world, faults of sensors and motors, and push; `more` is of the scenario."""
        from surefoot.simulation.faults import Faults
        from surefoot.simulation.scenario import Push, Scenario

        mu = sample.number("mu", self.mu)
        world = make_world(
            self.world, altered(robot, sample), terrain, mu, payload=sample.number("payload", 0.0),
            **ground_options(self.world, sample),
        )  # fmt: skip
        faults = Faults(
            noise=sample.number("noise", 0.0),
            delay=sample.number("delay", 0.0),
            strength=sample.number("motor_strength", 1.0),
        )
        force = (sample.number("push_x", 0.0), sample.number("push_y", 0.0), 0.0)
        pushes = [Push(self.push_time, force, PUSH_LENGTH)] if any(force) else []
        scenario = Scenario(self.duration, mu, pushes, seed=sample.seed, faults=faults, **more)
        return run_quietly(world, controller, scenario)

    def measured(self, log: Log, summary: RunSummary, tilt: float) -> dict[str, Any]:
        """Return the results of a run."""
        return {
            "survived": bool(summary.success),
            "outcome": summary.outcome,
            "laws_broken": float(len(summary.laws_broken)),
            "slip": max(foot.slip for foot in summary.feet),
            "sink": max(0.0, summary.laws.penetration_max),
            "ground_work": ground_work(log),
            "cone_use": summary.laws.cone_use_max,
            "torque_use": summary.torque_use_max,
            "tilt": tilt,
            "end_time": summary.duration,
        }


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


def run_quietly(world: World, controller: Controller, scenario: Scenario) -> Log:
    """Run, and keep MuJoCo's warnings out of the worker's folder: the results tell of a lost state."""
    from surefoot.simulation.run import run

    if "mujoco" not in sys.modules:
        return run(world, controller, scenario)
    mujoco: Any = sys.modules["mujoco"]
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _text: None)
    try:
        return run(world, controller, scenario)
    finally:
        mujoco.set_mju_user_warning(before)
