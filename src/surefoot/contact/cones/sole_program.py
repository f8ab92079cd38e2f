"""Primal-dual interior points over the Coulomb cones at a sole's corners: one small conic program.

A wrench is ordered (f_x, f_y, m_x, m_y, m_z, f_z) here, moments about the mean of the corners and over a
length. A corner at q gives C^T x of its forces x = (f_n, t_x / mu, t_y / mu, moment / (mu radius)),
||x_1..3|| <= x_0, and sees C v of a velocity v, the dual of a wrench. Both programs are

    minimise  W . v + delta ||v||² / 2   over   C_i v in Q (the second-order cone),

delta = 0 with v[5] = 1 for the margin, delta = 1 for the nearest wrench W + v. Their multipliers are the
corners' forces: W + delta v = sum C_i^T x_i. Iterates are feasible on both sides from the first on, so that
each of them is a certificate: forces that give the wrench, a velocity that no corner resists.

Y. Nesterov, M. Todd, "Primal-dual interior-point methods for self-scaled cones", SIAM J. Optim. 8, 1998;
L. Vandenberghe, "The CVXOPT linear and quadratic cone program solvers", 2010, for the scaling's formulae;
S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 2, 1992.

Limits: corners that are not all in line, and mu > 0.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel
from surefoot.base.numerics.small_ldl import factor, solve_factored

NEARLY_ALL = 0.99
"""Share of the way to the border that a step goes [-]: the customary 0.99 and more of interior points."""

# columns of a corner's row in the table
QX, QY, LX, LY = 0, 1, 2, 3
# columns of a corner's row in the work: x, s, steps of both, the scaling point, 1 / beta², the corrector,
# and an x set aside
X, S, DX, DS, POINT, FACTOR, RIGHT, DET_X, DET_S, KEPT, WORK = 0, 4, 8, 12, 16, 20, 21, 25, 26, 27, 31


@inline_kernel
def see(
    table: FloatArray, i: int, mu: float, radius: float, v: FloatArray, work: FloatArray, at: int
) -> None:
    """Set work[i, at : at + 4] to C v for a velocity v (6,)."""
    work[i, at] = v[5] + table[i, LX] * v[2] + table[i, LY] * v[3]
    work[i, at + 1] = mu * (v[0] - table[i, QY] * v[4])
    work[i, at + 2] = mu * (v[1] + table[i, QX] * v[4])
    work[i, at + 3] = mu * radius * v[4]


@inline_kernel
def give(
    table: FloatArray, i: int, mu: float, radius: float, work: FloatArray, at: int, out: FloatArray
) -> None:
    """Add C^T work[i, at : at + 4] to out (6,)."""
    out[0] += mu * work[i, at + 1]
    out[1] += mu * work[i, at + 2]
    out[2] += table[i, LX] * work[i, at]
    out[3] += table[i, LY] * work[i, at]
    out[4] += mu * (
        table[i, QX] * work[i, at + 2] - table[i, QY] * work[i, at + 1] + radius * work[i, at + 3]
    )
    out[5] += work[i, at]


@inline_kernel
def _det(work: FloatArray, i: int, at: int) -> float:
    """Return x_0² - ||x_1..3||² without cancelling squares."""
    size = math.sqrt(work[i, at + 1] ** 2 + work[i, at + 2] ** 2 + work[i, at + 3] ** 2)
    return float((work[i, at] - size) * (work[i, at] + size))


@inline_kernel
def _scaling(work: FloatArray, i: int) -> bool:
    """Set the scaling point and 1 / beta² of one corner; False where an iterate is on the border."""
    dx, ds = _det(work, i, X), _det(work, i, S)
    if not (dx > 0.0 and ds > 0.0):
        return False
    work[i, DET_X], work[i, DET_S] = dx, ds
    dot = (
        work[i, X] * work[i, S]
        + work[i, X + 1] * work[i, S + 1]
        + work[i, X + 2] * work[i, S + 2]
        + work[i, X + 3] * work[i, S + 3]
    )
    # w = (s / √det s + J x / √det x) / (2 γ), γ² = (1 + x.s / √(det x det s)) / 2: W² x = s for W = P(w) beta
    inverse = 1.0 / math.sqrt(dx * ds)
    of_s = math.sqrt(0.5 / (ds * (1.0 + inverse * dot)))
    of_x = of_s * ds * inverse
    work[i, POINT] = of_s * work[i, S] + of_x * work[i, X]
    for j in range(1, 4):
        work[i, POINT + j] = of_s * work[i, S + j] - of_x * work[i, X + j]
    work[i, FACTOR] = dx * inverse
    return True


@inline_kernel
def _arrow(
    w0: float, w1: float, w2: float, w3: float, over: float, x0: float, x1: float, x2: float, x3: float
) -> tuple[float, float, float, float]:
    """Return the product of the matrix of the scaling point w with x, W / beta; J w gives the inverse.

    `over` is 1 / (1 + w0).
    """
    dot = w1 * x1 + w2 * x2 + w3 * x3
    share = x0 + dot * over
    return w0 * x0 + dot, x1 + w1 * share, x2 + w2 * share, x3 + w3 * share


@inline_kernel
def _add_hessian(
    table: FloatArray, i: int, mu: float, radius: float, work: FloatArray, n: int, H: FloatArray
) -> None:
    """Add C^T W^-2 C to H (n, n), lower triangle: W^-2 = (2 a a^T - J) / beta², a = J w."""
    qx, qy, lx, ly = table[i, QX], table[i, QY], table[i, LX], table[i, LY]
    f = work[i, FACTOR]
    a0, a1, a2, a3 = work[i, POINT], -work[i, POINT + 1], -work[i, POINT + 2], -work[i, POINT + 3]
    # rows of C^T a, and what the form has beside them
    g0, g1, g2, g3 = mu * a1, mu * a2, lx * a0, ly * a0
    g4 = mu * (qx * a2 - qy * a1 + radius * a3)
    m2, n0 = f * mu * mu, f * (2.0 * a0 * a0 - 1.0)
    t0, t1, t4 = 2.0 * f * g0, 2.0 * f * g1, 2.0 * f * g4
    H[0, 0] += t0 * g0 + m2
    H[1, 0] += t1 * g0
    H[1, 1] += t1 * g1 + m2
    H[2, 0] += t0 * g2
    H[2, 1] += t1 * g2
    H[2, 2] += n0 * lx * lx
    H[3, 0] += t0 * g3
    H[3, 1] += t1 * g3
    H[3, 2] += n0 * lx * ly
    H[3, 3] += n0 * ly * ly
    H[4, 0] += t4 * g0 - m2 * qy
    H[4, 1] += t4 * g1 + m2 * qx
    H[4, 2] += t4 * g2
    H[4, 3] += t4 * g3
    H[4, 4] += t4 * g4 + m2 * (qx * qx + qy * qy + radius * radius)
    if n == 6:
        H[5, 0] += t0 * a0
        H[5, 1] += t1 * a0
        H[5, 2] += n0 * lx
        H[5, 3] += n0 * ly
        H[5, 4] += t4 * a0
        H[5, 5] += n0


@inline_kernel
def _reach(
    x0: float, x1: float, x2: float, x3: float, d0: float, d1: float, d2: float, d3: float, det: float
) -> float:
    """Return the largest step for which x + step d stays in the second-order cone, 1 or more for no limit."""
    a = d0 * d0 - d1 * d1 - d2 * d2 - d3 * d3
    b = x0 * d0 - x1 * d1 - x2 * d2 - x3 * d3
    if a >= 0.0 and b >= 0.0:
        return 1e300
    # a t² + 2 b t + det = 0: the least positive root, by the form that does not cancel; b² >= a det where
    # a > 0 (Cauchy and Schwarz, reversed), so that below zero it is rounding
    root = math.sqrt(max(b * b - a * det, 0.0))
    return det / (root - b) if b < 0.0 else (b + root) / -a


@inline_kernel
def _direction(
    table: FloatArray, mu: float, radius: float, n: int, H: FloatArray, y: FloatArray, rest: FloatArray,
    work: FloatArray,
) -> float:  # fmt: skip
    r"""Solve for the step y of v and those of all corners; return how far both sides reach.

    `RIGHT` holds W^-1 (λ \ d), see `advance`.
    """
    k = table.shape[0]
    y0, y1, y2, y3, y4, y5 = rest[0], rest[1], rest[2], rest[3], rest[4], rest[5]
    for i in range(k):
        r0, r1, r2, r3 = work[i, RIGHT], work[i, RIGHT + 1], work[i, RIGHT + 2], work[i, RIGHT + 3]
        y0 += mu * r1
        y1 += mu * r2
        y2 += table[i, LX] * r0
        y3 += table[i, LY] * r0
        y4 += mu * (table[i, QX] * r2 - table[i, QY] * r1 + radius * r3)
        y5 += r0
    y[0], y[1], y[2], y[3], y[4], y[5] = y0, y1, y2, y3, y4, y5
    solve_factored(H, n, y)
    y0, y1, y2, y3, y4, y5 = y[0], y[1], y[2], y[3], y[4], y[5]
    step = 1e300
    for i in range(k):
        # Δs = C Δv
        s0 = y5 + table[i, LX] * y2 + table[i, LY] * y3
        s1, s2 = mu * (y0 - table[i, QY] * y4), mu * (y1 + table[i, QX] * y4)
        s3 = mu * radius * y4
        # Δx = W^-1 (λ \ d) - W^-2 Δs, with W^-2 = (2 a a^T - J) / beta², a = J w
        f = work[i, FACTOR]
        a0, a1, a2, a3 = work[i, POINT], -work[i, POINT + 1], -work[i, POINT + 2], -work[i, POINT + 3]
        dot = 2.0 * f * (a0 * s0 + a1 * s1 + a2 * s2 + a3 * s3)
        x0 = work[i, RIGHT] - a0 * dot + f * s0
        x1 = work[i, RIGHT + 1] - a1 * dot - f * s1
        x2 = work[i, RIGHT + 2] - a2 * dot - f * s2
        x3 = work[i, RIGHT + 3] - a3 * dot - f * s3
        step = min(step, _reach(
            work[i, S], work[i, S + 1], work[i, S + 2], work[i, S + 3], s0, s1, s2, s3, work[i, DET_S]
        ))  # fmt: skip
        step = min(step, _reach(
            work[i, X], work[i, X + 1], work[i, X + 2], work[i, X + 3], x0, x1, x2, x3, work[i, DET_X]
        ))  # fmt: skip
        work[i, DS], work[i, DS + 1], work[i, DS + 2], work[i, DS + 3] = s0, s1, s2, s3
        work[i, DX], work[i, DX + 1], work[i, DX + 2], work[i, DX + 3] = x0, x1, x2, x3
    return step


@inline_kernel
def _corrector(work: FloatArray, i: int, centre: float) -> None:
    r"""Set `RIGHT` to W^-1 (λ \ d), d = centre e - λ∘λ - (W^-1 Δs)∘(W Δx) of the steps that are there."""
    w0, w1, w2, w3 = work[i, POINT], work[i, POINT + 1], work[i, POINT + 2], work[i, POINT + 3]
    over = 1.0 / (1.0 + w0)
    # λ / beta, and the steps in its coordinates, one of them without its beta and one with both
    l0, l1, l2, l3 = _arrow(w0, w1, w2, w3, over, work[i, X], work[i, X + 1], work[i, X + 2], work[i, X + 3])
    p0, p1, p2, p3 = _arrow(
        w0, -w1, -w2, -w3, over, work[i, DS], work[i, DS + 1], work[i, DS + 2], work[i, DS + 3]
    )
    r0, r1, r2, r3 = _arrow(
        w0, w1, w2, w3, over, work[i, DX], work[i, DX + 1], work[i, DX + 2], work[i, DX + 3]
    )
    d0 = centre - (p0 * r0 + p1 * r1 + p2 * r2 + p3 * r3)
    d1, d2, d3 = -(p0 * r1 + r0 * p1), -(p0 * r2 + r0 * p2), -(p0 * r3 + r0 * p3)
    # beta z of z = λ \ (d + λ∘λ), by det(λ / beta) = det x
    both = 1.0 / (work[i, DET_X] * l0)
    z0 = (l0 * d0 - l1 * d1 - l2 * d2 - l3 * d3) * both * l0
    both *= work[i, DET_X]
    z1, z2, z3 = (d1 - z0 * l1) * both, (d2 - z0 * l2) * both, (d3 - z0 * l3) * both
    # and W^-1 (z - λ) = W^-1 z - x
    f = work[i, FACTOR]
    r0, r1, r2, r3 = _arrow(w0, -w1, -w2, -w3, over, z0, z1, z2, z3)
    work[i, RIGHT], work[i, RIGHT + 1] = f * r0 - work[i, X], f * r1 - work[i, X + 1]
    work[i, RIGHT + 2], work[i, RIGHT + 3] = f * r2 - work[i, X + 2], f * r3 - work[i, X + 3]


@inline_kernel
def rest_of(
    table: FloatArray, mu: float, radius: float, delta: float, W: FloatArray, v: FloatArray, work: FloatArray,
    rest: FloatArray,
) -> None:  # fmt: skip
    """Set rest (6,) to sum C^T x - W - delta v: what the corners' forces give beyond the wrench."""
    for j in range(6):
        rest[j] = -W[j] - delta * v[j]
    for i in range(table.shape[0]):
        give(table, i, mu, radius, work, X, rest)


@inline_kernel
def advance(
    table: FloatArray, mu: float, radius: float, n: int, W: FloatArray, v: FloatArray, work: FloatArray,
    space: FloatArray,
) -> bool:  # fmt: skip
    """Take one predictor-corrector step of both sides; False where rounding leaves none.

    n = 5 keeps v[5], delta = 0; n = 6 is the nearest wrench, delta = 1. `space` (8, 6) is filled.
    """
    k, delta = table.shape[0], 1.0 if n == 6 else 0.0
    H, rest, y = space[:6], space[6], space[7]
    rest_of(table, mu, radius, delta, W, v, work, rest)
    for i in range(n):
        for j in range(i + 1):
            H[i, j] = 0.0
        H[i, i] = delta
    gap = 0.0
    for i in range(k):
        if not _scaling(work, i):
            return False
        for j in range(4):
            gap += work[i, X + j] * work[i, S + j]
            work[i, RIGHT + j] = -work[i, X + j]
        _add_hessian(table, i, mu, radius, work, n, H)
    factor(H, n)
    # the predictor, and how far it gets
    step = min(1.0, _direction(table, mu, radius, n, H, y, rest, work))
    # Mehrotra's centring, from how much of the gap the predictor leaves
    centre = (1.0 - step) ** 3 * gap / k
    for i in range(k):
        _corrector(work, i, centre)
    step = min(1.0, NEARLY_ALL * _direction(table, mu, radius, n, H, y, rest, work))
    if not (step > 0.0 and abs(y[0]) < 1e100):  # "not" catches NaN
        return False
    for j in range(6):
        v[j] += step * y[j]
    for i in range(k):
        for j in range(4):
            work[i, X + j] += step * work[i, DX + j]
        see(table, i, mu, radius, v, work, S)
    return True


@inline_kernel
def lacking(start: FloatArray, rest: FloatArray, k: int) -> float:
    """Return a total normal force that brings the least corner forces for -rest (5,) into their cones.

    `rest` is what forces give beyond a wrench, which so much more of an even pressure gives exactly.
    """
    short = 0.0
    for i in range(k):
        total = 0.0
        for j in range(5):
            total += start[i, 0, j] * rest[j]
        side = 0.0
        for n in range(1, 4):
            part = 0.0
            for j in range(5):
                part += start[i, n, j] * rest[j]
            side += part * part
        short = max(short, math.sqrt(side) + total)
    return float(k * short)


@inline_kernel
def begin(
    table: FloatArray, start: FloatArray, mu: float, radius: float, W: FloatArray, v: FloatArray,
    work: FloatArray,
) -> float:  # fmt: skip
    """Set x, s and v to a strictly feasible start with v = (0, ..., 0, 1); return its total normal force.

    start (k, 4, 5) is the pseudo-inverse of sum C_i^T without its normal rows: least forces for W[:5], which
    an equal pressure at all corners, of no moment, brings into the cones.
    """
    k = table.shape[0]
    short, size = 0.0, 0.0
    for i in range(k):
        for j in range(4):
            total = 0.0
            for m in range(5):
                total += start[i, j, m] * W[m]
            work[i, X + j] = total
            size = max(size, abs(total))
        t = math.sqrt(work[i, X + 1] ** 2 + work[i, X + 2] ** 2 + work[i, X + 3] ** 2)
        short = max(short, t - work[i, X])
    for j in range(5):
        v[j] = 0.0
    v[5] = 1.0
    for i in range(k):
        work[i, X] += 1.5 * short + 0.1 * size
        for j in range(4):
            work[i, S + j] = 0.0
        work[i, S] = 1.0
    return float(k * short)
