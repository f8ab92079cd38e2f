"""How a log is spoilt: a copy to write to, where feet stand or fly; faults of its state and its clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log

LENGTH = 0.12
"""Usual length of a fault [s]."""
Numbers: TypeAlias = np.random.Generator


@dataclass(frozen=True)
class FaultyLog:
    """A log with a fault in it.

    Attributes
    ----------
    log
        The spoilt log; the clean one is untouched.
    contact
        Name of the foot, "all" or "body".
    start, end
        Of the fault [s].
    fault, symptom
        Its kind, and what an audit should report of it first.
    """

    log: Log
    contact: str
    start: float
    end: float
    fault: str = ""
    symptom: str = ""


class LogCopy:
    """A log's arrays to write to, and where its feet stand and fly."""

    def __init__(self, log: Log, rng: Numbers) -> None:
        self.arrays: dict[str, Any] = {name: np.array(array) for name, array in log.arrays.items()}
        self.facts, self.channels, self.rng = dict(log.facts), log.channels, rng
        self.dt, self.weight = float(log.fact("dt")), float(log.fact("mass")) * GRAVITY
        self.feet = list(log.fact("feet"))
        self.normal = self.arrays["forces"][..., 2].copy()
        self.rows, joints = len(log), np.arange(self.arrays["torques"].shape[1])
        alike = 0 < self.normal.shape[1] == len(self.feet) and joints.size % len(self.feet) == 0
        if not alike or self.rows < 200 + 0.25 / self.dt:
            raise ProblemError(
                "faults want a robot on point feet, legs alike, and 200 rows and 0.25 s or more"
            )
        self.legs = joints.reshape(len(self.feet), -1)

    def span(self, on: BoolArray, seconds: float = LENGTH) -> tuple[int, slice] | None:
        """Return a foot and rows, so long at least, where (T, n) flags are on; away from the log's ends."""
        need, found = max(3, round(seconds / self.dt)), []
        for foot in range(on.shape[1]):
            for a, b in runs_of(on[:, foot]):
                low, high = max(a, 50), min(b, self.rows - 50)
                if high - low >= need:
                    found.append((foot, low, high - need))
        if not found:
            return None
        foot, low, high = found[int(self.rng.integers(len(found)))]
        start = int(self.rng.integers(low, high + 1))
        return foot, slice(start, start + need)

    def stance(self, share: float = 0.1, seconds: float = LENGTH) -> tuple[int, slice] | None:
        """Return a foot and rows where it bears more than a share of m g."""
        return self.span(self.normal > share * self.weight, seconds)

    def swing(self, seconds: float = 0.06) -> tuple[int, slice] | None:
        """Return a foot and rows in which it swings: at least 5 mm off the ground, without load."""
        return self.span((self.arrays["gaps"] > 5e-3) & (self.normal == 0.0), seconds)

    def faulty_log(self, contact: str, part: slice) -> FaultyLog:
        """Return the spoilt log."""
        time = self.arrays["time"]
        log = Log(self.arrays, self.facts, channels=self.channels)
        return FaultyLog(log, contact, float(time[part.start]), float(time[part.stop - 1]) + self.dt)

    def whole(self, contact: str = "all") -> FaultyLog:
        """Return the spoilt log of a fault that lasts from end to end."""
        return self.faulty_log(contact, slice(0, self.rows))


Change: TypeAlias = Callable[[LogCopy, Any, slice, float], None]
"""Spoils some rows of one foot, or of all of them (a slice), by an amplitude."""
Spoil: TypeAlias = Callable[[LogCopy, float], FaultyLog | None]
"""Spoils a copy of a log by an amplitude; None where the run does not suit it."""


def on_stance(change: Change, share: float = 0.1) -> Spoil:
    """Return a fault that changes the readings of a stance foot."""
    return _on_rows(change, lambda copy: copy.stance(share))


def on_swing(change: Change) -> Spoil:
    """Return a fault that changes the readings of a swing foot."""
    return _on_rows(change, LogCopy.swing)


def _on_rows(change: Change, find: Callable[[LogCopy], tuple[int, slice] | None]) -> Spoil:
    """Return a fault that changes the rows that `find` finds; None where it finds none."""

    def spoil(copy: LogCopy, amplitude: float) -> FaultyLog | None:
        at = find(copy)
        if at is None:
            return None
        change(copy, *at, amplitude)
        return copy.faulty_log(copy.feet[at[0]], at[1])

    return spoil


def everywhere(change: Change, contact: str = "all") -> Spoil:
    """Return a fault that changes a log from end to end."""

    def spoil(copy: LogCopy, amplitude: float) -> FaultyLog:
        change(copy, slice(None), slice(None), amplitude)
        return copy.whole(contact)

    return spoil


def _part(c: LogCopy, seconds: float) -> slice:
    """Return rows of so many seconds, away from the log's ends."""
    need = round(seconds / c.dt)
    start = int(c.rng.integers(60, c.rows - need - 60))
    return slice(start, start + need)


def teleport(c: LogCopy, amplitude: float) -> FaultyLog:
    """Move the base, and the contacts with it, aside by an amplitude [m]."""
    part = _part(c, 2.0 * c.dt)
    angle = c.rng.uniform(0.0, 2.0 * np.pi)
    way = amplitude * np.array([np.cos(angle), np.sin(angle)])
    c.arrays["q"][part.start :, :2] += way
    c.arrays["contact_positions"][part.start :, :, :2] += way
    return c.faulty_log("body", part)


def velocity_jump(c: LogCopy, amplitude: float) -> FaultyLog:
    """Add to the base's velocity for two rows [m/s]."""
    part = _part(c, 2.0 * c.dt)
    c.arrays["v"][part, 0] += amplitude
    return c.faulty_log("body", part)


def no_velocities(c: LogCopy, amplitude: float) -> FaultyLog | None:
    """Zero all velocities for a time [s]; None for a robot that stands."""
    part = _part(c, amplitude)
    if np.abs(c.arrays["v"][part, :3]).max(axis=0).max() < 0.1:
        return None  # it stands: zero is right
    c.arrays["v"][part] = 0.0
    return c.faulty_log("body", part)


def encoder_jump(c: LogCopy, amplitude: float) -> FaultyLog:
    """Shift a joint's angle from a row on [rad]."""
    part = _part(c, 2.0 * c.dt)
    c.arrays["q"][part.start :, 7 + int(c.rng.integers(c.arrays["q"].shape[1] - 7))] += amplitude
    return c.faulty_log("body", part)


def held_rows(c: LogCopy, amplitude: float) -> FaultyLog | None:
    """Repeat a row for a time [s]; None for a robot that stands."""
    part = _part(c, amplitude)
    if np.linalg.norm(c.arrays["v"][part, :3], axis=1).min() < 0.1:
        return None  # it stands: a row is like the one before
    for name, array in c.arrays.items():
        if name != "time":
            array[part] = array[part.start]
    return c.faulty_log("body", part)


def dead_torque(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    """Take the torque of the foot's last joint away."""
    c.arrays["torques"][part, c.legs[foot, -1]] = 0.0


def not_finite(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    """Make a foot's forces NaN."""
    c.arrays["forces"][part, foot] = np.nan


def clock(shift: Callable[[FloatArray, int], None]) -> Spoil:
    """Return a fault that shifts the time stamps from a row on."""

    def spoil(c: LogCopy, amplitude: float) -> FaultyLog | None:
        row = int(c.rng.integers(100, c.rows - 100))
        shift(c.arrays["time"], row)
        return c.faulty_log("body", slice(row, row + 2))

    return spoil


def twice(time: FloatArray, row: int) -> None:
    """Repeat a stamp of (T,) time [s]."""
    time[row] = time[row - 1]


def back(time: FloatArray, row: int) -> None:
    """Set the clock of (T,) time back [s]."""
    time[row:] -= 0.05


def gap_in_time(time: FloatArray, row: int) -> None:
    """Leave rows out: (T,) time goes on later [s]."""
    time[row:] += 0.1
