"""A walking robot in MuJoCo that goes on by itself, takes new choices while it walks, and can be kicked."""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import SimulationError, SurefootError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, Robot
from surefoot.motion import RobotState, VelocityCommand, WalkingController, WalkSettings, gait_names
from surefoot.records.log.snapshot import point_names
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import LOOK_EVERY, touching_feet
from surefoot.worlds.running.scenario import Fall
from surefoot.worlds.running.walk_terrain import start_pose

LIE = 1.5
"""How long a robot that fell lies before it starts anew [s]."""
STRIP = 3.0
"""How much of the past is kept for the strip of forces [s]."""
STRIP_STEPS = 20
"""Steps between two rows of the strip."""
PATIENCE = 0.02
"""Longest time that the simulation takes for itself at once, so that pages are drawn and mice heard [s]."""
KICK = 0.1
"""How long a kick lasts [s]."""
HARDEST = 400.0
"""Largest force of a kick [N]."""


@dataclass(frozen=True)
class Choices:
    """What a viewer chooses of a run.

    Attributes
    ----------
    mu
        Friction of the ground; the controller goes on believing in that of the start.
    payload
        Mass on the base that the controller does not know [kg].
    gait
        Its name.
    velocity
        Forward, left [m/s], yaw rate [rad/s].
    """

    mu: float = 0.6
    payload: float = 0.0
    gait: str = "trot"
    velocity: tuple[float, float, float] = (0.3, 0.0, 0.0)


class WalkRun:
    """Steps a walking robot.

    Parameters
    ----------
    robot
        With a floating base and point feet.
    choices
        To start with.

    Raises
    ------
    ModelError, ProblemError
        For a robot that cannot walk, or a gait that it has not.
    """

    def __init__(self, robot: Robot, choices: Choices | None = None) -> None:
        self.robot, self.terrain = robot, FlatTerrain()
        self.choices = choices or Choices()
        self.assumed_mu = self.choices.mu
        self.names = gait_names(len(robot.feet))
        self._weight = robot.mass * GRAVITY
        self._feet = len(robot.feet)
        self.restart()

    def restart(self) -> None:
        """Stand the robot up where it began."""
        self.controller = self._controller(self.choices)
        self.world = MujocoWorld(self.robot, self.terrain, self.choices.mu, payload=self.choices.payload)
        q = start_pose(self.robot, self.terrain)
        self.world.reset(q)
        on = np.ones(self._feet, dtype=bool)
        self.controller.warm_up(RobotState(*self.world.q_v(), 0.0, on))
        self.controller.reset()
        self._height = float(q[2])
        self.time, self._began, self.steps = 0.0, 0.0, 0
        self.fell_at = math.inf
        self.force, self._until = np.zeros(3), -math.inf
        self.reading = self.world.contacts()
        self.past: deque[tuple[float, FloatArray]] = deque(maxlen=int(STRIP / (STRIP_STEPS * self.world.dt)))

    @property
    def fallen(self) -> bool:
        """Whether the robot lies."""
        return self.fell_at < math.inf

    def _controller(self, choices: Choices) -> WalkingController:
        """Return the controller for some choices; a robot that stands has no velocity."""
        velocity = (0.0, 0.0, 0.0) if choices.gait == "stand" else choices.velocity
        command, settings = VelocityCommand.constant(*velocity), WalkSettings(mu=self.assumed_mu)
        return WalkingController(self.robot, command, choices.gait, self.terrain, settings)

    def choose(self, choices: Choices) -> None:
        """Take new choices while the robot walks; raises for those that cannot be, and then keeps the old."""
        if choices == self.choices:
            return
        new = self._controller(choices)
        if choices.gait != self.choices.gait:
            self.controller, self._began = new, self.time
        self.controller.command, self.controller.notes = new.command, new.notes
        if choices.payload != self.choices.payload:
            q, v = self.world.q_v()
            self.world = MujocoWorld(self.robot, self.terrain, choices.mu, payload=choices.payload)
            self.world.reset(q, v)
        self.world.set_friction(choices.mu)
        self.choices = choices

    def kick(self, force: FloatArray, duration: float = KICK) -> None:
        """Push the base with a (3,) force [N] from now on for `duration` [s]; `HARDEST` at the most."""
        size = float(np.linalg.norm(force))
        self.force = np.asarray(force, dtype=np.float64) * min(1.0, HARDEST / max(size, 1e-12))
        self._until = self.time + duration

    @property
    def push(self) -> FloatArray:
        """(3,) force on the base now [N]."""
        return self.force if self.time < self._until else np.zeros(3)

    def step(self) -> None:
        """Advance by one step; a robot that has lain for `LIE` starts anew."""
        if self.time - self.fell_at > LIE:
            self.restart()
        world, q_v = self.world, self.world.q_v()
        sensed = touching_feet(world.contact_foot, self.reading.forces, self._feet, self._weight)
        command = self.controller.step(RobotState(*q_v, self.time - self._began, sensed))
        try:
            world.step(command.torques, self.push)
        except SimulationError:
            self.restart()
            return
        self.reading = world.contacts()
        self.time += world.dt
        self.steps += 1
        if self.steps % STRIP_STEPS == 0:
            self.past.append((self.time, self.reading.forces[:, 2].copy()))
        looks = self.steps % LOOK_EVERY == 0 and not self.fallen
        if looks and Fall().happened(q_v[0], self._height, self.terrain) is not None:
            self.fell_at = self.time

    def go_on(self, seconds: float) -> float:
        """Simulate so long, or as far as `PATIENCE` lets it, and return how far [s]."""
        begin, before = time.perf_counter(), self.steps
        while 0 <= (self.steps - before) * self.world.dt < seconds:
            try:
                self.step()
            except SurefootError:
                self.restart()
            if time.perf_counter() - begin > PATIENCE:
                break
        return max(0, self.steps - before) * self.world.dt

    def strip(self) -> tuple[FloatArray, FloatArray]:
        """Return times (k,) [s] and normal forces (k, p) [N] of the last `STRIP` seconds."""
        rows = list(self.past)
        if not rows:
            return np.zeros(0), np.zeros((0, len(self.world.contact_foot)))
        return np.array([t for t, _ in rows]), np.array([f for _, f in rows])

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Name of the foot of every contact point, with a number where a foot has several."""
        return tuple(point_names(self.robot.foot_names, self.world.contact_foot.tolist()))
