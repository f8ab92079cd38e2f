"""A small cone program, solved by a compiled primal-dual interior-point method.

    minimise c.x  subject to  B x = b,  x in a product of 3-D Lorentz cones and half-lines,

with few rows (a wrench has six), orthonormal among themselves, and a strictly feasible start. It is
what every question to a stance comes down to: how much margin, how far the centre of mass may move,
how much push a stance withstands.

Method: Nesterov-Todd scaling with Mehrotra's predictor and corrector, as in L. Vandenberghe, "The
CVXOPT linear and quadratic cone program solvers" (2010), sections 4-7. The primal equations hold at
every iterate, since the start satisfies them and every step makes up for rounding; the dual equations
hold after the first full dual step.

No tolerance has a unit: gaps are judged against the objective and the rounding of their own terms,
equations against their terms, so that data of any size take the same steps. The best iterate is kept, and
returned when rounding ends the search first.

Rows may come in blocks (`row_blocks`), and be one too many: with a free unknown t along `axis`,
B x + t axis = b, the equations along it say nothing about x. Many bounds stay cheap that way: turned until
t is gone, every row would touch every unknown.

Limits: normal equations of the number of rows, dense but for blocks; an unbounded program is recognised by a
feasible point below a given value, not by a ray.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import advance, dot
from surefoot.mechanics.statics.row_blocks import (
    advance_span,
    dot_span,
    factor,
    factor_rows,
    first_row,
    pieces,
    solve_factored,
)
from surefoot.mechanics.statics.scaling import apply, corrector_target, scale, step_to_boundary

OPTIMAL, STALLED, UNBOUNDED = 0, 1, 2
"""How `minimise` ended."""

_MOST_ITERATIONS = 60
_ROUNDING = 1e-14
"""Share of the terms of a gap that may be rounding."""
_REFINE = 1e-12
"""Share of their terms by which the equations may be missed before a step mends them."""
_WEAK = 1e-8
"""Share of a diagonal entry below which a pivot has lost too many digits."""
_FEASIBLE = 1e-9
"""Share of their terms by which the equations may be missed by an iterate that is worth anything."""


@inline_kernel
def _factor(
    B: FloatArray, v: FloatArray, eta: FloatArray, lorentz: int, BW: FloatArray, M: FloatArray,
    spans: IntArray | None, axis: FloatArray, free: FloatArray,
) -> float:  # fmt: skip
    """Set BW = B W and M to the Cholesky factor of B W W B'; return the least share that a pivot kept."""
    _normal_matrix(B, v, eta, lorentz, BW, M, spans)
    kept = factor(M, spans, axis, free)
    if kept < _WEAK:
        factor_rows(BW, M, spans, axis, free)
    return float(kept)


@inline_kernel
def _normal_matrix(
    B: FloatArray, v: FloatArray, eta: FloatArray, lorentz: int, BW: FloatArray, M: FloatArray,
    spans: IntArray | None,
) -> None:  # fmt: skip
    """Set BW = B W and the lower triangle of M = B W W B', both where the spans are."""
    for j in range(B.shape[0]):
        for low, high in pieces(spans, j, v.size):
            for k in range(min(low // 3, lorentz), min(high // 3, lorentz)):
                i = 3 * k
                # W = η (2 v vᵀ - diag(1, -1, -1)): the Nesterov-Todd scaling of a Lorentz cone
                dot = 2.0 * (B[j, i] * v[i] + B[j, i + 1] * v[i + 1] + B[j, i + 2] * v[i + 2])
                BW[j, i] = eta[k] * (dot * v[i] - B[j, i])
                BW[j, i + 1] = eta[k] * (dot * v[i + 1] + B[j, i + 1])
                BW[j, i + 2] = eta[k] * (dot * v[i + 2] + B[j, i + 2])
            for i in range(max(low, 3 * lorentz), high):
                BW[j, i] = B[j, i] * v[i]
        for q in range(first_row(spans, j), j + 1):
            M[j, q] = dot_span(BW[j], BW[q], spans, q)


@inline_kernel
def _direction(
    B: FloatArray, BW: FloatArray, M: FloatArray, v: FloatArray, eta: FloatArray, lorentz: int,
    rp: FloatArray, target: FloatArray, Wrd: FloatArray, dx: FloatArray, dz: FloatArray, dy: FloatArray,
    spans: IntArray | None, free: FloatArray,
) -> None:  # fmt: skip
    """Solve B dx = rp, B' dy + dz = rd, W^-1 dx + W dz = target; dx and dz come out scaled."""
    r, m = B.shape
    for j in range(r):
        # eliminate dx and dz: B W W Bᵀ dy = rp + B W (W rd - target)
        s = rp[j]
        for low, high in pieces(spans, j, m):
            for i in range(low, high):
                s += BW[j, i] * (Wrd[i] - target[i])
        dy[j] = s
    solve_factored(M, dy, spans, free)
    for i in range(m):
        dz[i] = Wrd[i]
    for j in range(r):
        advance_span(dz, -dy[j], BW[j], spans, j)
    for i in range(m):
        dx[i] = target[i] - dz[i]


@inline_kernel
def _refine(
    BW: FloatArray, M: FloatArray, rp: FloatArray, dx: FloatArray, dz: FloatArray, dy: FloatArray,
    rest: FloatArray, more: FloatArray, spans: IntArray | None, free: FloatArray,
) -> None:  # fmt: skip
    """Solve once more for what B dx = rp still lacks: M loses digits near the cones' boundary."""
    r, m = BW.shape
    for j in range(r):
        s = rp[j]
        for low, high in pieces(spans, j, m):
            for i in range(low, high):
                s -= BW[j, i] * dx[i]
        rest[j] = s
    solve_factored(M, rest, spans, free)
    for j in range(r):
        # The step back in x is the step on in z: their sum stays the target, and the dual equation keeps
        # holding.
        dy[j] += rest[j]
    for i in range(m):
        more[i] = 0.0
    for j in range(r):
        advance_span(more, rest[j], BW[j], spans, j)
    for i in range(m):
        dx[i] += more[i]
        dz[i] -= more[i]


@kernel
def minimise(
    B: FloatArray, b: FloatArray, c: FloatArray, lorentz: int, x: FloatArray, y: FloatArray, z: FloatArray,
    tol: float, floor: float, zero: float, spans: IntArray | None, axis: FloatArray,
) -> tuple[int, int]:  # fmt: skip
    """Solve the cone program in place, from a strictly feasible x.

    Parameters
    ----------
    B, b, c
        (r, m), (r,), (m,): orthonormal rows, right-hand side, objective.
    lorentz
        How many 3-D Lorentz cones come first in x, each (height, two sides); the rest are half-lines.
    x, y, z
        (m,), (r,), (m,): in, a strictly feasible x; out, the solution, multipliers and z = c - B' y.
    tol
        The gap to reach, in the objective's units, or else 1e-10 of the objective less `zero`.
    floor
        Below this objective the program counts as unbounded.
    zero
        What the objective is counted from.
    spans
        (r or more, 5): what each row touches (`row_blocks`); B is zero elsewhere. None: all touch everything.
    axis
        (r,), of length one: the equations hold but for a multiple of it, and y is at right angles to it. Or
        (0,): all of them hold.

    Returns
    -------
    tuple[int, int]
        OPTIMAL, STALLED (x, y, z are the iterate with the least gap) or UNBOUNDED (x is feasible, and its
        objective below the floor); and the iterations.
    """
    r, m = B.shape
    degree = lorentz + (m - 3 * lorentz)
    work = np.empty((11, m))
    v, lam, target, Wrd, dx, dz = work[0], work[1], work[2], work[3], work[4], work[5]
    u, spare, rd, best_x, best_z, best_y = work[6], work[7], work[8], work[9], work[10], np.empty(r)
    BW, M, eta, best = np.empty((r, m)), np.empty((r, r)), np.empty(lorentz), math.inf
    dy, rp, rest, free = np.empty(r), np.empty(r), np.empty(r), np.empty(axis.size + min(1, axis.size))
    _dual_start(B, c, lorentz, y, z, spans, axis)
    for iteration in range(_MOST_ITERATIONS):
        # x.z bounds the distance to the optimum where both programs' equations hold: both are judged.
        gap, value, rounding, lost = _gap(B, b, c, x, y, z, rd, spare, spans)
        left, missed = _missing(B, b, x, rp, spans, axis)
        if lost <= 1e-12 and missed <= _FEASIBLE and gap <= tol + 1e-10 * abs(value - zero) + rounding:
            return OPTIMAL, iteration
        if value < floor and left <= _FEASIBLE:
            return UNBOUNDED, iteration
        # the best iterate is kept, since the last one may be the worse for rounding
        merit = gap if max(lost, missed) <= _FEASIBLE else 1e30 * max(lost, missed)
        if merit < best:
            best = merit
            _copy(x, y, z, best_x, best_y, best_z)
        elif not gap < 1e6 * best:  # rounding has taken over
            break
        if not scale(x, z, lorentz, v, eta):  # W z = W⁻¹ x = λ: both programs alike from there
            break
        apply(v, eta, lorentz, False, z, lam)
        apply(v, eta, lorentz, False, rd, Wrd)
        kept = _factor(B, v, eta, lorentz, BW, M, spans, axis, free)
        if math.isnan(kept):
            break
        sigma, primal, dual, product = 0.0, 0.0, 0.0, dot(x, z)
        # Mehrotra 1992: the first direction aims at the gap zero and tells how far that works; the second
        for corrector in range(2):
            if corrector:  # is centred accordingly, and takes along the first one's second-order error
                corrector_target(lam, dx, dz, sigma * product / degree, lorentz, target)
            else:
                _negate(lam, target)
            _direction(B, BW, M, v, eta, lorentz, rp, target, Wrd, dx, dz, dy, spans, free)
            if left > _REFINE or kept < _WEAK:
                _refine(BW, M, rp, dx, dz, dy, rest, spare, spans, free)
            primal = step_to_boundary(lam, dx, lorentz)
            dual = step_to_boundary(lam, dz, lorentz)
            sigma = (1.0 - min(1.0, primal, dual)) ** 3  # the sooner it meets the boundary, the more
        primal, dual = min(1.0, 0.99 * primal), min(1.0, 0.99 * dual)  # strictly inside
        apply(v, eta, lorentz, False, dx, u)
        advance(x, primal, u)
        apply(v, eta, lorentz, True, dz, u)
        advance(z, dual, u)
        advance(y, dual, dy)
        if lost * (1.0 - dual) < 1e-9:  # nearly feasible: z from the equation itself
            _set_slack(B, c, lorentz, y, z, rd, spans)
        if max(primal, dual) < 1e-8:
            break
    if best < math.inf:
        _copy(best_x, best_y, best_z, x, y, z)
    return STALLED, iteration


@inline_kernel
def _negate(x: FloatArray, out: FloatArray) -> None:
    """Set out (m,) to -x."""
    for i in range(x.size):
        out[i] = -x[i]


@inline_kernel
def _copy(
    x: FloatArray, y: FloatArray, z: FloatArray, x_: FloatArray, y_: FloatArray, z_: FloatArray
) -> None:
    """Write x, y, z into x_, y_, z_ (as slices they would take seconds to compile)."""
    for i in range(x.size):
        x_[i], z_[i] = x[i], z[i]
    for j in range(y.size):
        y_[j] = y[j]


@inline_kernel
def _gap(
    B: FloatArray, b: FloatArray, c: FloatArray, x: FloatArray, y: FloatArray, z: FloatArray, rd: FloatArray,
    weight: FloatArray, spans: IntArray | None,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the gap, the objective, the gap's own rounding, and the share of the dual equations unmet.

    The gap is the larger of x.z and c.x - b.y: they differ by what the equations miss. That is a share of the
    largest terms: those of an equation may all tend to zero. Sets rd = c - z - B' y, and `weight` (m,) to the
    sizes of its terms.
    """
    r, m = B.shape
    product, value, bound, size, lost, largest = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(m):
        rd[i], weight[i] = c[i] - z[i], abs(c[i]) + abs(z[i])
    for j in range(r):
        for low, high in pieces(spans, j, m):
            for i in range(low, high):
                part = B[j, i] * y[j]
                rd[i] -= part
                weight[i] += abs(part)
        bound += b[j] * y[j]
    for i in range(m):
        lost, largest = max(lost, abs(rd[i])), max(largest, weight[i])
        # The gap twice: where both programs' equations hold they are one number, and where they do not
        # neither may make the iterate look better than it is.
        product += x[i] * z[i]
        value += c[i] * x[i]
        size += abs(c[i] * x[i])
    for j in range(r):
        size += abs(b[j] * y[j])
    lost = lost / largest if largest > 0.0 else 0.0
    return max(product, abs(value - bound)), value, _ROUNDING * size, lost


@inline_kernel
def _missing(
    B: FloatArray, b: FloatArray, x: FloatArray, rp: FloatArray, spans: IntArray | None, axis: FloatArray
) -> tuple[float, float]:
    """Set rp = b - B x, or zero where that is rounding; return its largest share of its terms, and of all.

    An equation among small numbers may miss much of its own terms and be of no weight among the others.
    """
    # Terms cancel: what rounding leaves of a sum is a share of the sum of their sizes, not of the sum.
    worst, most, largest, along = 0.0, 0.0, 0.0, 0.0
    if axis.size > 0:  # what is missed along the axis is the free unknown's
        for j in range(rp.size):
            along += axis[j] * (b[j] - dot_span(B[j], x, spans, j))
    for j in range(rp.size):
        free = along * axis[j] if axis.size > 0 else 0.0
        s, size = b[j] - free, abs(b[j]) + abs(free)
        for low, high in pieces(spans, j, x.size):
            for i in range(low, high):
                s -= B[j, i] * x[i]
                size += abs(B[j, i] * x[i])
        if abs(s) > worst * size:
            worst = abs(s) / size
        most, largest = max(most, abs(s)), max(largest, size)
        rp[j] = s if abs(s) > _REFINE * size else 0.0
    return worst, (most / largest if largest > 0.0 else 0.0)


@inline_kernel
def _slack(B: FloatArray, c: FloatArray, y: FloatArray, out: FloatArray, spans: IntArray | None) -> None:
    """Set out (m,) to c - B' y."""
    for i in range(c.size):
        out[i] = c[i]
    for j in range(y.size):
        advance_span(out, -y[j], B[j], spans, j)


@inline_kernel
def _set_slack(
    B: FloatArray, c: FloatArray, lorentz: int, y: FloatArray, z: FloatArray, trial: FloatArray,
    spans: IntArray | None,
) -> None:  # fmt: skip
    """Set z = c - B' y, so that the dual equations hold to rounding, if that is inside the cone."""
    m = c.size
    # Steps add up their rounding in z, the slack of y has none of it. Outside the cone there is no scaling:
    # then z stays.
    _slack(B, c, y, trial, spans)
    for k in range(lorentz):
        i = 3 * k
        if trial[i] <= math.sqrt(trial[i + 1] * trial[i + 1] + trial[i + 2] * trial[i + 2]):
            return
    for i in range(3 * lorentz, m):
        if trial[i] <= 0.0:
            return
    for i in range(m):  # as a slice it would take 2 s to compile
        z[i] = trial[i]


@inline_kernel
def _dual_start(
    B: FloatArray, c: FloatArray, lorentz: int, y: FloatArray, z: FloatArray, spans: IntArray | None,
    axis: FloatArray,
) -> None:  # fmt: skip
    """Set y = B c and z = c - B' y, moved into the cone along its axis."""
    r, m = B.shape
    for j in range(r):
        # B has orthonormal rows, so this is the y with the least |c - B' y|.
        y[j] = dot_span(B[j], c, spans, j)
    if axis.size > 0:
        advance(y, -dot(axis, y), axis)
    _slack(B, c, y, z, spans)
    # From the boundary, or close to it, Newton's first steps would be cut short: z is moved in by its own
    # size.
    size, depth = dot(z, z), math.inf
    for k in range(lorentz):
        depth = min(depth, z[3 * k] - math.hypot(z[3 * k + 1], z[3 * k + 2]))
    for i in range(3 * lorentz, m):
        depth = min(depth, z[i])
    size = math.sqrt(size / max(1, m))
    if depth < 0.1 * size or size == 0.0:
        shift = (size if size > 0.0 else 1.0) - depth
        for k in range(lorentz):
            z[3 * k] += shift
        for i in range(3 * lorentz, m):
            z[i] += shift
