"""A walk as a value: who walks where, what happens on the way and what the controller is told of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.legged import write_legged
from surefoot.mechanics.robot import Robot, load_robot
from surefoot.mechanics.robot.actuators import Actuators, actuators_of
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.records.audit import WalkSummary, summarise_walk
from surefoot.records.log import Log
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.running.faults import Faults, scaled_robot
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Ice, IcePatch, Push, Scenario
from surefoot.worlds.running.sensors import SensorModel

HARD: Mapping[str, Any] = {"actuators": "real", "collision": "full"}
"""Options of a world with real motors in which every link may touch."""
SIX_LEGS = "legged6"
"""Name of a made-up robot with six legs."""
QUADRUPEDS = ("anymal_c", "a1", "go1", "b1", "solo12", "hyq", "laikago")
"""Robots beside Go2 whose walks are measured."""


@dataclass(frozen=True)
class Walk:
    """A walk of a robot with its controller's default settings; a subclass may take another controller.

    Attributes
    ----------
    robot, velocity, gait
        Name; forward, left [m/s], yaw rate [rad/s]; None for the robot's usual gait.
    terrain, mu, believed_mu
        The ground, as `surefoot walk --terrain` takes it; its friction, and what the controller counts on,
        None for the same.
    believed_mass
        Mass that the controller counts on, as a share of the true one.
    world, options
        Name of the world and its own options, see `make_world`.
    sensors, scanner
        See `Scenario`: None for a robot that is told the true state, and that sees nothing.
    pushes, ice, patches, faults
        What disturbs it.
    commands
        Velocities one after the other, in place of `velocity`.
    """

    robot: str = "go2"
    velocity: tuple[float, float, float] = (0.5, 0.0, 0.0)
    gait: str | None = None
    terrain: str = "flat"
    mu: float = 0.6
    believed_mu: float | None = None
    believed_mass: float = 1.0
    world: str = "mujoco"
    options: Mapping[str, Any] = field(default_factory=dict)
    sensors: SensorModel | None = None
    scanner: RangeSensor | None = None
    pushes: tuple[Push, ...] = ()
    ice: tuple[Ice, ...] = ()
    patches: tuple[IcePatch, ...] = ()
    faults: Faults | None = None
    commands: VelocityCommand | None = None

    @property
    def command(self) -> VelocityCommand:
        """The velocity that is asked for."""
        return self.commands or VelocityCommand.constant(*self.velocity)

    @property
    def counted_on(self) -> float:
        """The friction that the controller counts on."""
        return self.mu if self.believed_mu is None else self.believed_mu

    def motors(self, robot: Robot) -> Actuators | None:
        """Return the motors of the world's robot, None for ideal ones."""
        return actuators_of(robot, self.options.get("actuators", "ideal"))

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """Return the controller; it is told all of the robot and the ground but for friction and mass."""
        seen = robot if self.believed_mass == 1.0 else scaled_robot(robot, self.believed_mass)
        motors = self.motors(robot)
        return walking_controller(seen, self.command, self.gait, terrain, self.counted_on, motors)

    def log(self, seed: int, duration: float, *observers: Any) -> Log:
        """Return what happens with a seed in so long a time [s]."""
        robot, terrain = known_robot(self.robot), read_terrain(self.terrain)
        controller = self.controller(robot, terrain)
        world = make_world(self.world, robot, terrain, self.mu, **self.options)
        scenario = Scenario(
            duration, self.mu, self.pushes, self.ice, seed, self.faults, sensors=self.sensors,
            scanner=self.scanner, patches=self.patches,
        )  # fmt: skip
        return run(world, controller, scenario, observers)

    def summary(self, seed: int, duration: float) -> WalkSummary:
        """Return what the walk with a seed came to."""
        return summarise_walk(self.log(seed, duration))


@cache
def known_robot(name: str) -> Robot:
    """Return a robot of the catalogue, or a made-up one with six legs, "legged6"; loaded once."""
    if name != SIX_LEGS:
        return load_robot(name)
    with TemporaryDirectory() as folder:
        path, feet = write_legged(Path(folder), 6)
        return load_robot(path, feet=feet)
