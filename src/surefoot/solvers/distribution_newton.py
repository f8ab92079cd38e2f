"""Compiled Newton method for the convex law in any dimension, with scalar unknowns beside the forces.

The same dual Newton method as `surefoot.solvers.distribution_wrench`, with B of any height m in place
of the six rows of the wrench, and with scalar unknowns in intervals beside the contacts' forces::

    min  1/2 ||B f - L q - b||² + 1/2 ||f - c||² + 1/2 ||q - e||²   f_i in cones, q_j in [low_j, high_j]

where L moves q_j, times its link, into the row m - rows + j. Without intervals and with Bᵀ B + I = G this
is the convex law of any contact problem; intervals carry linear rows, see
`surefoot.solvers.distribution_rows`.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.cones.projection import project_truncated
from surefoot.kernels import kernel
from surefoot.solvers.distribution_wrench import ROUNDING

# columns of `sets`, one row per contact and then one per interval
MU, LOW, HIGH, LINK = 0, 1, 2, 3
# rows of `points` (each as long as the unknowns)
CENTRE, POINT, OLD, STEP, VALUE = 0, 1, 2, 3, 4
# rows of `duals` (each m long)
TARGET, DUAL, GRADIENT, DIRECTION, SPARE = 0, 1, 2, 3, 4

PATH_START, PATH_STEP, PATH_TOLERANCE = 0.002, 0.05, 1e-6


@kernel
def project(sets: FloatArray, points: FloatArray, contacts: int) -> None:
    """Set VALUE to the projection of POINT."""
    for k in range(contacts):
        i = 3 * k
        points[VALUE, i], points[VALUE, i + 1], points[VALUE, i + 2] = project_truncated(
            points[POINT, i], points[POINT, i + 1], points[POINT, i + 2],
            sets[k, MU], sets[k, LOW], sets[k, HIGH],
        )  # fmt: skip
    for j in range(contacts, sets.shape[0]):
        i = j + 2 * contacts
        points[VALUE, i] = min(max(points[POINT, i], sets[j, LOW]), sets[j, HIGH])


@kernel
def pull_back(
    columns: FloatArray, sets: FloatArray, y: FloatArray, out: FloatArray, rho: float, contacts: int
) -> None:
    """Set `out`, a row of `points`, to rho [Bᵀ; -Lᵀ] y."""
    m = y.shape[0]
    for i in range(3 * contacts):
        total = 0.0
        for a in range(m):
            total += columns[i, a] * y[a]
        out[i] = rho * total
    rows = sets.shape[0] - contacts
    for j in range(rows):
        out[3 * contacts + j] = -rho * sets[contacts + j, LINK] * y[m - rows + j]


@kernel
def gradient(
    columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray, contacts: int
) -> float:
    """Project, set GRADIENT to y + B f - L q - b and return its square."""
    project(sets, points, contacts)
    m = duals.shape[1]
    for a in range(m):
        duals[GRADIENT, a] = duals[DUAL, a] - duals[TARGET, a]
    for i in range(3 * contacts):
        value = points[VALUE, i]
        if value != 0.0:
            for a in range(m):
                duals[GRADIENT, a] += columns[i, a] * value
    rows = sets.shape[0] - contacts
    for j in range(rows):
        duals[GRADIENT, m - rows + j] -= sets[contacts + j, LINK] * points[VALUE, 3 * contacts + j]
    total = 0.0
    for a in range(m):
        total += duals[GRADIENT, a] ** 2
    return total


@kernel
def add_outer(H: FloatArray, v: FloatArray) -> None:
    """Add v vᵀ to the lower triangle of H."""
    for a in range(v.shape[0]):
        x = v[a]
        if x != 0.0:
            for c in range(a + 1):
                H[a, c] += x * v[c]


@kernel
def assemble(
    columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray, H: FloatArray,
    kappa: float, contacts: int,
) -> None:  # fmt: skip
    """Set the lower triangle of H to kappa I + the curvature of the contacts and intervals."""
    m = H.shape[0]
    H[:, :] = 0.0
    for a in range(m):
        H[a, a] = kappa
    spare = duals[SPARE]
    for k in range(contacts):
        i = 3 * k
        mu, low, high = sets[k, MU], sets[k, LOW], sets[k, HIGH]
        u, v, z = points[POINT, i], points[POINT, i + 1], points[VALUE, i + 2]
        free, limit, t = low < z < high, mu * z, math.sqrt(u * u + v * v)
        if t <= limit and limit > 0.0:
            add_outer(H, columns[i])
            add_outer(H, columns[i + 1])
            if free:
                add_outer(H, columns[i + 2])
        elif z > 0.0:
            p, q = (u / t, v / t) if t > 0.0 else (0.0, 0.0)
            if limit > 0.0:
                s = math.sqrt(limit / t)
                for a in range(m):
                    spare[a] = s * (p * columns[i + 1, a] - q * columns[i, a])
                add_outer(H, spare)
            if free:
                s = 1.0 / math.sqrt(1.0 + mu * mu)
                for a in range(m):
                    spare[a] = s * (columns[i + 2, a] + mu * (p * columns[i, a] + q * columns[i + 1, a]))
                add_outer(H, spare)
    rows = sets.shape[0] - contacts
    for j in range(rows):
        z = points[VALUE, 3 * contacts + j]
        if sets[contacts + j, LOW] < z < sets[contacts + j, HIGH]:
            H[m - rows + j, m - rows + j] += sets[contacts + j, LINK] ** 2


@kernel
def solve_in_place(H: FloatArray, x: FloatArray) -> None:
    """Replace x by H⁻¹ x; the lower triangle of H becomes its Cholesky factor."""
    m = x.shape[0]
    for a in range(m):
        for c in range(a + 1):
            total = H[a, c]
            for e in range(c):
                total -= H[a, e] * H[c, e]
            H[a, c] = math.sqrt(total) if a == c else total / H[c, c]
    for a in range(m):
        total = x[a]
        for c in range(a):
            total -= H[a, c] * x[c]
        x[a] = total / H[a, a]
    for a in range(m - 1, -1, -1):
        total = x[a]
        for c in range(a + 1, m):
            total -= H[c, a] * x[c]
        x[a] = total / H[a, a]


@kernel
def step_length(
    sets: FloatArray, points: FloatArray, contacts: int, kappa: float, line: tuple[float, float, float, float]
) -> float:
    """Return a step in (0, 1) at which the dual's derivative is a tenth of that at 0, or less.

    `line` is (base, curve, derivative at 0, derivative at 1): base + t curve is what y adds to it.
    """
    base, curve, at_0, at_1 = line
    left, right, f_left, f_right = 0.0, 1.0, at_0, at_1
    t, side = 1.0, 0
    for k in range(60):
        t = (left * f_right - right * f_left) / (f_right - f_left)
        if k % 3 == 2:
            t = 0.5 * (left + right)
        move(points, t)
        project(sets, points, contacts)
        f = base + t * curve
        for i in range(points.shape[1]):
            f += kappa * points[VALUE, i] * points[STEP, i]
        if abs(f) <= -0.1 * at_0:
            break
        if f < 0.0:
            left, f_left = t, f
            f_right = 0.5 * f_right if side < 0 else f_right
            side = -1
        else:
            right, f_right = t, f
            f_left = 0.5 * f_left if side > 0 else f_left
            side = 1
    return t


@kernel
def move(points: FloatArray, t: float) -> None:
    """Set POINT to OLD + t STEP."""
    for i in range(points.shape[1]):
        points[POINT, i] = points[OLD, i] + t * points[STEP, i]


@kernel
def noise_floor(points: FloatArray, noise: float) -> float:
    """Return the square of the rounding error of the gradient."""
    total = 0.0
    for i in range(points.shape[1]):
        total += points[POINT, i] ** 2
    return noise * total


@kernel
def newton(
    columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray, H: FloatArray,
    kappa: float, tol: float, noise: float, limit: float,
) -> tuple[float, int]:  # fmt: skip
    """Solve for weights kappa times larger, from the dual point in `duals`; return ||F||², iterations."""
    contacts = (points.shape[1] - sets.shape[0]) // 2
    m = duals.shape[1]
    y, F, d = duals[DUAL], duals[GRADIENT], duals[DIRECTION]
    pull_back(columns, sets, y, points[POINT], 1.0 / kappa, contacts)
    for i in range(points.shape[1]):
        points[POINT, i] += points[CENTRE, i]
    error = gradient(columns, sets, points, duals, contacts)
    best, count = error, 0
    while error > tol and count < limit and (count == 0 or error > noise_floor(points, noise)):
        count += 1
        assemble(columns, sets, points, duals, H, kappa, contacts)
        for a in range(m):
            d[a] = -kappa * F[a]
        solve_in_place(H, d)
        base = curve = at_0 = at_1 = 0.0
        for a in range(m):
            base += (y[a] - duals[TARGET, a]) * d[a]
            curve += d[a] * d[a]
            at_0 += F[a] * d[a]
            y[a] += d[a]
        for i in range(points.shape[1]):
            points[OLD, i] = points[POINT, i]
        pull_back(columns, sets, d, points[STEP], 1.0 / kappa, contacts)
        move(points, 1.0)
        error = gradient(columns, sets, points, duals, contacts)
        for a in range(m):
            at_1 += F[a] * d[a]
        if at_1 > -0.3 * at_0 and error > 0.25 * best:  # too far, and no nearer either
            t = step_length(sets, points, contacts, kappa, (base, curve, at_0, at_1))
            for a in range(m):
                y[a] += (t - 1.0) * d[a]
            error = gradient(columns, sets, points, duals, contacts)
        best = min(best, error)
    return error, count


@kernel
def shrink_weight(
    columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray, H: FloatArray,
    kappa: float, smaller: float,
) -> None:  # fmt: skip
    """Predict the dual point for a smaller force weight, as if no contact changed its face."""
    contacts = (points.shape[1] - sets.shape[0]) // 2
    m = duals.shape[1]
    y, spare = duals[DUAL], duals[GRADIENT]
    assemble(columns, sets, points, duals, H, kappa, contacts)
    for a in range(m):
        total = 0.0
        for c in range(m):
            total += (H[a, c] if c <= a else H[c, a]) * y[c]
        spare[a] = total
    for a in range(m):
        y[a] = spare[a] * (smaller / kappa)
        H[a, a] += smaller - kappa
    solve_in_place(H, y)


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
        for a in range(columns.shape[1]):
            norm += columns[i, a] ** 2
    noise, size, count, error = ROUNDING * norm, 0.0, 0, np.inf
    for a in range(duals.shape[1]):
        size += duals[TARGET, a] ** 2
    if warm:
        error, count = newton(columns, sets, points, duals, H, 1.0, tol, noise, 20.0)
    if not error <= max(tol, noise_floor(points, noise)):
        kappa = max(1.0, PATH_START * norm)
        duals[DUAL, :] = 0.0
        while kappa > 1.0:
            _, used = newton(columns, sets, points, duals, H, kappa, PATH_TOLERANCE * size, noise, 10.0)
            count += used
            smaller = max(1.0, kappa * PATH_STEP)
            shrink_weight(columns, sets, points, duals, H, kappa, smaller)
            kappa = smaller
        error, used = newton(columns, sets, points, duals, H, 1.0, tol, noise, max(limit - count, 1.0))
        count += used
    return error, noise_floor(points, noise), count
