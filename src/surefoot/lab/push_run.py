"""A walking robot in MuJoCo that goes on by itself, takes new choices while it walks, and can be kicked."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.controller import RobotState
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import SimulationError, SurefootError
from surefoot.log.scene import point_names
from surefoot.robot import Robot
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.run import LOOK_EVERY, TOUCH, loaded_feet
from surefoot.simulation.scenario import Fall
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.world import ContactReading
from surefoot.spatial import GRAVITY
from surefoot.stance.gait_library import gait_names
from surefoot.terrain import FlatTerrain

LIE = 1.5
"""How long a robot that fell lies before it starts anew [s]."""
STRIP = 3.0
"""How much of the past is kept for the strip of forces [s]."""
STRIP_STEPS = 20
"""Steps between two rows of the strip."""
TURN = 1.0 / 60.0
"""Time after which the run looks at the clock again [s]."""
SHARE = 0.7
"""Share of the time that the simulation may take for itself, so that pages are drawn and mice heard."""
KICK = 0.1
"""How long a kick lasts [s]."""
HARDEST = 400.0
"""Largest force of a kick [N]."""


@dataclass(frozen=True)
class Choices:
    """What viewers choose of a run.

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


@dataclass(frozen=True, eq=False)
class Snapshot:
    """What a run is like at an instant.

    Attributes
    ----------
    time
        Simulated since the start [s].
    q
        (nq,) configuration [m, -, rad].
    reading
        Of the contacts.
    push
        (3,) force on the base [N].
    choices
        That hold.
    speed
        Simulated time per time.
    fallen
        Whether it lies.
    notes
        What was changed in the choices, one line each.
    """

    time: float
    q: FloatArray
    reading: ContactReading
    push: FloatArray
    choices: Choices
    speed: float
    fallen: bool
    notes: tuple[str, ...]


class WalkRun:
    """Steps a walking robot; nothing here knows threads or clocks.

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
        self.believed = self.choices.mu
        self.names = gait_names(len(robot.feet))
        self._least = TOUCH * robot.mass * GRAVITY
        self._feet = len(robot.feet)
        self.restart()

    def restart(self) -> None:
        """Stand the robot up where it began."""
        self.controller = self._controller(self.choices)
        self.world = MujocoWorld(self.robot, self.terrain, self.choices.mu, payload=self.choices.payload)
        q = start_pose(self.robot, self.terrain)
        self.world.reset(q)
        on = np.ones(self._feet, dtype=bool)
        self.controller.warm_up(RobotState(*self.world.state(), 0.0, on))
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
        command, settings = VelocityCommand.constant(*velocity), WalkSettings(mu=self.believed)
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
            q, v = self.world.state()
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
        world, q_v = self.world, self.world.state()
        sensed = loaded_feet(world.contact_foot, self.reading.forces, self._feet, self._least)
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

    def snapshot(self, speed: float = 1.0) -> Snapshot:
        """Return what it is like now."""
        notes = tuple(self.controller.notes)
        q = self.world.state()[0]
        return Snapshot(self.time, q, self.reading, self.push.copy(), self.choices, speed, self.fallen, notes)

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


class SharedRun:
    """Runs a robot by the clock for everyone who looks, in a thread of its own; without viewers it waits.

    All viewers see the same robot. What one of them chooses holds for all; every method takes the same lock.

    Parameters
    ----------
    run
        That is stepped.
    """

    def __init__(self, run: WalkRun) -> None:
        self._run, self._lock = run, threading.Lock()
        self._viewers, self._open = 0, threading.Event()
        self._ended = threading.Event()
        self._speed = 1.0
        self._thread = threading.Thread(target=self._work, name="lab-run", daemon=True)
        self._thread.start()

    @property
    def robot(self) -> Robot:
        """Who walks."""
        return self._run.robot

    def enter(self) -> None:
        """Take note of a viewer."""
        with self._lock:
            self._viewers += 1
        self._open.set()

    def leave(self) -> None:
        """Take note that a viewer has gone."""
        with self._lock:
            self._viewers -= 1
            if self._viewers <= 0:
                self._open.clear()

    @contextmanager
    def held(self) -> Iterator[WalkRun]:
        """Yield the run, which stands still while the context lasts."""
        with self._lock:
            yield self._run

    def look(self) -> tuple[Snapshot, tuple[FloatArray, FloatArray]]:
        """Return what it is like now; times (k,) [s] and normal forces (k, p) [N] of the strip."""
        with self._lock:
            return self._run.snapshot(self._speed), self._run.strip()

    def close(self) -> None:
        """End the run."""
        self._ended.set()
        self._open.set()
        self._thread.join(timeout=2.0)

    def _work(self) -> None:
        """Keep up with the clock, as far as the machine can."""
        while not self._ended.is_set():
            self._open.wait()
            begin = time.perf_counter()
            made = self._turn(begin)
            self._ended.wait(max(0.0, begin + TURN - time.perf_counter(), 1e-3))
            took = time.perf_counter() - begin
            self._speed += 0.05 * (made / took - self._speed)

    def _turn(self, begin: float) -> float:
        """Step for one turn and return the time that was simulated [s]."""
        with self._lock:
            run, before = self._run, self._run.steps
            while not self._ended.is_set() and (run.steps - before) * run.world.dt < TURN:
                try:
                    run.step()
                except SurefootError:
                    run.restart()
                if run.steps < before or time.perf_counter() - begin > SHARE * TURN:
                    break
            return max(0, run.steps - before) * run.world.dt
