"""A cube in flight and on a plane: many tosses in one compiled call.

Free motion is exact: a parabola, and a turn about a fixed axis (the inertia is the same about every axis, so
that ω x Iω vanishes). Under the rigid law a step ends where a corner arrives, so that impacts happen on
the plane and not at the next whole step; soft laws take whole steps.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.estimation.cube_contact import CLOSED, GRAVITY, HALF, LAW, RIGID, exchange, place, rise
from surefoot.kernels import inline_kernel, kernel, releasing_kernel

ARRIVALS = 12
"""Arrivals of corners within a step; what arrives later waits for the next one."""
ASLEEP = 1e-7
"""Speed [m/s] under which a cube that its contacts hold for two steps stays for good."""


@inline_kernel
def fly(state: FloatArray, v: FloatArray, bend: FloatArray, t: float) -> None:
    """Move a state (position, quaternion) for a time t [s]: p += v t + bend t² / 2, and the turn ω t."""
    for a in range(3):
        state[a] += t * (v[a] + 0.5 * t * bend[a])
    rate = math.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
    half = 0.5 * rate * t
    share = 0.5 * t if half < 1e-8 else math.sin(half) / rate
    a, b, c, d = share * v[3], share * v[4], share * v[5], math.cos(half)
    x, y, z, w = state[3], state[4], state[5], state[6]
    state[3] = d * x + a * w + b * z - c * y
    state[4] = d * y + b * w + c * x - a * z
    state[5] = d * z + c * w + a * y - b * x
    state[6] = d * w - a * x - b * y - c * z


@inline_kernel
def _lowest(state: FloatArray, model: FloatArray) -> float:
    """Return a bound from below on the gaps of all corners, whatever the orientation."""
    return float(state[2] - 1.7320508075688772 * model[HALF])


@inline_kernel
def _near(gaps: FloatArray, arms: FloatArray, v: FloatArray, t: float, rigid: bool, near: IntArray) -> int:
    """List the corners that touch (rigid), or would overlap at the end of the step (soft)."""
    count = 0
    for k in range(8):
        if gaps[k] <= CLOSED if rigid else gaps[k] + t * rise(v, arms, k) < 0.0:
            near[count] = k
            count += 1
    return count


@inline_kernel
def _arrival(gaps: FloatArray, arms: FloatArray, v: FloatArray, drop: float, t: float) -> float:
    """Return when the first open corner reaches the plane, t if none does before.

    The corner's path is taken as a parabola with the centre's acceleration -drop; the rotation bends it by
    less than `CLOSED` in a millisecond.
    """
    first = t
    for k in range(8):
        if gaps[k] > CLOSED:
            speed = rise(v, arms, k)
            root = speed * speed + 2.0 * drop * gaps[k]
            if root >= 0.0:
                divisor = -speed + math.sqrt(root)
                if divisor > 0.0 and 2.0 * gaps[k] < divisor * first:
                    first = 2.0 * gaps[k] / divisor
    return first


@kernel
def _push(
    state: FloatArray, v: FloatArray, model: FloatArray, t: float, calm: float, arms: FloatArray,
    gaps: FloatArray, near: IntArray, after: FloatArray, last: FloatArray,
) -> tuple[int, bool]:  # fmt: skip
    """Fill the velocity after a time t under gravity and impulses; return the contacts, and if solved."""
    for a in range(6):
        after[a] = v[a] + (t * model[GRAVITY + a] if a < 3 else 0.0)
    count = _near(gaps, arms, after, t, model[LAW] == RIGID, near)
    good = True
    if count > 0:
        good = exchange(model, arms, gaps, near[:count], t, calm, v, after, last)
    return count, good


@kernel
def step(
    state: FloatArray, v: FloatArray, model: FloatArray, dt: float, bend: FloatArray, arms: FloatArray,
    gaps: FloatArray, near: IntArray, after: FloatArray, last: FloatArray,
) -> tuple[int, bool]:  # fmt: skip
    """Move a cube by dt; return the contacts at the end, and whether all contact problems were solved.

    Moved: state (7,) position and quaternion, v (6,) linear and angular velocity, both in the plane's axes.
    Memory: bend (3,), arms (8, 3), gaps (8,), near (8,), after (6,) and `last` (8, 4), see `exchange`.
    """
    left, count, solved = dt, 0, True
    gravity = model[GRAVITY : GRAVITY + 3]
    calm = 2.0 * dt * abs(model[GRAVITY + 2])
    for number in range(ARRIVALS):
        # what the velocity would be at the end
        place(state, model, arms, gaps)
        t = left
        count, good = _push(state, v, model, t, calm, arms, gaps, near, after, last)
        # end the step where a corner arrives
        if model[LAW] == RIGID and number < ARRIVALS - 1:
            start, drop = (v, -gravity[2]) if count == 0 else (after, 0.0)
            t = _arrival(gaps, arms, start, drop, left)
            if t < left:
                count, good = _push(state, v, model, t, calm, arms, gaps, near, after, last)
        solved = solved and good
        # move
        free = count == 0
        for a in range(3):
            bend[a] = gravity[a] if free else 0.0
        fly(state, v if free else after, bend, t)
        for a in range(6):
            v[a] = after[a]
        left -= t
        if left <= 1e-9 * dt:
            break
    return count, solved


@inline_kernel
def _largest(v: FloatArray, arm: float) -> float:
    most = 0.0
    for a in range(3):
        most = max(most, max(abs(v[a]), arm * abs(v[3 + a])))
    return most


@releasing_kernel
def simulate(
    starts: FloatArray, frames: IntArray, dt: float, steps: int, model: FloatArray, poses: FloatArray
) -> int:
    """Fill the poses of many tosses; return how many contact problems were left unsolved.

    Parameters
    ----------
    starts
        (B, 13) position, quaternion (x, y, z, w), velocity and angular velocity, all in the plane's axes.
    frames
        (B,) frames of each toss, the first one included.
    dt
        Time between frames [s].
    steps
        Steps between frames.
    model
        See `cube_contact`.
    poses
        (sum of frames, 7) position and quaternion of every frame, toss after toss.
    """
    state, v, after, bend = np.empty(7), np.empty(6), np.empty(6), np.zeros(3)
    arms, gaps, near = np.empty((8, 3)), np.empty(8), np.empty(8, dtype=np.int64)
    gravity = model[GRAVITY : GRAVITY + 3]
    last = np.zeros((8, 4))
    h, row, failed = dt / steps, 0, 0
    for b in range(starts.shape[0]):
        last[:, 2] = 0.0  # nothing touched before
        for a in range(7):
            state[a] = poses[row, a] = starts[b, a]
        for a in range(6):
            v[a] = starts[b, 7 + a]
        calm = 0
        for _ in range(1, frames[b]):
            row += 1
            if calm < 2 and _lowest(state, model) + min(0.0, dt * (v[2] + dt * gravity[2])) > 0.0:
                fly(state, v, gravity, dt)  # too high to touch
                for a in range(3):
                    v[a] += dt * gravity[a]
            elif calm < 2:
                for _ in range(steps):
                    count, solved = step(state, v, model, h, bend, arms, gaps, near, after, last)
                    failed += not solved
                    calm = calm + 1 if count >= 3 and _largest(v, model[HALF]) < ASLEEP else 0
                    if calm == 2:
                        break
            for a in range(7):
                poses[row, a] = state[a]
        row += 1
    return failed
