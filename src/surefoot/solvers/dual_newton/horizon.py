"""The dual Newton method for the forces of a horizon, in the accelerations' multipliers.

The program, for the accelerations a of N steps (six numbers each) and the forces f of all contacts::

    min  1/2 aᵀ P a + qᵀ a + ρ/2 ||f - c||²    subject to    a = M f,  f in the truncated cones

P couples the steps and not the axes (one N x N matrix per axis), M the axes and not the steps. Only the
equation gets multipliers y (6 N numbers, whatever the number of feet): a = P⁻¹ (y - q), f = Π(c - Mᵀ y / ρ),
and the dual's gradient is F(y) = P⁻¹ (y - q) - M f. The duality gap at f is exactly 1/2 Fᵀ P F, and because
the program is strongly convex in f::

    ||f - f*|| <= sqrt(Fᵀ P F / ρ)

so that every answer carries a bound on its own error, in newtons. A warm start is a guess of the points
c - Mᵀ y / ρ (not of y, which has to be known far better): it tells which contacts stick, slide or lift.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.numerics.factorisation import factor, solve_factored
from surefoot.numerics.projection import differential, face, project_truncated
from surefoot.numerics.vectors import Three, advance, dot
from surefoot.solvers.dual_newton.method import Form, Path, Progress, Steps, descend, follow_path

STEPS = Steps(ahead=0.5, nearer=0.0, accuracy=0.01)
IDLE, ROUNDING = 4, 1e6
"""After so many steps that did not halve it, an error bound within this factor of its goal is taken for
rounding."""
RAISE, LOWER, STAGE = 1e3, 0.1, 8.0
"""How far the force weight is raised, the factor of each stage down, and the most steps of a stage."""


# rows of `places`, one (3,) per contact each
POINT, OLD, MOVE, FORCE, CENTRE, BOUNDS = 0, 1, 2, 3, 4, 5
# rows of `vectors`, each (6 N,)
SLOPE, GRADIENT, DIRECTION, DUAL = 0, 1, 2, 3


class Memory(NamedTuple):
    """The program, see `newton`, and where the method is.

    Attributes
    ----------
    K, P, M, step
        As for `newton`.
    places
        (6, contacts, 3): the points, those before a step, how far a full step moves them, the forces, the
        wanted forces, and the bounds.
    vectors
        (4, 6 N): q, F, d and y.
    V
        (6 N, 6 N) Newton's matrix.
    """

    K: FloatArray
    P: FloatArray
    M: FloatArray
    step: IntArray
    places: FloatArray
    vectors: FloatArray
    V: FloatArray


@inline_kernel
def _project(places: FloatArray, i: int, x: float, y: float, z: float) -> Three:
    """Return the admissible force of contact i nearest to a point."""
    return project_truncated(x, y, z, places[BOUNDS, i, 0], places[BOUNDS, i, 1], places[BOUNDS, i, 2])


@inline_kernel
def _pull_back(memory: Memory, y: FloatArray, rho: float, origin: int, out: int) -> None:
    """Set row `out` of the places to -Mᵀ y / ρ, plus row `origin` if that is not negative."""
    M, places = memory.M, memory.places
    for i in range(memory.step.size):
        at = 6 * memory.step[i]
        for a in range(3):
            total = 0.0
            for j in range(6):
                total += M[i, a, j] * y[at + j]
            places[out, i, a] = (places[origin, i, a] if origin >= 0 else 0.0) - total / rho


@inline_kernel
def _over_steps(K: FloatArray, k: int, j: int, y: FloatArray) -> float:
    """Return the entry of step k and axis j of K y."""
    total = 0.0
    for m in range(K.shape[1]):
        total += K[j, k, m] * y[6 * m + j]
    return total


@inline_kernel
def _add_outer(V: FloatArray, at: int, m: FloatArray, x: float, y: float, z: float) -> None:
    """Add v vᵀ to the upper triangle of the 6 x 6 block at `at`, v = x m[0] + y m[1] + z m[2]."""
    for i in range(6):
        v = x * m[0, i] + y * m[1, i] + z * m[2, i]
        row = V[at + i]
        for j in range(i, 6):
            row[at + j] += v * (x * m[0, j] + y * m[1, j] + z * m[2, j])


@kernel
def _assemble(memory: Memory, rho: float) -> None:
    """Fill the upper triangle of V with P⁻¹ + M Π' Mᵀ / ρ, Π' the projections' Jacobian at the points."""
    K, _, M, step, places, _, V = memory
    N = K.shape[1]
    V[:] = 0.0
    for k in range(N):
        # P⁻¹ couples steps of one axis only, and not the axes
        for m in range(k, N):
            for j in range(6):
                V[6 * k + j, 6 * m + j] = K[j, k, m]
    root = 1.0 / math.sqrt(rho)
    for i in range(step.size):
        at, mu = 6 * step[i], places[BOUNDS, i, 0]
        sticks, free, p, q, across, along = face(
            places[POINT, i, 0], places[POINT, i, 1], places[FORCE, i, 2],
            mu, places[BOUNDS, i, 1], places[BOUNDS, i, 2],
        )  # fmt: skip
        # Π' as a sum of v vᵀ, see `numerics.projection.face`
        if sticks:
            for a in range(3 if free else 2):
                _add_outer(V, at, M[i], root * (a == 0), root * (a == 1), root * (a == 2))
        if across > 0.0:
            _add_outer(V, at, M[i], -q * across * root, p * across * root, 0.0)
        if along > 0.0:
            s = along * root
            _add_outer(V, at, M[i], p * mu * s, q * mu * s, s)


@kernel
def _begin(memory: Memory, y: FloatArray, rho: float) -> None:
    """Fill y with the multipliers of the program linearised at guessed points; the points become those of y.

    A guess says which contacts stick, slide or are unloaded; if it is right, this is already a Newton step
    from the solution's own pieces. Guesses at the wanted forces, inside the cones, ignore the cones.
    """
    K, _, M, step, places, vectors, V = memory
    for k in range(K.shape[1]):
        for j in range(6):
            y[6 * k + j] = _over_steps(K, k, j, vectors[SLOPE])
    for i in range(step.size):
        u, v, w = places[POINT, i, 0], places[POINT, i, 1], places[POINT, i, 2]
        x, r, z = _project(places, i, u, v, w)
        places[FORCE, i, 0], places[FORCE, i, 1], places[FORCE, i, 2] = x, r, z
        # Π(p) + Π'(p) (c - p): the projection linearised at the guess p, at multipliers of zero
        dx, dr, dz = differential(
            u, v, z, places[BOUNDS, i, 0], places[BOUNDS, i, 1], places[BOUNDS, i, 2],
            places[CENTRE, i, 0] - u, places[CENTRE, i, 1] - v, places[CENTRE, i, 2] - w,
        )  # fmt: skip
        x, r, z = x + dx, r + dr, z + dz
        at = 6 * step[i]
        for j in range(6):
            y[at + j] += M[i, 0, j] * x + M[i, 1, j] * r + M[i, 2, j] * z
    _assemble(memory, rho)
    factor(V)
    solve_factored(V, y)
    _pull_back(memory, y, rho, CENTRE, POINT)


@kernel
def _evaluate(memory: Memory, y: FloatArray, rho: float) -> float:
    """Fill the forces at the points and F = P⁻¹ (y - q) - M f; return Fᵀ P F / ρ, the squared error bound."""
    K, P, M, step, places, vectors, _ = memory
    q, F = vectors[SLOPE], vectors[GRADIENT]
    N = K.shape[1]
    for j in range(6):
        for k in range(N):
            total = 0.0
            for m in range(N):
                total += K[j, k, m] * (y[6 * m + j] - q[6 * m + j])
            F[6 * k + j] = total
    for i in range(step.size):
        x, r, z = _project(places, i, places[POINT, i, 0], places[POINT, i, 1], places[POINT, i, 2])
        places[FORCE, i, 0], places[FORCE, i, 1], places[FORCE, i, 2] = x, r, z
        at = 6 * step[i]
        for j in range(6):
            F[at + j] -= M[i, 0, j] * x + M[i, 1, j] * r + M[i, 2, j] * z
    size = 0.0  # Fᵀ P F, twice the duality gap
    for k in range(N):
        for j in range(6):
            size += F[6 * k + j] * _over_steps(P, k, j, F)
    return size / rho


@inline_kernel
def _enter(memory: Memory, y: FloatArray, rho: float) -> tuple[FloatArray, float]:
    """Evaluate at the points as they are; see `method.Form`, here and below."""
    return memory.vectors[GRADIENT], _evaluate(memory, y, rho)


@kernel
def _direction(memory: Memory, F: FloatArray, rho: float) -> tuple[FloatArray, float]:
    places, V, d = memory.places, memory.V, memory.vectors[DIRECTION]
    _assemble(memory, rho)
    factor(V)
    for i in range(d.size):
        d[i] = -F[i]
    solve_factored(V, d)
    for i in range(memory.step.size):
        for a in range(3):
            places[OLD, i, a] = places[POINT, i, a]
    _pull_back(memory, d, rho, -1, MOVE)
    return d, dot(F, d)


@kernel
def _take(
    memory: Memory, y: FloatArray, d: FloatArray, rho: float, t: float, before: float
) -> tuple[FloatArray, FloatArray, float, float]:
    places, F = memory.places, memory.vectors[GRADIENT]
    advance(y, t - before, d)
    for i in range(memory.step.size):
        for a in range(3):
            places[POINT, i, a] = places[OLD, i, a] + t * places[MOVE, i, a]
    error = _evaluate(memory, y, rho)
    return y, F, error, dot(F, d)


@kernel
def _line(memory: Memory, y: FloatArray, d: FloatArray) -> tuple[float, float]:
    K, q, ahead, curve = memory.K, memory.vectors[SLOPE], 0.0, 0.0
    for k in range(K.shape[1]):
        for j in range(6):
            turn = d[6 * k + j]
            ahead += turn * (_over_steps(K, k, j, y) - _over_steps(K, k, j, q))
            curve += turn * _over_steps(K, k, j, d)
    return ahead, curve


@inline_kernel
def _derivative(line: tuple[Memory, float, float, float], t: float) -> float:
    memory, rho, ahead, curve = line
    places, total = memory.places, 0.0
    for i in range(memory.step.size):
        p, q, r = places[MOVE, i, 0], places[MOVE, i, 1], places[MOVE, i, 2]
        x, y, z = _project(
            places, i, places[OLD, i, 0] + t * p, places[OLD, i, 1] + t * q, places[OLD, i, 2] + t * r
        )
        total += x * p + y * q + z * r
    return rho * total + ahead + (t - 1.0) * curve


@inline_kernel
def _rounding(memory: Memory, progress: Progress, tol: float) -> bool:
    return progress.idle > IDLE and progress.best < ROUNDING * tol


@inline_kernel
def _predict(memory: Memory, y: FloatArray, rho: float, smaller: float) -> FloatArray:
    """Scale y so that the points, and with them the forces, stay where they are."""
    for i in range(y.size):
        y[i] *= smaller / rho
    return y


FORM = Form(_enter, _direction, _take, _line, _derivative, _rounding, _predict)


@kernel
def _newton(
    memory: Memory, y: FloatArray, F: FloatArray, error: float, rho: float, tol: float, limit: float,
    patience: float,
) -> tuple[FloatArray, FloatArray, float, int]:  # fmt: skip
    return descend(FORM, STEPS, memory, y, F, error, rho, tol, limit, patience)


@kernel
def _solve(memory: Memory, y: FloatArray, path: Path, goal: float) -> tuple[int, float]:
    """Follow a path from the points as they are; return the steps and the error."""
    _begin(memory, y, path.start)
    _, _, error, count = follow_path(FORM, _newton, memory, y, path, goal)
    return count, error


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
    size, contacts = q.size, step.size
    places, vectors = np.empty((6, contacts, 3)), np.empty((4, size))
    memory, y = Memory(K, P, M, step, places, vectors, np.empty((size, size))), vectors[DUAL]
    for i in range(size):
        vectors[SLOPE, i] = q[i]
    for i in range(contacts):
        known = not math.isnan(point[i, 0] + point[i, 1] + point[i, 2])
        for a in range(3):
            places[CENTRE, i, a], places[BOUNDS, i, a] = centre[i, a], bounds[i, a]
            places[POINT, i, a] = point[i, a] if known else centre[i, a]
    first, goal = min(patience, limit), tol * tol
    once = Path(rho, rho, 1.0, goal, 0.0, float(first), float(first))
    total, error = _solve(memory, y, once, goal)
    if error > goal and first <= total < limit:
        left, largest = float(limit - total), 0.0
        for i in range(contacts):
            largest = max(largest, abs(places[CENTRE, i, 2]))
            for a in range(3):
                places[POINT, i, a] = places[CENTRE, i, a]
        stages = Path(rho * RAISE, rho, LOWER, largest**2, STAGE, left, left)
        count, error = _solve(memory, y, stages, goal)
        total += count
    for i in range(contacts):
        for a in range(3):
            point[i, a], force[i, a] = places[POINT, i, a], places[FORCE, i, a]
    return total, math.sqrt(error)
