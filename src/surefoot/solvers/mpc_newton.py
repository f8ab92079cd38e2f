"""Compiled Newton method for the forces of a horizon, in the accelerations' multipliers.

The program, for the accelerations a of N steps (six numbers each) and the forces f of all contacts::

    min  1/2 aᵀ P a + qᵀ a + ρ/2 ||f - c||²    subject to    a = M f,  f in the truncated cones

P couples the steps and not the axes (one N x N matrix per axis), M the axes and not the steps. Only the
equation gets multipliers y (6 N numbers, whatever the number of feet). Given y, both minimisations are
closed: a = P⁻¹ (y - q), and f = Π(c - Mᵀ y / ρ) with one projection per contact, hence always inside the
cones. The dual's gradient F(y) = P⁻¹ (y - q) - M f is piecewise smooth and strongly monotone, so that
Newton's method with the projection's Jacobian and a line search converges from anywhere, in the end
quadratically [1]_. The duality gap at f is exactly 1/2 Fᵀ P F, and because the program is strongly convex
in f::

    ||f - f*|| <= sqrt(Fᵀ P F / ρ)

so that every answer carries a bound on its own error, in newtons. A warm start is a guess of the points
c - Mᵀ y / ρ (not of y, which has to be known far better): it tells which contacts stick, slide or lift.

References
----------
.. [1] L. Qi, J. Sun, "A nonsmooth version of Newton's method", Mathematical Programming 58, 1993.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.cones.projection import project_truncated
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.factorisation import factor, solve_factored

REGULA_FALSI = 40
"""Bound on the evaluations of one line search."""
ROUNDING = 1e6
"""A squared error bound that stalls within this factor of its goal is taken for rounding."""
RAISE, LOWER, STAGE = 1e3, 10.0, 8
"""How far the force weight is raised, the factor of each stage down, and the most steps of a stage."""


@inline_kernel
def add_outer(V: FloatArray, at: int, m: FloatArray, x: float, y: float, z: float) -> None:
    """Add v vᵀ to the upper triangle of the 6 x 6 block at `at`, v = x m[0] + y m[1] + z m[2]."""
    for i in range(6):
        v = x * m[0, i] + y * m[1, i] + z * m[2, i]
        row = V[at + i]
        for j in range(i, 6):
            row[at + j] += v * (x * m[0, j] + y * m[1, j] + z * m[2, j])


@kernel
def assemble(
    V: FloatArray, K: FloatArray, step: IntArray, M: FloatArray, bounds: FloatArray, point: FloatArray,
    force: FloatArray, rho: float,
) -> None:  # fmt: skip
    """Fill the upper triangle of V with P⁻¹ + M Π' Mᵀ / ρ, Π' the projections' Jacobian at the points."""
    N = K.shape[1]
    V[:] = 0.0
    for k in range(N):
        for m in range(k, N):
            for j in range(6):
                V[6 * k + j, 6 * m + j] = K[j, k, m]
    root = 1.0 / math.sqrt(rho)
    for i in range(step.size):
        at = 6 * step[i]
        u, v, z = point[i, 0], point[i, 1], force[i, 2]
        mu, low, high = bounds[i, 0], bounds[i, 1], bounds[i, 2]
        t = math.sqrt(u * u + v * v)
        held = z <= low or z >= high
        if t <= mu * z:
            add_outer(V, at, M[i], root, 0.0, 0.0)
            add_outer(V, at, M[i], 0.0, root, 0.0)
            if not held:
                add_outer(V, at, M[i], 0.0, 0.0, root)
        elif z > 0.0:
            a, b = u / t, v / t
            s = root * math.sqrt(mu * z / t)  # how much a sideways move of the point moves the force
            add_outer(V, at, M[i], -b * s, a * s, 0.0)
            if not held:
                s = root / math.sqrt(1.0 + mu * mu)
                add_outer(V, at, M[i], a * mu * s, b * mu * s, s)


@kernel
def begin(
    K: FloatArray, q: FloatArray, step: IntArray, M: FloatArray, bounds: FloatArray, centre: FloatArray,
    rho: float, point: FloatArray, force: FloatArray, V: FloatArray, y: FloatArray,
) -> None:  # fmt: skip
    """Fill y with the multipliers of the program linearised at guessed points; the points become those of y.

    A guess says which contacts stick, slide or are unloaded; if it is right, this is already a Newton step
    from the solution's own pieces. Guesses at the wanted forces, inside the cones, ignore the cones.
    """
    N = K.shape[1]
    for j in range(6):
        for k in range(N):
            total = 0.0
            for m in range(N):
                total += K[j, k, m] * q[6 * m + j]
            y[6 * k + j] = total
    for i in range(step.size):
        mu, low, high = bounds[i, 0], bounds[i, 1], bounds[i, 2]
        x, w, z = project_truncated(point[i, 0], point[i, 1], point[i, 2], mu, low, high)
        force[i, 0], force[i, 1], force[i, 2] = x, w, z
        p, r, s = centre[i, 0] - point[i, 0], centre[i, 1] - point[i, 1], centre[i, 2] - point[i, 2]
        t = math.sqrt(point[i, 0] ** 2 + point[i, 1] ** 2)
        if z <= low or z >= high:
            s = 0.0
        if t <= mu * z:
            x, w, z = x + p, w + r, z + s
        elif z > 0.0:
            a, b = point[i, 0] / t, point[i, 1] / t
            across = mu * z / t * (a * r - b * p)
            along = 0.0 if z <= low or z >= high else (mu * (a * p + b * r) + s) / (1.0 + mu * mu)
            x, w, z = x - b * across + a * mu * along, w + a * across + b * mu * along, z + along
        at = 6 * step[i]
        for j in range(6):
            y[at + j] += M[i, 0, j] * x + M[i, 1, j] * w + M[i, 2, j] * z
    assemble(V, K, step, M, bounds, point, force, rho)
    factor(V)
    solve_factored(V, y)
    place(step, M, centre, y, rho, point)


@inline_kernel
def place(
    step: IntArray, M: FloatArray, centre: FloatArray, y: FloatArray, rho: float, point: FloatArray
) -> None:
    """Fill the points c - Mᵀ y / ρ."""
    for i in range(step.size):
        at = 6 * step[i]
        for a in range(3):
            total = 0.0
            for j in range(6):
                total += M[i, a, j] * y[at + j]
            point[i, a] = centre[i, a] - total / rho


@kernel
def evaluate(
    K: FloatArray, P: FloatArray, q: FloatArray, step: IntArray, M: FloatArray, bounds: FloatArray,
    y: FloatArray, point: FloatArray, force: FloatArray, F: FloatArray,
) -> float:  # fmt: skip
    """Fill the forces at the points and the gradient F = P⁻¹ (y - q) - M f; return Fᵀ P F."""
    N = K.shape[1]
    for j in range(6):
        for k in range(N):
            total = 0.0
            for m in range(N):
                total += K[j, k, m] * (y[6 * m + j] - q[6 * m + j])
            F[6 * k + j] = total
    for i in range(step.size):
        x, w, z = project_truncated(
            point[i, 0], point[i, 1], point[i, 2], bounds[i, 0], bounds[i, 1], bounds[i, 2]
        )
        force[i, 0], force[i, 1], force[i, 2] = x, w, z
        at = 6 * step[i]
        for j in range(6):
            F[at + j] -= M[i, 0, j] * x + M[i, 1, j] * w + M[i, 2, j] * z
    size = 0.0
    for j in range(6):
        for k in range(N):
            total = 0.0
            for m in range(N):
                total += P[j, k, m] * F[6 * m + j]
            size += F[6 * k + j] * total
    return size


@inline_kernel
def slope(bounds: FloatArray, point: FloatArray, move: FloatArray, t: float, rho: float) -> float:
    """Return the forces' part of the dual's derivative, t of the way along a step of the points."""
    total = 0.0
    for i in range(point.shape[0]):
        x, y, z = project_truncated(
            point[i, 0] + t * move[i, 0], point[i, 1] + t * move[i, 1], point[i, 2] + t * move[i, 2],
            bounds[i, 0], bounds[i, 1], bounds[i, 2],
        )  # fmt: skip
        total += x * move[i, 0] + y * move[i, 1] + z * move[i, 2]
    return rho * total


@kernel
def search(
    bounds: FloatArray,
    point: FloatArray,
    move: FloatArray,
    rho: float,
    base: float,
    curve: float,
    start: float,
) -> float:
    """Return the step length where the dual's derivative has fallen to a hundredth of its start."""
    left, right = 0.0, 1.0
    at_left, at_right = start, slope(bounds, point, move, 1.0, rho) + base + curve
    t = 1.0
    side = 0
    if at_right <= -0.5 * start:
        return t
    for k in range(REGULA_FALSI):
        t = (left * at_right - right * at_left) / (at_right - at_left)
        if k % 3 == 2:
            t = 0.5 * (left + right)
        value = slope(bounds, point, move, t, rho) + base + t * curve
        if abs(value) <= -0.01 * start:
            break
        if value < 0.0:
            left, at_left = t, value
            if side == -1:
                at_right *= 0.5
            side = -1
        else:
            right, at_right = t, value
            if side == 1:
                at_left *= 0.5
            side = 1
    return t


@kernel
def descend(
    K: FloatArray, P: FloatArray, q: FloatArray, step: IntArray, M: FloatArray, bounds: FloatArray,
    rho: float, goal: float, limit: int, y: FloatArray, point: FloatArray, force: FloatArray, V: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Take Newton steps until the squared error bound is below `goal`; return their number and that bound.

    y and its points are updated in place. A bound that no longer falls close to the goal is rounding.
    """
    N, contacts = K.shape[1], step.size
    F, d, move = np.empty(q.size), np.empty(q.size), np.empty((contacts, 3))
    error = evaluate(K, P, q, step, M, bounds, y, point, force, F) / rho
    best, idle = error, 0
    for count in range(limit):
        if not error > goal or (idle > 4 and best < ROUNDING * goal):
            return count, error
        assemble(V, K, step, M, bounds, point, force, rho)
        factor(V)
        for i in range(q.size):
            d[i] = -F[i]
        solve_factored(V, d)
        start = base = curve = 0.0  # the dual's derivative along d, and its smooth part's line
        for j in range(6):
            for k in range(N):
                here = ahead = 0.0
                for m in range(N):
                    here += K[j, k, m] * (y[6 * m + j] - q[6 * m + j])
                    ahead += K[j, k, m] * d[6 * m + j]
                base += here * d[6 * k + j]
                curve += ahead * d[6 * k + j]
                start += F[6 * k + j] * d[6 * k + j]
        for i in range(contacts):
            at = 6 * step[i]
            for a in range(3):
                total = 0.0
                for j in range(6):
                    total += M[i, a, j] * d[at + j]
                move[i, a] = -total / rho
        t = search(bounds, point, move, rho, base, curve, start)
        for i in range(q.size):
            y[i] += t * d[i]
        for i in range(contacts):
            for a in range(3):
                point[i, a] += t * move[i, a]
        error = evaluate(K, P, q, step, M, bounds, y, point, force, F) / rho
        idle = 0 if error < 0.5 * best else idle + 1
        best = min(best, error)
    return limit, error


@kernel
def newton(
    K: FloatArray, P: FloatArray, q: FloatArray, step: IntArray, M: FloatArray, bounds: FloatArray,
    centre: FloatArray, rho: float, tol: float, patience: int, limit: int, point: FloatArray,
    force: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Solve the horizon's program; return the Newton steps and the bound on the forces' error [N].

    Newton's method is tried first from the given start. If that takes more than `patience` steps (a tiny
    force weight, or a motion far beyond what friction can do), the force weight is raised and lowered
    again in stages, each starting at the points of the one before, which stay near their solution.

    Parameters
    ----------
    K, P
        (6, N, N) inverse Hessian and Hessian of every axis.
    q
        (6 N,) gradient, step by step.
    step
        (contacts,) the step that each contact belongs to.
    M
        (contacts, 3, 6) columns of the map from a contact's force to the accelerations of its step.
    bounds
        (contacts, 3) friction, least and largest normal force.
    centre
        (contacts, 3) wanted forces.
    rho
        Weight of the forces.
    tol
        Wanted bound on the error [N].
    patience, limit
        Bounds on the steps of the first attempt, and of all.
    point
        (contacts, 3) a guess of the points whose projections are the forces, NaN where there is none;
        those of the answer on return.
    force
        (contacts, 3) result.
    """
    V, y = np.empty((q.size, q.size)), np.empty(q.size)
    for i in range(step.size):
        if math.isnan(point[i, 0] + point[i, 1] + point[i, 2]):
            for a in range(3):
                point[i, a] = centre[i, a]
    begin(K, q, step, M, bounds, centre, rho, point, force, V, y)
    first = min(patience, limit)
    total, error = descend(K, P, q, step, M, bounds, rho, tol * tol, first, y, point, force, V)
    if error <= tol * tol or total < first or total >= limit:
        return total, math.sqrt(error)
    size = 0.0
    for i in range(step.size):
        size = max(size, abs(centre[i, 2]))
        for a in range(3):
            point[i, a] = centre[i, a]
    raised = rho * RAISE
    begin(K, q, step, M, bounds, centre, raised, point, force, V, y)
    while raised > rho and total < limit:
        count, error = descend(
            K,
            P,
            q,
            step,
            M,
            bounds,
            raised,
            size**2,
            min(STAGE, limit - total),
            y,
            point,
            force,
            V,
        )
        total += count
        lowered = max(rho, raised / LOWER)
        for i in range(q.size):
            y[i] *= lowered / raised
        raised = lowered
    for i in range(q.size):  # only if the limit ended the stages early: the points stay, y follows
        y[i] *= rho / raised
    count, error = descend(K, P, q, step, M, bounds, rho, tol * tol, limit - total, y, point, force, V)
    return total + count, math.sqrt(error)
