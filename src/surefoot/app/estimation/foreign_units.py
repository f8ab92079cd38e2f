"""Units of a stranger's log, guessed from what a robot can do; each guess is told."""

from __future__ import annotations

import numpy as np

from surefoot.app.estimation.standing_feet import Misfit
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records import Log

CLOCKS = {"milliseconds": 1e-3, "microseconds": 1e-6, "nanoseconds": 1e-9}
"""What a time may be counted in, if not in seconds."""
RATES = (5e-5, 0.25)
"""Time between rows [s] of a log that an estimate is made of: 20 kHz to 4 Hz."""
TURN = 7.0
"""Largest angle [rad] of a joint: a larger one is in degrees."""
FASTEST = 35.0
"""Largest turn rate [rad/s] of an IMU's range, 2000 °/s: a larger one is in degrees per second."""
HEAVY = (0.5, 2.0)
"""Mean specific force [g] that is told in g and not in m/s²."""
TURNED = -0.8
"""Cosine between the mean specific force and the body's vertical below which its sign is the other one's."""
DEGREE = float(np.pi / 180.0)
MOMENTS, STILL = 20, 5e-3
"""Moments that tell a unit of turn rates, and misfit without any turn [m/s] up to which legs are still."""
APART, PLAINLY, NEARER = 0.1, 0.25, 5.0
"""Misfit [m/s] by rates in rad/s from which they may be in degrees per second, and are even where these fit
no better than none do (in another order of the joints); how many times the misfit by the latter that is."""


def in_seconds(log: Log, told: list[str]) -> Log:
    """Return the log with its time in seconds, from its first row on where the clock is another one."""
    if len(log) < 2:
        return log
    time = np.asarray(log["time"], dtype=np.float64)
    step = float(np.median(np.diff(time)))
    if not step > RATES[1]:
        return log
    for unit, size in CLOCKS.items():
        if RATES[0] < size * step <= RATES[1]:
            told.append(f"time is in {unit}: rows are {step:g} apart")
            return Log({**log.arrays, "time": size * (time - time[0])}, log.facts)
    return log


def to_si(gyro: FloatArray, force: FloatArray, joints: FloatArray, told: list[str]) -> float:
    """Turn (T, 3) and (T, joints) readings into SI units in place by size; return the joints' factor."""
    factor = 1.0
    if np.abs(joints).max() > TURN:
        factor = DEGREE
        joints *= factor
        told.append("joint angles are in degrees: they go beyond 7")
    if np.abs(gyro).max() > FASTEST:
        gyro *= DEGREE
        told.append("turn rates are in degrees per second: they go beyond 35")
    size = float(np.median(np.linalg.norm(force, axis=1)))
    if HEAVY[0] < size < HEAVY[1]:
        force *= 9.80665
        told.append(f"specific forces are in g: {size:.2f} in the middle")
    mean = np.median(force, axis=0)
    if mean[2] < TURNED * np.linalg.norm(mean):
        force *= -1.0
        told.append("specific forces point down, as gravity does: their sign is turned")
    return factor


def turn_by_feet(
    misfit: Misfit, order: IntArray, feet: IntArray, gyro: FloatArray, told: list[str]
) -> bool:  # fmt: skip
    """Turn rates (T, 3) in degrees per second that no size tells into rad/s in place; return if they were.

    By 57 times its turn rates a body's standing feet would race apart, and no wrong order of the joints
    parts them as much.
    """
    if misfit.moments < MOMENTS:
        return False
    given, small, none = (misfit(order, feet, share) for share in (1.0, DEGREE, 0.0))
    least = APART if small < 0.9 * none else PLAINLY
    if not (none > STILL and given > max(least, NEARER * small)):
        return False
    gyro *= DEGREE
    told.append(
        f"turn rates are in degrees per second: in rad/s standing feet would part at {given:.2f} m/s, "
        f"so at {small:.2f}"
    )
    return True
