"""A body thrown onto a plane, free or jointed: many throws in one compiled call.

The body is a tree of links, the first of them free, the others on hinges and slides; what touches are spheres
fixed to its links, whose hull is the shape. In the plane's axes (z its normal) and with the velocity of the
first link's origin, its angular velocity and the joints' rates for coordinates v,

    M(q) v̇ = f(q, v) + Jᵀ λ,      M = Σ m Jcᵀ Jc + Jwᵀ I Jw,      f = Σ m Jcᵀ (g - a) - Jwᵀ (I α + ω × I ω)

with a, α the links' accelerations at v̇ = 0. Free motion is the midpoint rule, impulses are the exact contact
problem of Moreau's step [1]_, and a step ends where a sphere arrives, so that impacts happen on the plane. A
joint's dry friction and damping are taken implicitly, before the ground's impulses, springs across a hinge in
M itself. It is the same physics as `Stepper`'s, without what the ground of a throw does not need: other
bodies, terrain, order two at rest.

References
----------
.. [1] M. Jean, "The non-smooth contact dynamics method", CMAME 177, 1999.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import borrowed, inline_kernel, keep, releasing_kernel
from surefoot.base.numerics.vectors import advance
from surefoot.records.identification.thrown_body_impact import CLOSED, exchange
from surefoot.records.identification.thrown_body_tree import (
    FallingBody,
    Placed,
    borrow_body,
    borrow_work,
    climb,
    dynamics,
    link_velocities,
    place,
    place_spheres,
    point_rows,
    solve_mass,
    work_arrays,
)

ARRIVALS = 12
"""Arrivals of spheres within a step; what arrives later waits for the next one."""
ASLEEP = 1e-7
"""Speed [m/s, rad/s] under which a body that its contacts hold for two steps stays for good."""


@inline_kernel
def _free(body: FallingBody, at: Placed, v: FloatArray, t: float, out: FloatArray) -> None:
    """Fill the velocity after a time t [s] under all forces but the ground's, joints' losses implicit."""
    out[:] = at.f
    solve_mass(at.M, out)
    for r in range(v.size):
        out[r] = v[r] + t * out[r]
    for i in range(1, body.masses.size):
        if body.stiffness[i] == 0.0 and (body.friction[i] > 0.0 or body.damping[i] > 0.0):
            # M⁻¹ e_i: what a unit impulse on joint i does to all velocities. Dry friction is the impulse that
            # would stop the joint, at most t times its torque; damping is that of backward Euler, r = r₀ / (1
            # + t d M⁻¹_ii), on what is left. Both are stable for any t; a joint's effect on another one's
            # losses is taken in their order.
            give = np.zeros(v.size)
            give[5 + i] = 1.0
            solve_mass(at.M, give)
            most, rate, ease = t * body.friction[i], out[5 + i], give[5 + i]
            impulse = -min(most, max(-most, rate / ease))
            impulse -= t * body.damping[i] * (rate + ease * impulse) / (1.0 + t * body.damping[i] * ease)
            advance(out, impulse, give)


@inline_kernel
def move(q: FloatArray, v: FloatArray, t: float) -> None:
    """Move q (7 + joints,) for a time t [s] at velocity v (nv,), with the turn exp(ω t)."""
    for a in range(3):
        q[a] += t * v[a]
    for a in range(7, q.size):
        q[a] += t * v[a - 1]
    rate = math.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
    half = 0.5 * rate * t
    # Quaternion exponential of ω t, multiplied from the left since ω is in the plane's axes; sin(x) / x is
    # one to rounding below 1e-8. It keeps the length of the quaternion, so that nothing is normalised.
    share = 0.5 * t if half < 1e-8 else math.sin(half) / rate
    a, b, c, d = share * v[3], share * v[4], share * v[5], math.cos(half)
    x, y, z, w = q[3], q[4], q[5], q[6]
    q[3] = d * x + a * w + b * z - c * y
    q[4] = d * y + b * w + c * x - a * z
    q[5] = d * z + c * w + a * y - b * x
    q[6] = d * w - a * x - b * y - c * z


@inline_kernel
def _arrival(body: FallingBody, at: Placed, v: FloatArray, drop: float, t: float) -> float:
    """Return when the first open sphere reaches the plane, t if none does before.

    Its path is taken as a parabola with the acceleration -drop; rotation bends it by less than `CLOSED` in a
    millisecond.
    """
    first = t
    link_velocities(body, at, v)
    for k in range(at.gaps.size):
        gap = at.gaps[k]
        if gap > CLOSED:
            # First root of gap + u t - drop t² / 2 = 0 as 2 gap / (-u + sqrt(u² + 2 drop gap)): nothing
            # cancels, and a drop of zero needs no case of its own.
            speed = climb(body, at, k)
            root = speed * speed + 2.0 * drop * gap
            if root >= 0.0:
                divisor = -speed + math.sqrt(root)
                if divisor > 0.0 and 2.0 * gap < divisor * first:
                    first = 2.0 * gap / divisor
    return first


@inline_kernel
def _fly(
    body: FallingBody, at: Placed, gravity: FloatArray, q: FloatArray, v: FloatArray, t: float,
    step: float, middle: FloatArray, after: FloatArray,
) -> None:  # fmt: skip
    """Move q and v by a time t of a step without contacts, by the midpoint rule."""
    _free(body, at, v, 0.5 * t, after)
    middle[:] = q
    move(middle, v, 0.5 * t)
    place(body, middle, at)
    dynamics(body, at, middle, after, gravity, step)
    move(q, after, t)
    _free(body, at, v, t, after)
    v[:] = after


@inline_kernel
def step(
    body: FallingBody, law: FloatArray, gravity: FloatArray, q: FloatArray, v: FloatArray, dt: float,
    at: Placed, middle: FloatArray, after: FloatArray, near: IntArray,
) -> tuple[int, bool]:  # fmt: skip
    """Move q and v by dt; return the contacts at the end, and whether all contact problems were solved.

    Memory: `middle` (nq,), `after` (nv,) and `near` (k,).
    """
    left, count, solved, calm = dt, 0, True, 2.0 * dt * abs(gravity[2])
    for number in range(ARRIVALS):
        place(body, q, at)
        place_spheres(body, at)
        dynamics(body, at, q, v, gravity, dt)
        count = 0
        for k in range(at.gaps.size):
            # Open spheres take no part: the piece ends where the first of them arrives.
            if at.gaps[k] <= CLOSED:
                near[count] = k
                count += 1
        t = left
        if count == 0:
            if number < ARRIVALS - 1:
                t = _arrival(body, at, v, -gravity[2], left)
            _fly(body, at, gravity, q, v, t, dt, middle, after)
        else:
            J = np.empty((3 * count, v.size))
            for i in range(count):
                point_rows(body, at, body.links[near[i]], at.x[near[i]], J[3 * i : 3 * i + 3])
            _free(body, at, v, left, after)
            good = exchange(law, J, at.M, at.gaps, near[:count], left, calm, v, after)
            if number < ARRIVALS - 1:
                # The velocity after the impulses holds over the whole piece (semi-implicit Euler): what
                # arrives does so on a straight line, and ends the piece.
                t = _arrival(body, at, after, 0.0, left)
                if t < left:
                    _free(body, at, v, t, after)
                    good = exchange(law, J, at.M, at.gaps, near[:count], t, calm, v, after)
            solved = solved and good
            move(q, after, t)
            v[:] = after
        # Pieces that rounding leaves over have no length worth a contact problem.
        left -= t
        if left <= 1e-9 * dt:
            break
    return count, solved


@releasing_kernel
def throw(
    body: FallingBody, law: FloatArray, gravity: FloatArray, starts: FloatArray, frames: IntArray,
    dt: float, steps: int, poses: FloatArray,
) -> int:  # fmt: skip
    """Fill the poses of many throws; return how many contact problems were left unsolved.

    Parameters
    ----------
    body
        What is thrown.
    law
        See `thrown_body_impact`.
    gravity
        (3,) [m/s²].
    starts
        (B, nq + nv) place, quaternion (x, y, z, w) and joints, then velocity of the first link's origin,
        its angular velocity and the joints' rates, all in the plane's axes.
    frames
        (B,) frames of each throw, the first one included.
    dt, steps
        Time between frames [s], and steps between them.
    poses
        (sum of frames, nq) of every frame, throw after throw.
    """
    nq = 6 + body.masses.size
    nv, k, work = nq - 1, body.radii.size, work_arrays(body)
    near, places, speeds = np.empty(k, dtype=np.int64), np.empty((2, nq)), np.empty((2, nv))
    own, at, close, law, gravity = (
        borrow_body(body), borrow_work(work), borrowed(near), borrowed(law), borrowed(gravity),
    )  # fmt: skip
    q, middle, v, after = borrowed(places)[0], borrowed(places)[1], borrowed(speeds)[0], borrowed(speeds)[1]
    row, failed = 0, 0
    for b in range(starts.shape[0]):
        q[:], v[:] = starts[b, :nq], starts[b, nq:]
        poses[row] = q
        calm = 0
        for _ in range(1, frames[b]):
            row += 1
            if calm < 2:
                for _ in range(steps):
                    # Three contacts hold a body: one that is at rest on them for two steps stays, and the
                    # rest of its frames cost nothing.
                    count, solved = step(own, law, gravity, q, v, dt / steps, at, middle, after, close)
                    failed += not solved
                    calm = calm + 1 if count >= 3 and np.abs(v).max() < ASLEEP else 0
                    if calm == 2:
                        break
            poses[row] = q
        row += 1
    keep(work), keep(near), keep(places), keep(speeds)
    return failed
