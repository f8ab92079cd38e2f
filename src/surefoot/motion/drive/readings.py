"""What a robot's sensors and motors say at one instant, and whether that can be used."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, numbers, real_number
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.memory import Remembering
from surefoot.base.spatial import tilt_of
from surefoot.mechanics import Robot
from surefoot.motion.drive.reading_checks import (
    ReadingFault,
    beyond,
    contradicts,
    frozen,
)

REPEATS, MOVING = 8, 0.3
"""Readings in a row in which a sensor says the same to the last digit while a joint elsewhere moves faster
than this [rad/s]: it is frozen. White noise in steps repeats itself twice or three times."""
FORGET = 0.9
"""What is kept of the mismatch between angles and speeds from one reading to the next."""
REASONS = (
    "", "a reading is not finite", "the attitude is no unit quaternion", "the turn rate is out of range",
    "the acceleration is out of range", "a joint is out of range", "a sensor is frozen",
    "a joint's angles contradict its speeds", "the attitude contradicts the gyro",
)  # fmt: skip
"""By `ReadingFault`."""
CONTRADICTIONS = 3
"""Contradictory readings in a row that end the patience with them."""


class RobotReadings(NamedTuple):
    """What a robot's sensors and motors say at one instant; joints in the order of the loop's motors.

    Attributes
    ----------
    time
        By the robot's own clock [s].
    quaternion
        (4,) attitude (x, y, z, w) by the IMU [-]; its heading is never used.
    gyro, accelerometer
        (3,) turn rate [rad/s] and specific force [m/s²], base axes.
    positions, speeds, torques
        (joints,) of the encoders [rad], [rad/s], and of the motors [N m].
    forces
        (n,) normal forces of the feet's sensors [N], feet as the robot names them; None where it has none.
    """

    time: float
    quaternion: FloatArray
    gyro: FloatArray
    accelerometer: FloatArray
    positions: FloatArray
    speeds: FloatArray
    torques: FloatArray
    forces: FloatArray | None = None

    def ordered(self, order: IntArray) -> RobotReadings:
        """Return the readings with joints in another order, (joints,) numbers of them."""
        q, v, torques = self.positions[order], self.speeds[order], self.torques[order]
        return RobotReadings(*self[:4], q, v, torques, self.forces)

    def arrange(self, order: IntArray) -> RobotReadings | None:
        """Return the readings in another order, (joints,) numbers of joints; None for what is no reading."""
        joints = order.shape
        try:
            time, rows = real_number("time", self.time), [numbers("a reading", row) for row in self[1:7]]
            forces = None if self.forces is None else numbers("forces", self.forces)
        except ProblemError:
            return None
        if [row.shape for row in rows] != [(4,), (3,), (3,), joints, joints, joints]:
            return None
        return RobotReadings._make([time, *rows, forces]).ordered(order)

    def loaded_feet(self, least: float) -> BoolArray | None:
        """Return which (n,) feet bear more than a force [N] by their own sensors; None without any."""
        if self.forces is None or not np.isfinite(self.forces).all():
            return None
        return np.asarray(self.forces > least)


def motor_order(robot: Robot, motors: Sequence[str] | None) -> tuple[IntArray, IntArray]:
    """Return where each of the robot's joints stands among the motors, (joints,), and the other way round."""
    names = robot.joint_names if motors is None else tuple(motors)
    if sorted(names) != sorted(robot.joint_names):
        wrong = next((n for n in names if n not in robot.joint_names), None)
        missing = ", ".join(n for n in robot.joint_names if n not in names)
        if wrong is not None:
            raise ProblemError(unknown_name(f"joint of {robot.name}", wrong, robot.joint_names))
        raise ProblemError(f"the motors must name each joint of {robot.name} once; missing: {missing}")
    order = np.array([names.index(name) for name in robot.joint_names], dtype=np.int64)
    return order, np.argsort(order)


@dataclass(frozen=True)
class ReadingLimits:
    """From where on readings are not believed.

    Attributes
    ----------
    patience
        Time without a reading that can be used after which joints are damped [s].
    outage
        The same after which they stay damped until somebody asks for more [s].
    latest
        How much older than usual a reading may be [s].
    beyond
        How far beyond its range a joint may be [rad].
    faster
        Speed of a joint over its limit.
    turning, hardest
        Largest turn rate [rad/s] and specific force [m/s²].
    mismatch, turned
        How far angles may be from what their speeds say, and the attitude from what the gyro says [rad].
    tilt
        Lean of the base at which the robot counts as fallen [rad].
    uneven
        Whether nobody knows how much of the robot's time lies between two readings, as of a simulator on a
        busy computer: after a gap, angles may be anywhere that their speed limits allow.
    """

    patience: float = 0.014
    outage: float = 0.1
    latest: float = 0.01
    beyond: float = 0.15
    faster: float = 1.5
    turning: float = 35.0
    hardest: float = 200.0
    mismatch: float = 0.04
    turned: float = 0.1
    tilt: float = 1.0
    uneven: bool = False

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if name != "uneven":
                real_number(name, getattr(self, name), low=1e-6)


class ReadingWatch(Remembering):
    """Says of each reading why it cannot be used.

    Parameters
    ----------
    robot
        Whose readings.
    dt
        Time between them [s].
    limits
        See there.

    Attributes
    ----------
    last
        The last reading that could be used; None before the first.
    silent
        How long ago that was [s].
    reason
        What was wrong since then; empty while all is well.
    """

    MEMORY = (
        "last", "silent", "reason", "_clock", "_offset", "_said", "_last", "_repeated", "_contradictions",
        "_kept",
    )  # fmt: skip

    def __init__(self, robot: Robot, dt: float, limits: ReadingLimits) -> None:
        self.dt, self.limits = dt, limits
        model, first = robot.model, robot.base_dof + 1
        self._low = np.array(model.lowerPositionLimit[first:]) - limits.beyond
        self._high = np.array(model.upperPositionLimit[first:]) + limits.beyond
        self._fastest = limits.faster * robot.speed_limits
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self.last: RobotReadings | None = None
        self.silent, self.reason = 0.0, ""
        self._clock, self._offset = -math.inf, math.inf
        joints = len(self._low)
        self._said, self._last = np.zeros((2, 10 + 3 * joints))
        self._repeated = np.zeros(3 + joints, dtype=np.int64)
        self._contradictions = 0
        self._compare_anew()

    def _compare_anew(self) -> None:
        """Forget by how much angles and attitude are off what speeds and gyro say."""
        self._kept = np.zeros(2 * len(self._low) + 4)

    @property
    def blind(self) -> bool:
        """Whether control is impossible."""
        return self.last is None or self._late or self.contradictory

    @property
    def _late(self) -> bool:
        """Whether patience is over; silence is a sum of steps, which rounding may leave just below it."""
        return self.silent >= self.limits.patience - 0.5 * self.dt

    @property
    def contradictory(self) -> bool:
        """Whether readings contradict themselves, while patience is not over."""
        return self._contradictions >= CONTRADICTIONS and not self._late

    @property
    def lean(self) -> float:
        """How far the base leans by the last usable reading [rad]; infinite before the first."""
        if self.last is None:
            return math.inf
        return tilt_of(self.last.quaternion)

    def look(self, readings: RobotReadings | None, now: float) -> bool:
        """Return whether a reading that came at a time [s] can be used; None for one that did not come."""
        fault = self._fault(readings, now)
        if fault:
            self.silent += self.dt
            self.reason = fault
            return False
        assert readings is not None
        self.silent, self.reason, self._contradictions, self.last = 0.0, "", 0, readings
        self._last = self._came
        return True

    def _fault(self, readings: RobotReadings | None, now: float) -> str:
        """Return why a reading cannot be used, empty if it can."""
        if readings is None:
            return "no reading came"
        said, limits = np.concatenate(readings[1:7]), self.limits
        self._came = said
        wrong = beyond(said, self._low, self._high, self._fastest, limits.turning, limits.hardest)
        if not math.isfinite(readings.time) or wrong == ReadingFault.ENDLESS:
            return REASONS[ReadingFault.ENDLESS]
        return (
            self._untimely(readings.time, now) or REASONS[wrong or self._contradictory(said, readings.time)]
        )

    def _untimely(self, time: float, now: float) -> str:
        """Return what is wrong with a reading's time."""
        before, self._clock = self._clock, time
        if self.silent >= self.limits.outage:  # what is late for so long has a clock that was held up
            self._offset = math.inf
        if time == before:
            return "a reading came twice"
        if time < before:  # out of order once, or a clock that was set back: the next one tells
            self._offset = math.inf
            return "a reading is older than the one before"
        # the fastest reading so far is as old as usual; a clock that drifts is followed
        self._offset = min(self._offset + 1e-4 * self.dt, now - time)
        return "a reading is late" if now - time > self._offset + self.limits.latest else ""

    def _contradictory(self, said: FloatArray, time: float) -> int:
        """Return what of a reading of a time [s] contradicts itself, or the reading before."""
        if self.last is None:
            self._said[:], self._repeated[:] = said, 0
            return ReadingFault.SOUND
        if frozen(said, self._said, self._repeated, MOVING, REPEATS - 1):
            self._contradictions = CONTRADICTIONS
            return ReadingFault.FROZEN
        limits = self.limits
        if self.silent >= limits.outage:  # damped since then, joints may be anywhere
            self._compare_anew()
            return ReadingFault.SOUND
        elapsed = self.silent + self.dt
        # faster than is believed, so that nothing was compared meanwhile
        flung = self.silent if self.reason == REASONS[ReadingFault.OUTSIDE] else 0.0
        if limits.uneven:
            flung = max(self.silent, time - self.last.time - self.dt)
        found = contradicts(
            said, self._last, self._kept, elapsed, FORGET ** (elapsed / self.dt), limits.mismatch,
            limits.turned, self._fastest, flung,
        )  # fmt: skip
        self._contradictions += found != ReadingFault.SOUND
        return found
