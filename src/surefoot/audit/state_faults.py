"""Faults of a log's state and clock: positions, velocities, torques, rows and time stamps that are spoilt."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.audit.spoiling import FaultyLog, LogCopy, Spoil


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
    return c.done("body", part)


def velocity_jump(c: LogCopy, amplitude: float) -> FaultyLog:
    """Add to the base's velocity for two rows [m/s]."""
    part = _part(c, 2.0 * c.dt)
    c.arrays["v"][part, 0] += amplitude
    return c.done("body", part)


def no_velocities(c: LogCopy, amplitude: float) -> FaultyLog | None:
    """Zero all velocities for a time [s]; None for a robot that stands."""
    part = _part(c, amplitude)
    if np.abs(c.arrays["v"][part, :3]).max(axis=0).max() < 0.1:
        return None  # it stands: zero is right
    c.arrays["v"][part] = 0.0
    return c.done("body", part)


def encoder_jump(c: LogCopy, amplitude: float) -> FaultyLog:
    """Shift a joint's angle from a row on [rad]."""
    part = _part(c, 2.0 * c.dt)
    c.arrays["q"][part.start :, 7 + int(c.rng.integers(c.arrays["q"].shape[1] - 7))] += amplitude
    return c.done("body", part)


def held_rows(c: LogCopy, amplitude: float) -> FaultyLog | None:
    """Repeat a row for a time [s]; None for a robot that stands."""
    part = _part(c, amplitude)
    if np.linalg.norm(c.arrays["v"][part, :3], axis=1).min() < 0.1:
        return None  # it stands: a row is like the one before
    for name, array in c.arrays.items():
        if name != "time":
            array[part] = array[part.start]
    return c.done("body", part)


def dead_torque(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    """Take the torque of the foot's last joint away."""
    joints = np.arange(c.arrays["torques"].shape[1]).reshape(len(c.feet), -1)
    c.arrays["torques"][part, joints[foot, -1]] = 0.0


def not_finite(c: LogCopy, foot: int, part: slice, amplitude: float) -> None:
    """Make a foot's forces NaN."""
    c.arrays["forces"][part, foot] = np.nan


def clock(shift: Callable[[FloatArray, int], None]) -> Spoil:
    """Return a fault that shifts the time stamps from a row on."""

    def spoil(c: LogCopy, amplitude: float) -> FaultyLog | None:
        row = int(c.rng.integers(100, c.rows - 100))
        shift(c.arrays["time"], row)
        return c.done("body", slice(row, row + 2))

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
