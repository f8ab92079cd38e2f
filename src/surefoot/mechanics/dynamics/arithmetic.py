"""The arithmetic of one rigid time step, compiled: factorise, assemble the contact problem, apply impulses.

Free of any robot library: it takes the mass matrix and the spatial Jacobian as arrays.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_lower, solve_upper
from surefoot.base.numerics.vectors import advance, dot

FASTEST = 1e12
"""Velocities beyond this count as lost [m/s, rad/s]."""


@kernel
def factorise(upper: FloatArray, L: FloatArray) -> None:
    """Write the lower Cholesky factor of a matrix (n, n), any unit, given by its upper triangle, into L."""
    # Pinocchio's `crba` leaves the lower triangle unset: only the upper one is M.
    for i in range(L.shape[0]):
        for j in range(i + 1):
            L[i, j] = upper[j, i]
    cholesky(L)


@kernel
def free_velocity(L: FloatArray, effort: FloatArray, v: FloatArray, dt: float) -> FloatArray:
    """Return v + dt M⁻¹ effort, for (nv,) forces of motors, push and gravity [N, N m]."""
    out = effort.copy()
    solve_lower(L, out)
    solve_upper(L, out)
    for i in range(out.size):
        out[i] = v[i] + dt * out[i]
    return out


@kernel
def near_ground(
    J: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, dt: float, reach: float
) -> IntArray:
    """Return the contacts that may touch within the step: closer than `reach` [m] after moving freely.

    J is (3p, nv), v and the free velocity are (nv,), the gaps (p,) [m]. The lesser of the gaps before and
    after counts: gap + dt min(u_n before, u_n free) < reach.
    """
    out = np.empty(gaps.size, dtype=np.int64)
    count = 0
    for c in range(gaps.size):
        before, after = dot(J[3 * c + 2], v), dot(J[3 * c + 2], free)
        # Of forces that come only in the problem itself (other contacts' impulses) nothing is known here:
        # those whom they press in join later, see `with_missed`.
        if gaps[c] + dt * min(before, after) < reach:
            out[count] = c
            count += 1
    return out[:count]


@inline_kernel
def contact_speeds(J: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Fill the contact velocities (p, 3) [m/s] with J v, for J (3p, nv) and v (nv,)."""
    for r in range(J.shape[0]):
        out[r // 3, r % 3] = dot(J[r], v)


@kernel
def turned(
    arriving: FloatArray, leaving: FloatArray, impulses: FloatArray, foot: IntArray, frames: FloatArray,
    least: float,
) -> tuple[FloatArray, FloatArray] | None:  # fmt: skip
    """Return what `swerves` does, for contact velocities (p, 3) before impulses."""
    # Over a step of free motion the velocity of a contact that holds changes by its centripetal and Coriolis
    # terms. Half of it is what the mean velocity is off by from the one right after the impulses.
    out, largest = np.zeros(leaving.shape), 0.0
    groups = 1 + foot.max() if foot.size else 0
    means, count = np.zeros((groups, 3)), np.zeros(groups)
    for d in range(leaving.shape[0]):
        # a contact that was not pressed had nothing to swerve from
        if impulses[d, 2] > 0.0:
            count[foot[d]] += 1.0
            for a in range(3):
                change = 0.5 * (arriving[d, a] - leaving[d, a])
                for i in range(3):
                    means[foot[d], i] += frames[d, i, a] * change
    # all corners of a sole that is pressed somewhere: else they leave its plane by the guess, and forces
    # change from one diagonal to the other in every step
    for c in range(leaving.shape[0]):
        if count[foot[c]] > 0.0:
            for a in range(3):
                for i in range(3):
                    out[c, a] += frames[c, i, a] * means[foot[c], i] / count[foot[c]]
                largest = max(largest, abs(out[c, a]))
    return (arriving, out) if largest > least else None


@kernel
def swerves(
    J: FloatArray, v: FloatArray, leaving: FloatArray, impulses: FloatArray, foot: IntArray,
    frames: FloatArray, least: float,
) -> tuple[FloatArray, FloatArray] | None:  # fmt: skip
    """Return the contact velocities (p, 3) before impulses, and half of what each changed by since the last.

    `leaving` and `impulses` (p, 3) are the velocities right after the last impulses and those impulses;
    feet without swerve nothing. Contacts of one foot (p,) share the mean of those that were pressed, in world
    axes: single ones would pull corners of a rigid sole apart. `frames` (p, 3, 3) are the contact frames.
    None below `least` [m/s].
    """
    arriving = np.empty(leaving.shape)
    contact_speeds(J, v, arriving)
    return turned(arriving, leaving, impulses, foot, frames, least)


@kernel
def mean_work(impulses: FloatArray, arriving: FloatArray, leaving: FloatArray) -> tuple[float, float]:
    """Return the work [J] of impulses (p, 3) [N s] on the mean velocity, and the sum of the normal ones."""
    work = push = 0.0
    for c in range(impulses.shape[0]):
        push += impulses[c, 2]
        for a in range(3):
            work += 0.5 * impulses[c, a] * (arriving[c, a] + leaving[c, a])
    return work, push


@kernel
def with_missed(velocities: FloatArray, gaps: FloatArray, dt: float, near: IntArray) -> IntArray:
    """Return the near contacts and those that the impulses of the others would now push into the ground.

    Velocities are (p, 3) [m/s] in contact axes, gaps (p,) [m].
    """
    # A nanometre is left alone: impulses are exact to the solver's tolerance only, and a set of contacts that
    # grows by rounding would be solved again for nothing.
    taken = np.zeros(gaps.size, dtype=np.bool_)
    for c in near:
        taken[c] = True
    for c in range(gaps.size):
        if gaps[c] + dt * velocities[c, 2] < -1e-9:
            taken[c] = True
    return np.flatnonzero(taken)


@inline_kernel
def bounces(
    gap: float, before: float, free: float, dt: float, e: float, rest_speed: float, pull: float
) -> bool:
    """Return whether a contact obeys Newton's restitution in this step, with a coefficient e [-].

    It does where it arrives faster than `rest_speed`, would close without impulses (`before` and `free` are
    its normal velocities), and would leave more slowly by its gap alone; see `normal_shift`.
    """
    # u + shift >= 0 bounds u_n from below by -shift: an open contact (shift > 0) may still come down by its
    # gap, a closed one that bounces (e u⁻ < 0) has to leave. The lesser shift asks for the faster departure.
    if not (e > 0.0 and before < -rest_speed and gap + dt * free <= 0.0):
        return False
    return e * before < (1.0 if gap > 0.0 else pull) * gap / dt


@inline_kernel
def normal_shift(
    gap: float, before: float, free: float, dt: float, e: float, rest_speed: float, pull: float
) -> float:
    """Return the shift [m/s] in the law u_n + shift >= 0 of a contact's normal.

    - gap / dt where the gap is open: the contact may close within the step, and stops there;
    - e u⁻ where it `bounces`: Newton's restitution;
    - pull gap / dt in penetration: Baumgarte's (0 to leave the position alone).
    """
    if bounces(gap, before, free, dt, e, rest_speed, pull):
        return e * before
    return (1.0 if gap > 0.0 else pull) * gap / dt


@kernel
def normal_shifts(
    gaps: FloatArray, before: FloatArray, free: FloatArray, dt: float, restitution: FloatArray,
    rest_speed: float, pull: float,
) -> tuple[FloatArray, BoolArray]:  # fmt: skip
    """Return `normal_shift` and `bounces` of contacts (k,), for callers whose rows are not dense."""
    shifts, bouncing = np.empty(gaps.size), np.empty(gaps.size, dtype=np.bool_)
    for i in range(gaps.size):
        e = restitution[i]
        bouncing[i] = bounces(gaps[i], before[i], free[i], dt, e, rest_speed, pull)
        shifts[i] = normal_shift(gaps[i], before[i], free[i], dt, e, rest_speed, pull)
    return shifts, bouncing


@kernel
def assemble(
    J: FloatArray, L: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, near: IntArray,
    dt: float, restitution: FloatArray, rest_speed: float, pull: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return Y = L⁻¹ Jᵀ as rows (3k, nv), G = Y Yᵀ [1/kg] and g [m/s] of the near contacts.

    Gaps and coefficients of restitution are (p,), of all contacts. g is J v_free and, along the normal,
    `normal_shift`.
    """
    k, n = near.size, v.size
    Y, g = np.empty((3 * k, n)), np.empty(3 * k)
    for i in range(k):
        c = near[i]
        before = dot(J[3 * c + 2], v)  # what restitution asks after
        for a in range(3):
            row = 3 * c + a
            for j in range(n):
                Y[3 * i + a, j] = J[row, j]
            g[3 * i + a] = dot(J[row], free)
            # G = J M⁻¹ Jᵀ = Y Yᵀ with Y = J L⁻ᵀ, M = L Lᵀ: half the work of M⁻¹, and symmetric
            solve_lower(L, Y[3 * i + a])
        g[3 * i + 2] += normal_shift(gaps[c], before, g[3 * i + 2], dt, restitution[c], rest_speed, pull)
    # Both triangles from one product: half the work, and symmetric to the last bit.
    G = np.empty((3 * k, 3 * k))
    for i in range(3 * k):
        for j in range(i + 1):
            G[i, j] = G[j, i] = dot(Y[i], Y[j])
    return Y, G, g


@kernel
def apply_impulses(L: FloatArray, Y: FloatArray, impulses: FloatArray, free: FloatArray) -> FloatArray:
    """Return v⁺ = free + L⁻ᵀ Yᵀ λ, (nv,), for L (nv, nv), Y = J L⁻ᵀ (m, nv) and impulses λ (m,) [N s]."""
    out = np.zeros(free.size)
    for i in range(impulses.size):
        if impulses[i] != 0.0:
            advance(out, impulses[i], Y[i])
    solve_upper(L, out)
    advance(out, 1.0, free)
    return out
