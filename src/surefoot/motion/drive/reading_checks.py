"""What makes a reading unusable, as kernels: the checks of `drive.readings` on its bare numbers.

A reading is (10 + 3 joints,) numbers: quaternion (x, y, z, w), gyro, accelerometer, angles, speeds, torques.
What it is held against is kept as (7 + 5 joints,), or fewer, numbers from one reading to the next.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.rotations import turn_between


class ReadingFault(IntEnum):
    """What is wrong with a reading; kernels return the values, as plain numbers."""

    SOUND = 0
    ENDLESS = 1
    """A number is not finite."""
    NO_UNIT = 2
    """The quaternion's length is not one."""
    TURNS = 3
    """The turn rate is out of range."""
    HARD = 4
    """The specific force is out of range."""
    OUTSIDE = 5
    """A joint is out of range."""
    FROZEN = 6
    """A sensor says the same for ever."""
    DRIFTS = 7
    """Angles contradict speeds."""
    TWISTS = 8
    """The attitude contradicts the gyro."""


TORQUES = 10
"""Where the joints begin in a reading."""


@kernel
def beyond(
    said: FloatArray, low: FloatArray, high: FloatArray, fastest: FloatArray, turning: float, hardest: float
) -> int:
    """Return what of a reading is out of range, by (joints,) ranges [rad], [rad/s] and sizes, or `SOUND`."""
    for x in said:  # first: no comparison below finds a NaN
        if not math.isfinite(x):
            return ReadingFault.ENDLESS.value
    length = math.sqrt(said[0] ** 2 + said[1] ** 2 + said[2] ** 2 + said[3] ** 2)
    if abs(length - 1.0) > 0.02:
        return ReadingFault.NO_UNIT.value
    for r in range(3):
        if abs(said[4 + r]) > turning:
            return ReadingFault.TURNS.value
    for r in range(3):
        if abs(said[7 + r]) > hardest:
            return ReadingFault.HARD.value
    joints = len(low)
    for j in range(joints):
        q, v = said[TORQUES + j], said[TORQUES + joints + j]
        if q < low[j] or q > high[j] or abs(v) > fastest[j]:
            return ReadingFault.OUTSIDE.value
    return ReadingFault.SOUND.value


@kernel
def frozen(said: FloatArray, before: FloatArray, repeated: IntArray, moving: float, most: int) -> bool:
    """Return whether a sensor repeats itself while others move; `before` becomes the reading.

    Parameters
    ----------
    said, before
        A reading and the one before.
    repeated
        (3 + joints,) how often quaternion, gyro, accelerometer and each encoder said the same; changed.
    moving
        Speed from which a joint moves [rad/s].
    most
        Repeats from which it is frozen.
    """
    joints = len(repeated) - 3
    moves, found = 0, False
    for j in range(joints):
        # A robot at rest repeats itself rightly: what counts is a sensor that does while others move.
        moves += abs(said[TORQUES + joints + j]) > moving
    for k in range(3 + joints):
        own = 0
        if k < 3:
            begin = (0, 4, 7)[k]
            same = True
            for i in range(begin, (4, 7, 10)[k]):
                same = same and said[i] == before[i]
        else:
            at = TORQUES + k - 3
            same = said[at] == before[at] and said[at + joints] == before[at + joints]
            own = int(abs(said[at + joints]) > moving)  # its own frozen speed is no witness against it
        repeated[k] = repeated[k] + 1 if same and moves - own > 0 else 0
        found = found or repeated[k] >= most
    before[:] = said
    return found


@kernel
def contradicts(
    said: FloatArray, last: FloatArray, kept: FloatArray, elapsed: float, keep: float, mismatch: float,
    turned: float, fastest: FloatArray, flung: float,
) -> int:  # fmt: skip
    """Return `DRIFTS` or `TWISTS` if angles contradict speeds, or the attitude the gyro; else `SOUND`.

    The trapezoid's error is within half the change of a speed, and is kept as long as the drift.

    Parameters
    ----------
    said, last
        A reading and the last that could be used.
    kept
        (2 joints + 4,) how far angles are off [rad], their room [rad], how far the attitude is off (3,) and
        its room [rad]; brought up to date if the reading is sound.
    elapsed, keep
        Time between the readings [s], and what is kept of the past.
    mismatch, turned
        What is allowed beyond the room [rad].
    fastest, flung
        (joints,) largest speeds [rad/s], and for how long joints may have had them [s].
    """
    joints = len(fastest)
    # With e the drift, s the room, and `keep` = exp(-elapsed / time constant):
    #     e+ = keep e + Δq - (v + v_last)/2 Δt,    s+ = keep s + |v - v_last|/2 Δt,    |e| <= mismatch + s
    # Both forget at one rate, so that rounding and small biases do not add up for ever.
    after = np.empty_like(kept)
    apart = False
    for j in range(joints):
        q, v = TORQUES + j, TORQUES + joints + j
        after[j] = keep * kept[j] + said[q] - last[q] - 0.5 * elapsed * (said[v] + last[v])
        # a turn is more than joints with limits make in an outage; without, room would be endless for good
        slack = min(flung * fastest[j], math.tau) if flung > 0.0 else 0.0
        after[joints + j] = keep * kept[joints + j] + 0.5 * elapsed * abs(said[v] - last[v]) + slack
        apart = apart or abs(after[j]) > mismatch + after[joints + j]
    if apart:
        return ReadingFault.DRIFTS.value
    # The same for the attitude: its turn less that of the mean gyro rate, as a rotation vector.
    far, change = 0.0, 0.0
    turn = _unexplained_turn(said, last, elapsed)
    for r in range(3):
        change = max(change, abs(said[4 + r] - last[4 + r]))
        after[2 * joints + r] = keep * kept[2 * joints + r] + turn[r]
        far = max(far, abs(after[2 * joints + r]))
    after[2 * joints + 3] = keep * kept[2 * joints + 3] + 0.5 * elapsed * change
    if far > turned + after[2 * joints + 3]:
        return ReadingFault.TWISTS.value
    kept[:] = after
    return ReadingFault.SOUND.value


@inline_kernel
def _unexplained_turn(said: FloatArray, last: FloatArray, elapsed: float) -> FloatArray:
    """Return the turn between two readings that their gyros do not tell, as a rotation vector (3,) [rad]."""
    # exp of the mean rate (ω + ω_last)/2 over `elapsed`, as a quaternion: half its angle is |ω + ω_last| Δt/4
    way = np.empty(4)
    rate = math.sqrt((said[4] + last[4]) ** 2 + (said[5] + last[5]) ** 2 + (said[6] + last[6]) ** 2)
    half = 0.25 * elapsed * rate
    for r in range(3):
        way[r] = math.sin(half) * (said[4 + r] + last[4 + r]) / max(rate, 1e-300)
    way[3] = math.cos(half)
    out = np.empty(3)
    turn_between(_times(last, way), said, out)
    return out


@inline_kernel
def _times(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the Hamilton product of quaternions (x, y, z, w)."""
    out = np.empty(4)
    out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    return out
