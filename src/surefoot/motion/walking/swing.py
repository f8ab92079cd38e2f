"""The path of a foot through the air: smooth, clear of the ground, and down gently.

Where edges may be in the way the foot lifts first and lands straight (`swing_motion`): minimum-jerk steps,
which spend their time at the ends and hurry through the middle, at 1.875 times the mean speed.

Over even ground (`even_swing`) the acceleration falls along a line from one end of the swing to the other,
which is the least mean square acceleration for a given time and a peak of 1.5 times the mean speed, and is
ramped at both ends so that torques do not jump. The foot moves back towards its hip from the first moment on,
so a leg that trails behind a fast body is stretched less. Upwards it follows one smooth bump.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.mechanics import Terrain
from surefoot.motion.walking.feet_settings import SWING_PATH

RISE, DOWN = SWING_PATH.rise, SWING_PATH.down
LIFT_FIRST, DOWN_LAST = SWING_PATH.lift_first, SWING_PATH.straight_from
RAMP, LAND = SWING_PATH.ramp, SWING_PATH.land
"""Settings, as compiled code folds them."""
LIFT_LATER = (LIFT_FIRST, 0.16, 0.24, 0.32)
"""Shares to try in place of `LIFT_FIRST` where an edge is in the way."""
EVEN = -1.0
"""Stands in place of `LIFT_FIRST` for the swing over even ground."""
BUMP = 1.0 / ((6.0 / 11.0) ** 3 * (5.0 / 11.0) ** 2.5)
"""Makes the height of the bump s³ (1 - s)^2.5 one."""


@kernel
def minimum_jerk(share: float) -> tuple[float, float, float]:
    """Return the minimum-jerk step from 0 to 1 and its two derivatives at a share of its time.

    s³ (10 - 15 s + 6 s²): the polynomial whose velocity and acceleration vanish at both ends.

    Examples
    --------
    >>> minimum_jerk(0.5)[:2]
    (0.5, 1.875)
    """
    # Clamped: a foot that is late stays at the end of its step and goes on with the descent alone.
    s = min(max(share, 0.0), 1.0)
    r = 1.0 - s
    return (
        s * s * s * (10.0 + s * (6.0 * s - 15.0)),
        30.0 * s * s * r * r,
        60.0 * s * r * (1.0 - 2.0 * s),
    )


@inline_kernel
def sinking(
    share: float, duration: float, descent: float, down: float = DOWN
) -> tuple[float, float, float, float]:
    """Return how a foot sinks at the end of a swing: what it has to gain before, way, speed and its change.

    The speed grows to `descent` over a quarter of the swing and stays; with the gain the path meets the
    ground when the speed is four fifths of it, at the share `down` [m, m, m/s, m/s²].
    """
    # Speed 4 descent late up to a quarter, then descent: at `down`, late = 0.2, the speed is 0.8 descent and
    # the way 2 (0.2)² = 0.08 descent duration, the gain. Started a fifth early it meets the ground while it
    # still speeds up, so a foot that lands on time strikes with less than the full descent.
    late = max(share - down + 0.2, 0.0)
    way = descent * duration * (2.0 * late * late if late < 0.25 else late - 0.125)
    change = 4.0 * descent / duration if 0.0 < late < 0.25 else 0.0
    return 0.08 * descent * duration, way, descent * min(4.0 * late, 1.0), change


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
    # The step is odd about its middle: x(1 - s) = 1 - x(s), so only the first half is worked out.
    mirrored = s > 0.5
    t = 1.0 - s if mirrored else s
    r = ramp
    # Speed and way at the end of the ramp, for A = 1, and what the unramped 1 - 2 s would have there, which
    # is taken off its integrals after the ramp. A scales the way at the middle to one half.
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
    """Return place, velocity and acceleration of a foot over even ground: (3, 3).

    Parameters are those of `swing_motion`, but `apex` is the height of the path at its middle.

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
    # Upwards the straight line between the ends plus a bump, which brings the path to `apex` about its
    # middle.
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


@kernel
def swing_motion(
    start: FloatArray,
    target: FloatArray,
    apex: float,
    share: float,
    duration: float,
    descent: float,
    lift_first: float = LIFT_FIRST,
    down: float = DOWN,
) -> FloatArray:
    """Return place, velocity and acceleration of a foot in the air: (3, 3).

    Sideways one minimum-jerk step; upwards one to the apex and one down again, to which the descent is added:
    the foot meets the ground with it, and keeps going down if it is late.

    Parameters
    ----------
    start, target
        (3,) lift-off and wanted touchdown, world axes [m].
    apex
        Height of the highest point, world z [m]; at least that of both ends.
    share
        Time since lift-off over the duration; above 1 the foot is late.
    duration
        Length of the swing [s].
    descent
        Speed towards the ground at the end and after it [m/s], >= 0.
    lift_first
        Share of the swing before the foot moves sideways; negative (`EVEN`) over even ground.
    down
        Share of the swing after which the foot only sinks; it does not move sideways either.

    Examples
    --------
    >>> swing_motion(np.zeros(3), np.array([0.1, 0.0, 0.0]), 0.05, 0.45, 0.2, 0.0)[0].round(6)
    array([0.038944, 0.      , 0.05    ])
    """
    if lift_first < 0.0:
        return even_swing(start, target, apex, share, duration, descent)
    out = np.zeros((3, 3))
    # Sideways only once the foot has lifted, and no more when it comes down: it shall not touch an edge on
    # its way up, nor the ground while it still moves along it.
    straight = min(DOWN_LAST, down)
    length = duration * (straight - lift_first)
    b, db, ddb = minimum_jerk((share - lift_first) / (straight - lift_first))
    for i in range(2):
        d = target[i] - start[i]
        out[0, i], out[1, i], out[2, i] = start[i] + b * d, db * d / length, ddb * d / (length * length)
    gain, sunk, speed, change = sinking(share, duration, descent, down)
    # Two minimum-jerk steps meet at the apex at rest, raised by what the descent takes until touchdown.
    if share < RISE:
        length, part, begin, end = duration * RISE, share / RISE, start[2], apex + gain
    else:
        length, part = duration * (down - RISE), (share - RISE) / (down - RISE)
        begin, end = apex + gain, target[2] + gain
    b, db, ddb = minimum_jerk(part)
    d = end - begin
    out[0, 2], out[1, 2] = begin + b * d - sunk, db * d / length - speed
    out[2, 2] = ddb * d / (length * length) - change
    return out


@kernel
def swing_places(
    start: FloatArray, target: FloatArray, apex: float, shares: FloatArray, lift_first: float
) -> FloatArray:
    """Return the (k, 3) places [m] at (k,) shares of a swing without descent; see `swing_motion`."""
    out = np.empty((shares.size, 3))
    for k in range(shares.size):
        out[k] = swing_motion(start, target, apex, shares[k], 1.0, 0.0, lift_first)[0]
    return out


def apex_height(start: FloatArray, target: FloatArray, ground: FloatArray, clearance: float) -> float:
    """Return the height that clears the ground below the path [m].

    Parameters
    ----------
    start, target
        (3,) ends of the swing [m].
    ground
        (k,) heights of the ground below the path, plus the foot's radius [m].
    clearance
        Room to leave below the foot at its highest [m].
    """
    return max(float(start[2]), float(target[2]), float(np.max(ground, initial=-math.inf))) + clearance


def clear_lift(
    start: FloatArray, target: FloatArray, apex: float, terrain: Terrain, radius: float, room: float
) -> float:
    """Return the share of the swing to lift before moving sideways so that the foot clears the ground.

    Parameters
    ----------
    start, target
        (3,) ends of the swing [m].
    apex
        Height of the highest point [m].
    terrain
        The ground below.
    radius
        Of the foot [m].
    room
        Distance to keep from edges, all around the foot [m].
    """
    shares = np.linspace(0.1, 0.9, 17)
    along = target[:2] - start[:2]
    length = math.hypot(float(along[0]), float(along[1]))
    # The ground is looked at below the foot and ahead of it: an edge strikes the front of the foot first.
    reach = (radius + room) * along / length if length > 1e-6 else np.zeros(2)
    best, least = LIFT_FIRST, math.inf
    # The least delay that clears is taken: the later a foot moves sideways, the faster it has to.
    for lift in LIFT_LATER:
        path = swing_places(start, target, apex, shares, lift)
        ground = terrain.height(np.concatenate([path[:, :2], path[:, :2] + reach])).reshape(2, -1).max(axis=0)
        miss = float((ground + radius - path[:, 2]).max())
        if miss <= 0.0:
            return lift
        if miss < least - 1e-4:
            best, least = lift, miss
    return best
