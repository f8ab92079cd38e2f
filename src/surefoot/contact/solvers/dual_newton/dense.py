"""The dual Newton method in any dimension, on dense arrays, with scalar unknowns beside the forces.

As `wrench_distribution`, with B of any height m in place of the six rows, and with unknowns q in intervals
beside the contacts' forces::

    min  1/2 ||B f - L q - b||² + 1/2 ||f - c||² + 1/2 ||q - e||²   f_i in cones, q_j in [low_j, high_j]

where L moves q_j, times its link, into the row m - rows + j. Without intervals and with Bᵀ B + I = G this
is the convex law of any contact problem; intervals carry linear rows, see `rows`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_lower, solve_upper
from surefoot.base.numerics.projection import face, project_truncated
from surefoot.base.numerics.vectors import advance, dot
from surefoot.contact.solvers.dual_newton.method import Form, Path, Progress, Steps, descend, follow_path
from surefoot.contact.solvers.dual_newton.wrench_distribution import ROUNDING

# columns of `sets`, one row per contact and then one per interval
MU, LOW, HIGH, LINK = 0, 1, 2, 3
# rows of `points` (each as long as the unknowns)
CENTRE, POINT, OLD, STEP, VALUE = 0, 1, 2, 3, 4
# rows of `duals` (each m long)
TARGET, DUAL, GRADIENT, DIRECTION, SPARE = 0, 1, 2, 3, 4

STEPS = Steps(ahead=0.3, nearer=0.25, accuracy=0.1)
WARM_STEPS = 20.0
PATH_START, PATH_STEP, PATH_TOLERANCE, STAGE = 0.002, 0.05, 1e-6, 10.0
"""Of the path: first weight over ||B||², its factor per stage, ||F||² over ||b||² that is enough for
a stage, and the most steps of one."""


class DenseMemory(NamedTuple):
    """The program and where the method is; see `minimise`.

    Attributes
    ----------
    columns, sets, points, duals, H
        As for `minimise`.
    contacts
        Their number; what follows them in the sets are intervals, whose points follow those of the forces.
    noise
        The squared relative rounding error of F.
    """

    columns: FloatArray
    sets: FloatArray
    points: FloatArray
    duals: FloatArray
    H: FloatArray
    contacts: int
    noise: float


@kernel
def _project(memory: DenseMemory, t: float) -> None:
    """Set POINT to OLD + t STEP, and VALUE to its projection."""
    sets, points, contacts = memory.sets, memory.points, memory.contacts
    for i in range(points.shape[1]):
        points[POINT, i] = points[OLD, i] + t * points[STEP, i]
    for k in range(contacts):
        i = 3 * k
        points[VALUE, i], points[VALUE, i + 1], points[VALUE, i + 2] = project_truncated(
            points[POINT, i], points[POINT, i + 1], points[POINT, i + 2],
            sets[k, MU], sets[k, LOW], sets[k, HIGH],
        )  # fmt: skip
    for k in range(contacts, sets.shape[0]):
        i = 2 * contacts + k
        points[VALUE, i] = min(max(points[POINT, i], sets[k, LOW]), sets[k, HIGH])


@kernel
def _pull_back(memory: DenseMemory, y: FloatArray, kappa: float) -> None:
    """Set STEP to [Bᵀ; -Lᵀ] y / kappa."""
    columns, sets, points, contacts = memory.columns, memory.sets, memory.points, memory.contacts
    rho = 1.0 / kappa
    for i in range(3 * contacts):
        # Bᵀ y / κ column by column: B is kept transposed, so that every product runs along memory
        points[STEP, i] = rho * dot(columns[i], y)
    for k in range(contacts, sets.shape[0]):
        points[STEP, 2 * contacts + k] = -rho * sets[k, LINK] * y[y.size - sets.shape[0] + k]


@kernel
def _gradient(memory: DenseMemory, t: float) -> float:
    """Move the points to OLD + t STEP, set GRADIENT to y + B f - L q - b there and return its square."""
    _project(memory, t)
    columns, sets, points, contacts = memory.columns, memory.sets, memory.points, memory.contacts
    y, F = memory.duals[DUAL], memory.duals[GRADIENT]
    for a in range(F.size):
        F[a] = y[a] - memory.duals[TARGET, a]
    for i in range(3 * contacts):
        # contacts that are unloaded (at the apex) cost nothing
        value = points[VALUE, i]
        if value != 0.0:
            advance(F, value, columns[i])
    for k in range(contacts, sets.shape[0]):
        F[F.size - sets.shape[0] + k] -= sets[k, LINK] * points[VALUE, 2 * contacts + k]
    return dot(F, F)


@kernel
def _add_outer(H: FloatArray, v: FloatArray) -> None:
    """Add v vᵀ to the lower triangle of H."""
    for a in range(v.shape[0]):
        x = v[a]
        if x != 0.0:
            for c in range(a + 1):
                H[a, c] += x * v[c]


@inline_kernel
def _add_sum(H: FloatArray, columns: FloatArray, i: int, x: float, y: float, z: float, v: FloatArray) -> None:
    """Add v vᵀ for v = B_i (x, y, z)."""
    for a in range(v.shape[0]):
        v[a] = x * columns[i, a] + y * columns[i + 1, a] + z * columns[i + 2, a]
    _add_outer(H, v)


@kernel
def _assemble(memory: DenseMemory, kappa: float) -> None:
    """Set the lower triangle of H to kappa I + the curvature of the contacts and intervals."""
    columns, sets, points, contacts = memory.columns, memory.sets, memory.points, memory.contacts
    H, spare = memory.H, memory.duals[SPARE]
    H[:, :] = 0.0
    for a in range(spare.size):
        H[a, a] = kappa
    for k in range(contacts):
        i, mu = 3 * k, sets[k, MU]
        sticks, free, p, q, across, along = face(
            points[POINT, i], points[POINT, i + 1], points[VALUE, i + 2], mu, sets[k, LOW], sets[k, HIGH]
        )
        if sticks:  # Π' = I, or the tangents' part of it at a bound
            for c in range(3 if free else 2):
                _add_outer(H, columns[i + c])
        # on the cone's side Π' is a sum of v vᵀ over e⊥ and the generator (mu e, 1), see `projection.face`
        if across > 0.0:
            _add_sum(H, columns, i, -q * across, p * across, 0.0, spare)
        if along > 0.0:
            _add_sum(H, columns, i, mu * p * along, mu * q * along, along, spare)
    for k in range(contacts, sets.shape[0]):
        a = spare.size - sets.shape[0] + k
        # an interval's projection has slope one inside and none at its ends
        if sets[k, LOW] < points[VALUE, 2 * contacts + k] < sets[k, HIGH]:
            H[a, a] += sets[k, LINK] ** 2


@kernel
def _solve(H: FloatArray, x: FloatArray) -> None:
    """Replace x by H⁻¹ x, NaN where H is not finite; H becomes its factor."""
    if cholesky(H):
        solve_lower(H, x)
        solve_upper(H, x)
    else:
        x[:] = np.nan


@inline_kernel
def _enter(memory: DenseMemory, y: FloatArray, kappa: float) -> tuple[FloatArray, float]:
    """Place the points and evaluate; see `method.Form`, here and below. y, F and d are rows of `duals`."""
    points = memory.points
    _pull_back(memory, y, kappa)
    for i in range(points.shape[1]):
        points[OLD, i] = points[CENTRE, i]
    return memory.duals[GRADIENT], _gradient(memory, 1.0)


@kernel
def _direction(memory: DenseMemory, F: FloatArray, kappa: float) -> tuple[FloatArray, float]:
    points, d = memory.points, memory.duals[DIRECTION]
    _assemble(memory, kappa)
    for a in range(d.size):
        # (I + B Π' Bᵀ / κ)⁻¹ = κ (κ I + B Π' Bᵀ)⁻¹: H as `_assemble` fills it stays finite for a tiny κ
        d[a] = -kappa * F[a]
    _solve(memory.H, d)
    for i in range(points.shape[1]):
        points[OLD, i] = points[POINT, i]
    _pull_back(memory, d, kappa)
    return d, dot(F, d)


@kernel
def _take(
    memory: DenseMemory, y: FloatArray, d: FloatArray, kappa: float, t: float, before: float
) -> tuple[FloatArray, FloatArray, float, float]:
    F = memory.duals[GRADIENT]
    advance(y, t - before, d)
    error = _gradient(memory, t)
    return y, F, error, dot(F, d)


@inline_kernel
def _line(memory: DenseMemory, y: FloatArray, d: FloatArray) -> tuple[float, float]:
    # of y - b, the part of F that is affine in t: along d its product with d grows by ||d||² a full step
    return dot(y, d) - dot(memory.duals[TARGET], d), dot(d, d)


@inline_kernel
def _derivative(line: tuple[DenseMemory, float, float, float], t: float) -> float:
    memory, kappa, ahead, curve = line
    points = memory.points
    _project(memory, t)
    return kappa * dot(points[VALUE], points[STEP]) + ahead + (t - 1.0) * curve


@kernel
def _noise_floor(memory: DenseMemory) -> float:
    """Return the square of the rounding error of the gradient."""
    return memory.noise * dot(memory.points[POINT], memory.points[POINT])


@inline_kernel
def _rounding(memory: DenseMemory, progress: Progress, tol: float) -> bool:
    return progress.steps > 0 and progress.error <= _noise_floor(memory)


@kernel
def _predict(memory: DenseMemory, y: FloatArray, kappa: float, smaller: float) -> FloatArray:
    """Return the solution for the smaller weight if no contact changes its face."""
    m, H, spare = y.size, memory.H, memory.duals[GRADIENT]
    _assemble(memory, kappa)
    # on one face B Π(c + Bᵀ y / κ) is affine in Bᵀ y / κ: y' = (κ'/κ) H(κ')⁻¹ H(κ) y keeps F = 0
    for a in range(m):
        total = 0.0
        for c in range(m):
            total += (H[a, c] if c <= a else H[c, a]) * y[c]
        spare[a] = total
    for a in range(m):
        y[a] = spare[a] * (smaller / kappa)
        H[a, a] += smaller - kappa
    _solve(H, y)
    return y


FORM = Form(_enter, _direction, _take, _line, _derivative, _rounding, _predict)


@kernel
def _newton(
    memory: DenseMemory, y: FloatArray, F: FloatArray, error: float, kappa: float, tol: float, limit: float,
    patience: float,
) -> tuple[FloatArray, FloatArray, float, int]:  # fmt: skip
    return descend(FORM, STEPS, memory, y, F, error, kappa, tol, limit, patience)


@kernel
def minimise(
    columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray, H: FloatArray,
    warm: bool, tol: float, limit: float,
) -> tuple[float, float, int]:  # fmt: skip
    """Solve the program of this file's header; return ||F||², its rounding floor and the iterations.

    Parameters
    ----------
    columns
        (3 n, m) the columns of B.
    sets
        (n + rows, 4): mu, low, high and link of the contacts (no link) and the intervals.
    points, duals, H
        (5, 3 n + rows), (5, m) and (m, m) work space; CENTRE and TARGET hold c, e and b, VALUE and DUAL
        the answer.
    warm
        Whether DUAL is a good start.
    tol
        Wanted ||F||².
    limit
        Bound on the iterations.
    """
    norm = 0.0
    for i in range(columns.shape[0]):
        norm += dot(columns[i], columns[i])
    contacts, y = columns.shape[0] // 3, duals[DUAL]
    memory = DenseMemory(columns, sets, points, duals, H, contacts, ROUNDING * norm)
    count, error = 0, math.inf
    if warm:
        F, error = _enter(memory, y, 1.0)
        y, F, error, count = _newton(memory, y, F, error, 1.0, tol, WARM_STEPS, -1.0)
    # no good start, or not good enough a one: from y = 0 down the path
    if not error <= max(tol, _noise_floor(memory)):
        duals[DUAL, :] = 0.0
        enough = PATH_TOLERANCE * dot(duals[TARGET], duals[TARGET])
        left = max(limit - count, 1.0)
        path = Path(max(1.0, PATH_START * norm), 1.0, PATH_STEP, enough, STAGE, left, left)
        y, F, error, used = follow_path(FORM, _newton, memory, y, path, tol)
        count += used
    return error, _noise_floor(memory), count
