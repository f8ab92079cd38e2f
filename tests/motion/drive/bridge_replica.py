"""A robot in MuJoCo that speaks as Unitree's simulators do, on a wire and by a clock that are made up.

Written after what they are observed to do: physics and speaker are two threads of one rate. The Python
program's states carry checksum 0, tick 0 and motors of mode 0, and are copied while a step may be under way:
angles and speeds may be of neighbouring steps, a step may be told twice and another not at all. A command
becomes torques when it comes, from the angles and speeds of that instant; they are held until the next one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.motion import JointTargets, motor_order
from surefoot.motion.drive.wire import survey, wired_loop
from surefoot.motion.drive.wire.dialect import COMMAND_FIELDS, STATE_FIELDS, Dialect, dialect_of
from surefoot.motion.drive.wire.packed import PackedMessage
from surefoot.worlds.running.motor_robot import lying


@dataclass
class MadeUpClock:
    """A clock that stands until somebody waits."""

    now: float = 100.0

    def perf_counter(self) -> float:
        """Return the time [s]."""
        return self.now

    def rule(self, patch: pytest.MonkeyPatch) -> None:
        """Let what listens and drives go by this clock."""
        for module in (survey, wired_loop):
            patch.setattr(module, "clock", SimpleNamespace(perf_counter=self.perf_counter))


@dataclass
class SilentWire:
    """A wire on which nobody speaks: the least that a loop needs."""

    clock: MadeUpClock
    others: tuple[str, ...] = ()
    near: tuple[str, ...] = ()
    sent: list[bytes] = field(default_factory=list)

    def send(self, message: PackedMessage) -> None:
        """Take a command."""
        self.sent.append(bytes(message.data))

    def receive(self, timeout: float) -> PackedMessage | None:
        """Let the time pass."""
        self.clock.now += max(timeout, 0.0)
        return None

    def rivals(self) -> Sequence[str]:
        """Return who else commands."""
        return self.others

    def neighbours(self) -> Sequence[str]:
        """Return who else is there."""
        return self.near

    def partners(self) -> int:
        """Return how many speak."""
        return 0


class BridgeReplica(SilentWire):
    """The simulator; `receive` lets its time go by.

    Parameters
    ----------
    robot, rate
        Which one, and steps and states a second [Hz].
    ticking
        Whether it is the C++ program, which tells its time, speaks at 1 kHz and has checksums.
    torn
        Share of the states that mix two steps [-].
    """

    def __init__(
        self, robot: sf.Robot, rate: float = 200.0, *, ticking: bool = False, torn: float = 0.2,
        seed: int = 0, clock: MadeUpClock | None = None,
    ) -> None:  # fmt: skip
        super().__init__(clock or MadeUpClock())
        self.robot, self.dt, self.ticking, self.torn = robot, 1.0 / rate, ticking, torn
        self.dialect: Dialect = dialect_of(robot)
        self._order, self._back = motor_order(robot, self.dialect.motors)
        self.world = sf.MujocoWorld(robot, None, 0.8, self.dt, collision="full", actuators="real")
        self.world.reset(lying(robot, self.world.terrain))
        self._random = np.random.default_rng(seed)
        self.torques = np.zeros(robot.joints)
        self._push: np.ndarray | None = None
        self._message = PackedMessage(self.dialect.state)
        self._next_step = self._next_word = self.clock.now
        self._now = self._before = self._sensed()
        self.time = 0.0

    def _sensed(self) -> dict[str, np.ndarray]:
        """Return what its sensors say, joints in the robot's order."""
        q, v = self.world.q_v()
        rotation = rotation_from_quaternion(q[3:7])
        speed = rotation @ v[:3]
        last = getattr(self, "_speed", speed)
        self._speed = speed
        force = rotation.T @ ((speed - last) / self.dt + np.array([0.0, 0.0, 9.81]))
        x, y, z, w = q[3:7]
        return {
            "quaternion": np.array([w, x, y, z]), "gyroscope": v[3:6].copy(), "accelerometer": force,
            "q": q[7:].copy(), "dq": v[6:].copy(), "tau_est": self.torques.copy(),
        }  # fmt: skip

    def _step(self) -> None:
        """Go on by a step of physics, under the torques that are held."""
        limits = self.robot.effort_limits
        self.world.step(np.clip(self.torques, -limits, limits), self._push)
        self._before, self._now = self._now, self._sensed()
        self.time += self.dt

    def _say(self) -> PackedMessage:
        """Return the state as it is copied now."""
        message, now = self._message, self._now
        mixed = self._before if self._random.random() < self.torn else now
        for name in ("quaternion", "gyroscope", "accelerometer"):
            message[f"imu_state.{name}"] = now[name]
        for name, of in zip(STATE_FIELDS, (now, mixed, now), strict=True):
            message[name] = of[name.partition(".")[2]][self._back]
        if not self.ticking:
            return PackedMessage(self.dialect.state, bytes(message.data))
        message["tick"] = round(self.time * 1e3)
        return PackedMessage(self.dialect.state, bytes(message.seal().data))

    def send(self, message: PackedMessage) -> None:
        """Make torques of a command, whatever its checksum, from the state of this instant."""
        super().send(message)
        count = self.robot.joints
        rows = (message[name][:count].astype(float)[self._order] for name in COMMAND_FIELDS)
        self._take(JointTargets(*rows))

    def _take(self, targets: JointTargets) -> None:
        """Turn joint targets into torques, from the angles and speeds of now."""
        self.torques = targets.torques(self._now["q"], self._now["dq"])

    def receive(self, timeout: float) -> PackedMessage | None:
        """Let the time go by until it speaks."""
        until = self.clock.now + max(timeout, 0.0)
        while min(self._next_step, self._next_word) <= until:
            if self._next_step <= self._next_word:
                self.clock.now = max(self.clock.now, self._next_step)
                self._next_step += self.dt
                self._step()
                continue
            self.clock.now = max(self.clock.now, self._next_word)
            period = 1e-3 if self.ticking else self.dt
            self._next_word += period * (1.0 + 0.3 * self._random.uniform(-1.0, 1.0))
            return self._say()
        self.clock.now = until
        return None


class BusyReplica(BridgeReplica):
    """The simulator on a computer that others use: commands come late, and both sides stand still at times.

    Parameters
    ----------
    robot, rate, seed
        See there.
    lag
        The longest time from a command to its torques [s]; each takes a random share of it.
    pauses, longest
        How often the simulator is held up [Hz], and for how long at most [s]; the listener as often, for
        three steps at most, in which the robot goes on under the torques that it has.
    """

    def __init__(
        self, robot: sf.Robot, rate: float, *, seed: int = 0, lag: float = 0.0, pauses: float = 0.0,
        longest: float = 0.0,
    ) -> None:  # fmt: skip
        super().__init__(robot, rate, seed=seed)
        self.lag, self.pauses, self.longest = lag, pauses, longest
        self._coming: list[tuple[float, JointTargets]] = []

    def _take(self, targets: JointTargets) -> None:
        due = self.clock.now + self.lag * self._random.random()
        self._coming.append((max([due, *(time for time, _ in self._coming)]), targets))

    def _step(self) -> None:
        while self._coming and self._coming[0][0] <= self.clock.now:
            super()._take(self._coming.pop(0)[1])
        super()._step()
        if self._random.random() < self.pauses * self.dt:
            pause = self.longest * self._random.random()
            self._next_step, self._next_word = self._next_step + pause, self._next_word + pause

    def receive(self, timeout: float) -> PackedMessage | None:
        """Let the time go by until it speaks; at times the listener is held up, and hears the last word."""
        message = super().receive(timeout)
        if self._random.random() < self.pauses * self.dt:
            end = self.clock.now + 3.0 * self.dt * self._random.random()
            while (later := super().receive(end - self.clock.now)) is not None:
                message = later
        return message


LENGTH, GIVES, EASES = 1.0, 0.02, 0.05
"""Of a strap: its length and by how much a quarter of the weight stretches it [m], how fast it calms [s]."""
CORNERS = np.array([[x, y, 0.0] for x in (-0.2, 0.2) for y in (-0.1, 0.1)])
"""Where straps hold a trunk, in its axes [m]."""


class HungReplica(BridgeReplica):
    """The simulator with a robot that hangs, its feet above the ground.

    Parameters
    ----------
    robot, level
        Which one, and whether straps hold its trunk level, or an elastic band the origin of its base alone.
    """

    def __init__(self, robot: sf.Robot, level: bool) -> None:
        super().__init__(robot, 500.0)
        self.level, q = level, robot.nominal.copy()
        q[2] += 0.12
        self.height = float(q[2]) + LENGTH
        self.world.reset(q)
        self._now = self._before = self._sensed()

    def _step(self) -> None:
        """Go on by a step, held from above."""
        q, v = self.world.q_v()
        rotation, weight = rotation_from_quaternion(q[3:7]), self.robot.mass * 9.81
        force, moment = np.zeros(3), np.zeros(3)
        for corner in CORNERS if self.level else [np.zeros(3)]:
            arm = rotation @ corner
            way = np.array([*corner[:2], self.height]) - q[:3] - arm
            length = float(np.linalg.norm(way))
            up, speed = way / length, rotation @ v[:3] + np.cross(rotation @ v[3:6], arm)
            stiffness = weight / GIVES * (0.25 if self.level else 1.0)
            pull = max(stiffness * (length - LENGTH + GIVES - EASES * float(speed @ up)), 0.0) * up
            force += pull
            moment += np.cross(arm, pull)
        body = 1  # the base: MuJoCo's forces act at its centre of mass
        centre = self.world.data.xipos[body] - q[:3]
        self.world.data.xfrc_applied[body, 3:] = moment - np.cross(centre, force)
        self._push = force
        super()._step()
