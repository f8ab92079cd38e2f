"""The dual Newton method for the forces of a horizon, in time proportional to its length.

The program, for the accelerations a of N steps (six numbers each) and the forces f of all contacts::

    min  1/2 aᵀ P a + qᵀ a + ρ/2 ||f - c||²    subject to    a = M f,  f in the truncated cones

P, the cost of the motion, couples the steps and not the axes, M the axes and not the steps. Only the equation
gets multipliers y (6 N numbers, whatever the number of feet): y = P a + q, f = Π(c - Mᵀ y / ρ), and the
dual's gradient is F = a - M f. The duality gap at f is exactly 1/2 Fᵀ P F, and because the program is
strongly convex in f::

    ||f - f*|| <= sqrt(Fᵀ P F / ρ)

so that every answer carries a bound on its own error, in newtons. A warm start is a guess of the points
c - Mᵀ y / ρ (not of y, which has to be known far better): it tells which contacts stick, slide or lift.

Newton's step (P⁻¹ + G) d = -F, with the blocks G = M Π' Mᵀ / ρ of single steps, is z + G P z = -F, d = P z:
Riccati's recursion, see `riccati`. The points and a are carried along, so that P⁻¹ is never applied.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.projection import differential, face, project_truncated
from surefoot.base.numerics.vectors import Three, advance, dot
from surefoot.contact.solvers.dual_newton import riccati
from surefoot.contact.solvers.dual_newton.method import Form, Path, Progress, Steps, descend, follow_path

STEPS = Steps(ahead=0.5, nearer=0.0, accuracy=0.01)
HASTY = 2
"""Full steps from nothing known that may go too far: then no face is known that would be worth keeping."""
IDLE, ROUNDING = 4, 1e6
"""After so many steps that did not halve it, an error bound within this factor of its goal is taken for
rounding."""
RAISE, LOWER, STAGE, LOOSE = 1e2, 0.1, 8.0, 10.0
"""How far the force weight is raised at least, the factor of each stage down, the most steps of a stage, and
the error bound of one that is enough, squared, over the square of the largest wanted force."""


# rows of `places`, one (3,) per contact each
POINT, OLD, MOVE, FORCE, CENTRE, BOUNDS = 0, 1, 2, 3, 4, 5
# rows of `vectors`, each (6 N,), and of `motions`, each (N, 6): one memory
GRADIENT, DIRECTION, MOTION, CHANGE, SLOPE, NOTHING = 0, 1, 2, 3, 4, 5


class HorizonMemory(NamedTuple):
    """The program, see `newton`, and where the method is.

    Attributes
    ----------
    tracking
        P, as the integrators that it is the cost of.
    M, step
        As for `newton`.
    places
        (6, contacts, 3): the points, those before a step, how far a full step moves them, the forces, the
        wanted forces, and the bounds.
    vectors, motions
        (6, 6 N) and (6, N, 6): F, d, a, z (what a full step adds to a), q, and zeros.
    blocks
        (N, 6, 6) lower triangles of G.
    """

    tracking: riccati.Tracking
    M: FloatArray
    step: IntArray
    places: FloatArray
    vectors: FloatArray
    motions: FloatArray
    blocks: FloatArray


@inline_kernel
def _project(places: FloatArray, i: int, x: float, y: float, z: float) -> Three:
    """Return the admissible force of contact i nearest to a point."""
    return project_truncated(x, y, z, places[BOUNDS, i, 0], places[BOUNDS, i, 1], places[BOUNDS, i, 2])


@inline_kernel
def _pull_back(memory: HorizonMemory, y: FloatArray, rho: float, origin: int, out: int) -> None:
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
def _push(memory: HorizonMemory, x: FloatArray, i: int, f: Three, sign: float) -> None:
    """Add the accelerations of a force on contact i, times a sign, to x (6 N,)."""
    M, at = memory.M, 6 * memory.step[i]
    for j in range(6):
        x[at + j] += sign * (M[i, 0, j] * f[0] + M[i, 1, j] * f[1] + M[i, 2, j] * f[2])


@inline_kernel
def _add_outer(G: FloatArray, m: FloatArray, x: float, y: float, z: float) -> None:
    """Add v vᵀ to the lower triangle of G (6, 6), v = x m[0] + y m[1] + z m[2]."""
    for i in range(6):
        v = x * m[0, i] + y * m[1, i] + z * m[2, i]
        for j in range(i + 1):
            G[i, j] += v * (x * m[0, j] + y * m[1, j] + z * m[2, j])


@kernel
def _assemble(memory: HorizonMemory, rho: float) -> None:
    """Fill the blocks M Π' Mᵀ / ρ, Π' the projections' Jacobian at the points."""
    M, places, blocks = memory.M, memory.places, memory.blocks
    blocks[:] = 0.0
    root = 1.0 / math.sqrt(rho)
    for i in range(memory.step.size):
        G, mu = blocks[memory.step[i]], places[BOUNDS, i, 0]
        sticks, free, p, q, across, along = face(
            places[POINT, i, 0], places[POINT, i, 1], places[FORCE, i, 2],
            mu, places[BOUNDS, i, 1], places[BOUNDS, i, 2],
        )  # fmt: skip
        # Π' as a sum of v vᵀ, see `numerics.projection.face`
        if sticks:
            for a in range(3 if free else 2):
                _add_outer(G, M[i], root * (a == 0), root * (a == 1), root * (a == 2))
        if across > 0.0:
            _add_outer(G, M[i], -q * across * root, p * across * root, 0.0)
        if along > 0.0:
            s = along * root
            _add_outer(G, M[i], p * mu * s, q * mu * s, s)


@kernel
def _begin(memory: HorizonMemory, a: FloatArray, rho: float) -> None:
    """Fill a with the motion of the program linearised at guessed points; the points become those of it.

    A guess says which contacts stick, slide or are unloaded; if it is right, this is already a Newton step
    from the solution's own pieces. Guesses at the wanted forces, inside the cones, ignore the cones.
    """
    places, motions = memory.places, memory.motions
    a[:] = 0.0
    for i in range(memory.step.size):
        u, v, w = places[POINT, i, 0], places[POINT, i, 1], places[POINT, i, 2]
        x, r, z = _project(places, i, u, v, w)
        # the force row holds the guess's own projection: `_assemble` reads its height for the faces
        places[FORCE, i, 0], places[FORCE, i, 1], places[FORCE, i, 2] = x, r, z
        # Π(p) + Π'(p) (c - p): the projection linearised at the guess p, at multipliers of zero
        dx, dr, dz = differential(
            u, v, z, places[BOUNDS, i, 0], places[BOUNDS, i, 1], places[BOUNDS, i, 2],
            places[CENTRE, i, 0] - u, places[CENTRE, i, 1] - v, places[CENTRE, i, 2] - w,
        )  # fmt: skip
        _push(memory, a, i, (x + dx, r + dr, z + dz), 1.0)
    _assemble(memory, rho)
    # a + G y = M (Π + Π' (c - p)) with y = P a + q, a = M f at the linearised forces: the motion in place of
    # the right side, the multipliers in DIRECTION
    riccati.solve(memory.tracking, memory.blocks, motions[SLOPE], motions[MOTION], motions[DIRECTION])
    _pull_back(memory, memory.vectors[DIRECTION], rho, CENTRE, POINT)


@kernel
def _evaluate(memory: HorizonMemory, a: FloatArray, rho: float) -> float:
    """Fill the forces at the points and F = a - M f; return Fᵀ P F / ρ, the squared error bound."""
    places, F = memory.places, memory.vectors[GRADIENT]
    for i in range(F.size):
        F[i] = a[i]
    for i in range(memory.step.size):
        f = _project(places, i, places[POINT, i, 0], places[POINT, i, 1], places[POINT, i, 2])
        places[FORCE, i, 0], places[FORCE, i, 1], places[FORCE, i, 2] = f
        _push(memory, F, i, f, -1.0)
    return riccati.energy(memory.tracking, memory.motions[GRADIENT]) / rho


@inline_kernel
def _enter(memory: HorizonMemory, a: FloatArray, rho: float) -> tuple[FloatArray, float]:
    """Evaluate at the points as they are; see `method.Form`, here and below, with a for y."""
    return memory.vectors[GRADIENT], _evaluate(memory, a, rho)


@kernel
def _direction(memory: HorizonMemory, F: FloatArray, rho: float) -> tuple[FloatArray, float]:
    places, d, z = memory.places, memory.vectors[DIRECTION], memory.vectors[CHANGE]
    motions = memory.motions
    _assemble(memory, rho)
    for i in range(z.size):
        # z + G P z = -F gives the motion's step z; the multipliers' step d
        # = P z falls out of the same recursion
        z[i] = -F[i]
    riccati.solve(memory.tracking, memory.blocks, motions[NOTHING], motions[CHANGE], motions[DIRECTION])
    for i in range(memory.step.size):
        for a in range(3):
            places[OLD, i, a] = places[POINT, i, a]
    _pull_back(memory, d, rho, -1, MOVE)
    return d, dot(F, d)


@kernel
def _take(
    memory: HorizonMemory, a: FloatArray, d: FloatArray, rho: float, t: float, before: float
) -> tuple[FloatArray, FloatArray, float, float]:
    places, F = memory.places, memory.vectors[GRADIENT]
    advance(a, t - before, memory.vectors[CHANGE])
    for i in range(memory.step.size):
        for axis in range(3):
            places[POINT, i, axis] = places[OLD, i, axis] + t * places[MOVE, i, axis]
    error = _evaluate(memory, a, rho)
    return a, F, error, dot(F, d)


@inline_kernel
def _line(memory: HorizonMemory, a: FloatArray, d: FloatArray) -> tuple[float, float]:
    return dot(a, d), dot(memory.vectors[CHANGE], d)


@inline_kernel
def _derivative(line: tuple[HorizonMemory, float, float, float], t: float) -> float:
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
def _rounding(memory: HorizonMemory, progress: Progress, tol: float) -> bool:
    return progress.idle > IDLE and progress.best < ROUNDING * tol


@inline_kernel
def _predict(memory: HorizonMemory, a: FloatArray, rho: float, smaller: float) -> FloatArray:
    """Return the motion for the smaller weight if no contact changes its face."""
    _begin(memory, a, smaller)
    return a


FORM = Form(_enter, _direction, _take, _line, _derivative, _rounding, _predict)


@kernel
def _newton(
    memory: HorizonMemory, a: FloatArray, F: FloatArray, error: float, rho: float, tol: float, limit: float,
    patience: float,
) -> tuple[FloatArray, FloatArray, float, int]:  # fmt: skip
    return descend(FORM, STEPS, memory, a, F, error, rho, tol, limit, patience)


@kernel
def _solve(memory: HorizonMemory, rho: float, goal: float, patience: int, limit: int) -> tuple[int, float]:
    """Solve from the points as they are; return the steps and the error, see `newton`."""
    a, places, largest = memory.vectors[MOTION], memory.places, 0.0
    _begin(memory, a, rho)
    F, error = _enter(memory, a, rho)
    a, F, error, total = _newton(memory, a, F, error, rho, goal, float(limit), float(patience))
    # rounding has stopped it near the goal, or patience ran out there: go on without a limit on full steps
    if error > goal and total < limit and error <= ROUNDING * goal:
        a, F, error, count = _newton(memory, a, F, error, rho, goal, float(limit - total), -1.0)
        total += count
    elif error > goal and total < limit:
        M, t, steep = memory.M, memory.tracking, 0.0
        for i in range(memory.step.size):
            largest = max(largest, abs(places[CENTRE, i, 2]))
            for j in range(3):
                places[POINT, i, j] = places[CENTRE, i, j]
                # a force weight as steep as the motion's own cost makes
                # an easy program: there the path starts
                curve = 0.0  # of the cost of the rates that a force leads to in its own step
                for m in range(6):
                    curve += t.weights[1, m] * (t.dt * M[i, j, m]) ** 2
                steep = max(steep, curve)
        left, start = float(limit - total), max(RAISE * rho, steep)
        _begin(memory, a, start)
        stages = Path(start, rho, LOWER, LOOSE * largest**2, STAGE, left, left)
        a, F, error, count = follow_path(FORM, _newton, memory, a, stages, goal)
        total += count
    return total, error


@kernel
def newton(
    cost: riccati.Tracking, q: FloatArray, step: IntArray, foot: IntArray, M: FloatArray, bounds: FloatArray,
    centre: FloatArray, rho: float, tol: float, patience: int, limit: int, points: FloatArray,
    force: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Solve the horizon's program; return the Newton steps and the bound on the forces' error [N].

    Newton's method is tried first from the given start. If that goes too far more than `patience` times (a
    tiny force weight, or a motion far beyond what friction can do), the force weight is raised and lowered
    again in stages, each starting where the faces of the one before lead.

    Parameters
    ----------
    cost
        P.
    q
        (N, 6) gradient.
    step, foot
        (contacts,) the step and the foot that each contact belongs to.
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
        Full steps of the first attempt that may go too far (at most `HASTY` without any guess), and the
        bound on all steps.
    points
        (N, n, 3) a guess of the points whose projections are the forces, NaN where there is none; those of
        the answer on return, NaN in swing.
    force
        (contacts, 3) result.
    """
    N, contacts = q.shape[0], step.size
    places, motions = np.empty((6, contacts, 3)), np.zeros((6, N, 6))
    vectors = motions.reshape((6, 6 * N))
    memory = HorizonMemory(cost, M, step, places, vectors, motions, np.empty((N, 6, 6)))
    motions[SLOPE] = q
    warm = False
    for i in range(contacts):
        point = points[step[i], foot[i]]
        # a foot that has just touched down has no point from the step before: it starts at its wanted force
        known = not math.isnan(point[0] + point[1] + point[2])
        warm = warm or known
        for j in range(3):
            places[CENTRE, i, j], places[BOUNDS, i, j] = centre[i, j], bounds[i, j]
            places[POINT, i, j] = point[j] if known else centre[i, j]
    total, error = _solve(memory, rho, tol * tol, patience if warm else min(patience, HASTY), limit)
    points[:] = np.nan
    for i in range(contacts):
        for j in range(3):
            points[step[i], foot[i], j], force[i, j] = places[POINT, i, j], places[FORCE, i, j]
    return total, math.sqrt(error)
