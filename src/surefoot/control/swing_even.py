"""The path of a foot that swings fast over even ground: the lowest joint speeds for a given time.

A minimum-jerk step spends its time at the ends and hurries through the middle: its peak speed is 1.875
times the mean. Here the acceleration falls along a line from one end of the swing to the other, which is the
least mean square acceleration for a given time and a peak of 1.5 times the mean speed, and is ramped at both
ends so that torques do not jump. The foot moves back towards its hip from the first moment on, so a leg that
trails behind a fast body is stretched less. Upwards it follows one smooth bump.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.swing import DOWN, sinking
from surefoot.kernels import kernel

RAMP = 0.15
"""Share of the swing over which the acceleration along the ground rises from zero, and falls to it."""


LAND = 0.9
"""Share of the swing after which the foot does not move along the ground any more."""
BUMP = 1.0 / ((6.0 / 11.0) ** 3 * (5.0 / 11.0) ** 2.5)
"""Makes the height of the bump s³ (1 - s)^2.5 one."""


@kernel
def ramped_step(share: float, ramp: float = RAMP) -> tuple[float, float, float]:
    """Return the step from 0 to 1 with a ramped linear acceleration, and its two derivatives.

    Its acceleration is A (1 - 2 s), times s / ramp at the beginning and (1 - s) / ramp at the end.

    Parameters
    ----------
    share
        Of its time; 0 and 1 are the ends.
    ramp
        Share of the time over which the acceleration rises, above 0 and at most 0.5.

    Examples
    --------
    >>> [round(v, 6) for v in ramped_step(0.5)[:2]]
    [0.5, 1.729175]
    """
    s = min(max(share, 0.0), 1.0)
    mirrored = s > 0.5
    t = 1.0 - s if mirrored else s
    r = ramp
    vr, xr = r / 2.0 - 2.0 * r * r / 3.0, r * r / 6.0 - r * r * r / 6.0
    er, ir = r - r * r, r * r / 2.0 - r * r * r / 3.0
    half = xr + vr * (0.5 - r) + (1.0 / 8.0 - 1.0 / 24.0) - ir - er * (0.5 - r)
    A = 0.5 / half
    if t < r:
        a, v, x = t / r * (1.0 - 2.0 * t), (t * t / 2.0 - 2.0 * t**3 / 3.0) / r, (t**3 - t**4) / (6.0 * r)
    else:
        a, v = 1.0 - 2.0 * t, vr + (t - t * t) - er
        x = xr + vr * (t - r) + (t * t / 2.0 - t**3 / 3.0) - ir - er * (t - r)
    if mirrored:
        return 1.0 - A * x, A * v, -A * a
    return A * x, A * v, A * a


@kernel
def smooth_bump(share: float) -> tuple[float, float, float]:
    """Return the bump C s³ (1 - s)^2.5 of the share s over `DOWN`, 1 at s = 6/11, and its two derivatives.

    Velocity and acceleration are zero at both ends: what is left to the ground is left to the descent. It
    comes down faster than it went up: a foot that is close to the ground for long before it should land
    touches it while it still moves along it.

    Examples
    --------
    >>> [round(v, 6) for v in smooth_bump(6.0 / 11.0 * DOWN)[:2]]
    [1.0, 0.0]
    """
    s = min(max(share / DOWN, 0.0), 1.0)
    r = 1.0 - s
    root = math.sqrt(r)
    return (
        BUMP * s * s * s * r * r * root,
        BUMP * s * s * r * root * (3.0 - 5.5 * s) / DOWN,
        BUMP * s * root * (6.0 * r * r - 15.0 * s * r + 3.75 * s * s) / (DOWN * DOWN),
    )


@kernel
def even_swing(
    start: FloatArray, target: FloatArray, apex: float, share: float, duration: float, descent: float
) -> FloatArray:
    """Return place, velocity and acceleration of a foot in the air: (3, 3).

    Parameters
    ----------
    start, target
        (3,) lift-off and wanted touchdown, world axes [m].
    apex
        Height of the path at its middle, world z [m].
    share
        Time since lift-off over the duration; above 1 the foot is late and goes on down.
    duration
        Length of the swing [s].
    descent
        Speed towards the ground at the end and after it [m/s], >= 0.

    Examples
    --------
    >>> even_swing(np.zeros(3), np.array([0.1, 0.0, 0.0]), 0.05, 0.5, 0.2, 0.0)[0].round(6)
    array([0.059552, 0.      , 0.049798])
    """
    out = np.zeros((3, 3))
    length = LAND * duration
    b, db, ddb = ramped_step(share / LAND)
    for i in range(3):
        d = target[i] - start[i]
        out[0, i], out[1, i], out[2, i] = start[i] + b * d, db * d / length, ddb * d / (length * length)
    h, dh, ddh = smooth_bump(share)
    rise = apex - 0.5 * (start[2] + target[2])
    out[0, 2] += h * rise
    out[1, 2] += dh * rise / duration
    out[2, 2] += ddh * rise / (duration * duration)
    gain, sunk, speed, change = sinking(share, duration, descent)
    b, db, ddb = ramped_step(2.0 * share)  # what the descent takes is gained on the way up
    out[0, 2] += gain * b - sunk
    out[1, 2] += 2.0 * gain * db / duration - speed
    out[2, 2] += 4.0 * gain * ddb / (duration * duration) - change
    return out
