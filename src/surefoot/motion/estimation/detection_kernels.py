"""The arithmetic of contact detection: one step of the momentum observer, and the feet's forces it means."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import borrowed, inline_kernel, kernel, window
from surefoot.base.numerics.cholesky import cholesky, solve_lower, solve_upper
from surefoot.base.numerics.points import point_velocity
from surefoot.base.numerics.rotations import rotation_of
from surefoot.base.numerics.vectors import times
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.foot_kinematics import place_feet

DAMPING = 1e-3
"""Share of a leg's levers at which forces are damped: a straight knee shows no force along the leg."""
LEAST_HEIGHT, LEAST_SPEED, MOST_FORCE = -3.0, -4.0, 5.0
"""Bounds of what height, speed and force may say: ground may be elsewhere, readings go wrong."""


@kernel
def sense_feet(
    twists: FloatArray, drifts: FloatArray, turns: FloatArray, places: FloatArray, momenta: FloatArray,
    masses: FloatArray, tables: IntArray, support: BoolArray, flags: BoolArray, feet: FloatArray,
    memory: FloatArray, q: FloatArray, v: FloatArray, up: FloatArray,
) -> None:  # fmt: skip
    """Move the observer and the feet's forces, velocities and points on, and find which feet are pushed.

    Parameters
    ----------
    twists, drifts
        (6, nv) what each velocity moves, and its rate, base axes.
    turns, places, momenta, masses
        Of the joints, (joints, ...): rotations, places [m], momentum of all that a joint carries, about it,
        and the centre of that mass, both in its own axes.
    tables, support, feet
        See `FootKinematics`.
    flags
        (2, n) which feet have a sole, and which are pushed; the latter are filled.
    memory
        See `detector_arrays`; changed.
    q, v, up
        Configuration (nq,), velocity (nv,) and (n, 3) normals of the ground [-].
    """
    n, nv = support.shape
    numbers, radii, rows, forces, velocities, points, local = detector_arrays(memory, n, nv)
    # All in base axes with the base at the origin, where the joints' columns do not depend on its place and
    # attitude; gravity's direction comes in as the vertical seen from there, the last row of R.
    place_feet(twists, turns, places, tables, support, v[6:], feet)
    R = np.empty((3, 3))
    rotation_of(q, R)
    _observe(
        twists, drifts, turns, places, momenta, masses, tables, feet[36 * n + 1 :], v, R[2], numbers, rows
    )
    for k in range(n):
        a, b, c = up[k, 0], up[k, 1], up[k, 2]
        for r in range(3):
            local[k, r] = feet[3 * k + r] - radii[k] * (R[0, r] * a + R[1, r] * b + R[2, r] * c)
    foot_forces(twists, support, local, borrowed(flags)[0], rows[3], v, DAMPING, forces, velocities)
    pushed = borrowed(flags)[1]
    for k in range(n):
        a, b, c = times(R, (local[k, 0], local[k, 1], local[k, 2]))
        points[k, 0], points[k, 1], points[k, 2] = q[0] + a, q[1] + b, q[2] + c
        a, b, c = times(R, (velocities[k, 0], velocities[k, 1], velocities[k, 2]))
        velocities[k, 0], velocities[k, 1], velocities[k, 2] = a, b, c
        a, b, c = times(R, (forces[k, 0], forces[k, 1], forces[k, 2]))
        forces[k, 0], forces[k, 1], forces[k, 2] = a, b, c
        pushed[k] = a * up[k, 0] + b * up[k, 1] + c * up[k, 2] > numbers[3]


@inline_kernel
def detector_arrays(memory: FloatArray, n: int, nv: int) -> tuple[FloatArray, ...]:
    """Return the parts of a `FootForceObserver`'s memory, for n feet and nv velocities.

    They are numbers (exp(-K dt), dt [s], whether there was a step before, and the force that counts as a push
    [N]), the feet's radii (n,) [m], (4, nv) rotors' inertias, momentum, rate and residual, forces, velocities
    and points (n, 3) in world axes, and (n, 3) scratch.
    """
    at = 4 + n + 4 * nv
    return (
        window(memory, 0, 1, 4)[0], window(memory, 4, 1, n)[0], window(memory, 4 + n, 4, nv),
        window(memory, at, n, 3), window(memory, at + 3 * n, n, 3), window(memory, at + 6 * n, n, 3),
        window(memory, at + 9 * n, n, 3),
    )  # fmt: skip


@inline_kernel
def _observe(
    twists: FloatArray, drifts: FloatArray, turns: FloatArray, places: FloatArray, momenta: FloatArray,
    masses: FloatArray, tables: IntArray, loads: FloatArray, v: FloatArray, plumb: FloatArray,
    numbers: FloatArray, rows: FloatArray,
) -> None:  # fmt: skip
    """Move the joints' rows of the observer on by dt [s]: residual follows Jᵀ f, what `rate` leaves of ṗ.

    With h the momentum of all that a joint carries, its row of p = M v is Sᵀ h and its rotor's, that of
    C(q, v)ᵀ v is Ṡᵀ h. Over one step ṗ - rate = Jᵀ f is constant, so that r' = K (Jᵀ f - r) is solved exactly
    with exp(-K dt). Momentum and rate (without torques) become those of now. `loads` (joints,) are the masses
    that joints carry [kg], `plumb` (3,) is the vertical.
    """
    keep, dt, known = numbers[0], numbers[1], numbers[2]
    rotors, momentum, rate, residual = rows[0], rows[1], rows[2], rows[3]
    for j in range(6, twists.shape[1]):
        i = tables[j]
        R, h = turns[i], momenta[i]
        # Momentum of the subtree in base axes, its moment carried from the joint to the base's origin, where
        # the twists are taken.
        a, b, c = times(R, (h[0], h[1], h[2]))
        d, e, f = times(R, (h[3], h[4], h[5]))
        x, y, z = places[i, 0], places[i, 1], places[i, 2]
        d, e, f = d + y * c - z * b, e + z * a - x * c, f + x * b - y * a  # about the base's origin
        k, m, n = times(R, (masses[i, 0], masses[i, 1], masses[i, 2]))
        rise = point_velocity(twists, j, x + k, y + m, z + n)
        # Power of the weight per unit of the joint's speed: how fast the carried mass' centre rises with it.
        weight = loads[i] * GRAVITY * (rise[0] * plumb[0] + rise[1] * plumb[1] + rise[2] * plumb[2])
        p = rotors[j] * v[j] + twists[0, j] * a + twists[1, j] * b + twists[2, j] * c
        p += twists[3, j] * d + twists[4, j] * e + twists[5, j] * f
        r = drifts[0, j] * a + drifts[1, j] * b + drifts[2, j] * c
        r += drifts[3, j] * d + drifts[4, j] * e + drifts[5, j] * f
        # The first call has no momentum before it to compare with.
        if known > 0.0:
            seen = (p - momentum[j]) / dt - rate[j]
            residual[j] = keep * residual[j] + (1.0 - keep) * seen
        momentum[j], rate[j] = p, r - weight
    numbers[2] = 1.0


@kernel
def foot_forces(
    twists: FloatArray, support: BoolArray, points: FloatArray, flat: BoolArray, residual: FloatArray,
    v: FloatArray, damping: float, forces: FloatArray, velocities: FloatArray,
) -> None:  # fmt: skip
    """Fill forces (n, 3) [N] that the legs' rows of a residual (nv,) mean, and velocities (n, 3) [m/s].

    Forces of (n, 6) get the moments of flat feet about their points as well [N m], none for points.

    The least squares f of Jᵀ f = residual in a leg's joints, where levers are short damped by `damping` times
    the root of their sum of squares; a flat foot takes a moment as well. `twists` (6, nv), `support` (n, nv),
    points (n, 3) and answers in world axes.
    """
    nv = twists.shape[1]
    A, S, f = np.empty((6, nv)), np.empty((6, 6)), np.empty(6)
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        rows = 6 if flat[k] else 3
        velocities[k, 0] = velocities[k, 1] = velocities[k, 2] = 0.0
        count = 0
        f[:] = 0.0
        for j in range(nv):
            if not support[k, j]:
                continue
            column = point_velocity(twists, j, x, y, z)
            for r in range(3):
                velocities[k, r] += column[r] * v[j]
            if j >= 6:
                for r in range(rows):
                    A[r, count] = column[r] if r < 3 else twists[r, j]
                    f[r] += A[r, count] * residual[j]
                count += 1
        # Normal equations (J Jᵀ + damping² tr(J Jᵀ)) f = J r, with the joints' columns alone: the base's rows
        # of the residual are everybody's, a leg's joints see its own foot.
        trace = 0.0
        for r in range(rows):
            for s in range(rows):
                total = 0.0
                for j in range(count):
                    total += A[r, j] * A[s, j]
                S[r, s] = total
            trace += S[r, r]
        for r in range(rows):
            S[r, r] += damping * damping * trace
        solved = cholesky(S[:rows, :rows])
        if solved:
            solve_lower(S[:rows, :rows], f[:rows])
            solve_upper(S[:rows, :rows], f[:rows])
        for r in range(forces.shape[1]):
            forces[k, r] = f[r] if solved else 0.0


@inline_kernel
def _ratio(x: float, narrow: float, wide: float) -> float:
    """Return log of a normal density of deviation `narrow` at x over that of `wide`."""
    return math.log(wide / narrow) - 0.5 * x * x * (1.0 / (narrow * narrow) - 1.0 / (wide * wide))


@kernel
def decide_contacts(
    forces: FloatArray, velocities: FloatArray, points: FloatArray, up: FloatArray, heights: FloatArray,
    estimated: BoolArray, measured: BoolArray, scales: FloatArray, memory: FloatArray, contact: BoolArray,
) -> None:  # fmt: skip
    """Fill the odds of contact, natural logarithms, and move contact (n,) on.

    Parameters
    ----------
    forces, velocities, points, up
        (n, 3) each: [N], [m/s], [m], normals [-].
    heights
        (n,) of the ground under the points [m].
    estimated, measured
        (n,) which feet bear a force by `forces`, and which by what measures that: where they differ, the
        force is none or the usual one.
    scales
        (7,) the largest usual force [N], deviation of gaps and clearance [m], deviations of speeds of feet
        that stand and swing [m/s], hysteresis, usual force [N].
    memory
        (3, n): odds, which are filled, odds by the plan, deviations of the forces [N].
    """
    heavy, gap, clearance, still, swinging, hold, usual = scales
    odds, prior, deviations = memory
    root = math.sqrt(2.0 * math.pi)
    for k in range(contact.shape[0]):
        f = v = 0.0
        for r in range(3):
            f += forces[k, r] * up[k, r]
            v += velocities[k, r] * up[k, r]
        if estimated[k] != measured[k]:
            f = usual if measured[k] else 0.0
        s, high = deviations[k], (points[k, 2] - heights[k]) * up[k, 2]
        # a uniform density over [0, heavy] against a normal one about 0; a pull says no more than no force
        # Log of the odds, contact over air, of three measurements taken for independent; `prior` is that of
        # the plan.
        pushed = math.log(root * s / heavy) + 0.5 * max(f, 0.0) ** 2 / (s * s)
        # A normal density about the ground against a uniform one over the clearance; speeds: two normal ones.
        near = math.log(clearance / (root * gap)) - 0.5 * (high / gap) ** 2
        stopped = _ratio(v, still, swinging)
        odds[k] = prior[k] + min(pushed, MOST_FORCE) + max(near, LEAST_HEIGHT) + max(stopped, LEAST_SPEED)
        # Hysteresis: odds about one would make contact chatter.
        contact[k] = odds[k] > (-hold if contact[k] else hold)


@kernel
def add_torques(rate: FloatArray, torques: FloatArray) -> bool:
    """Add (joints,) torques [N m] to the last numbers of rate, unless one is not finite; tell if all are."""
    joints, total = torques.shape[0], 0.0
    for j in range(joints):
        total += 0.0 * torques[j]
    if total != 0.0:  # NaN and infinity times zero are NaN
        return False
    for j in range(joints):
        rate[rate.shape[0] - joints + j] += torques[j]
    return True
