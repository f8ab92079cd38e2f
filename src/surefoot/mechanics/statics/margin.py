"""The kernel behind `can_stand`: the contact forces with the most margin, or a separating wrench.

    maximise t  subject to  A f = w,  f - t e in K,

where e is the axis of every cone, scaled so that t is the Euclidean distance of each contact's force
to its cone's boundary. Its dual is

    minimise y.w  subject to  A' y in K*,  (A e).y = 1,

so that t < 0 comes with a y that proves it: every admissible force has y.(A f) >= 0, and y.w < 0. In floating
point A' y leaves K* by some d, so the proof has a reach (`proof_reach`): forces that hold the load would
sum up to |y.w| / d at least. Nothing is called infeasible below `REACH`, nor feasible unless the forces found
are in their cones and give the load within `BAND`; what is neither is undecided.

Both programs always have strict interior points (t may be as negative as it likes), unless the contacts
can squeeze without limit; then t is infinite.

Coordinates: a friction cone is the Lorentz cone of u = (f_z, f_x / mu, f_y / mu), so that mu = 0 needs no
case of its own. Wrenches are divided by the load and by a length, so that no tolerance has a unit. A contact
without friction has a cone without width; its margin is its normal force, which jumps at mu = 0 and
nowhere else.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.orthogonal import coordinates, pull_back, reflect, turn_first_row
from surefoot.base.numerics.vectors import advance, dot
from surefoot.mechanics.statics.cone_program import UNBOUNDED, minimise
from surefoot.mechanics.statics.row_blocks import (
    advance_span,
    dot_span,
    local_rows,
    orthonormal_blocks,
    pieces,
)

FEASIBLE, INFEASIBLE, UNREACHABLE, ENDLESS, UNDECIDED = 0, 1, 2, 3, 4
"""Outcomes: margin >= 0; margin < 0; load outside the range of the contact forces; margin without bound;
neither forces nor a proof that there are none."""

GAP = 1e-10
"""Gap between margin and certificate at which the search ends, as a share of the load."""
BAND = 1e-9
"""Forces that leave their cones by less than this share of the load count as possible."""
REACH = 1e4
"""Total normal force, in loads, that an infeasibility proof must at least rule out."""
LEAST_MU = 1e-9
"""Friction below which a contact's margin, at most mu times its normal force, is within `BAND` anyway."""
_ROUNDING = 32.0 * 2.0**-53
"""Share of the largest terms by which A' y may be wrong, the rounding of A included."""
_ENDLESS_MARGIN = 1e6
RUNAWAY = 1e3
"""Forces of so many loads, where bounds take part, are taken for a squeeze that nothing stops."""
_LONG_AXIS = 1e3
"""Of a cone beside half-lines: friction below a thousandth (`_column_scales`)."""
_SQUEEZE = 0.1


@inline_kernel
def depth(x: FloatArray, e: FloatArray, lorentz: int) -> float:
    """Return the largest t with x - t e in the cone, x and e (m,), e > 0 on the axes."""
    # The axis has a height alone: |x_t| <= x_0 - t e solves for t cone by cone.
    least = math.inf
    for k in range(lorentz):
        i = 3 * k
        least = min(least, (x[i] - math.hypot(x[i + 1], x[i + 2])) / e[i])
    for i in range(3 * lorentz, x.size):
        least = min(least, x[i] / e[i])
    return least


@inline_kernel
def _outside(x: FloatArray, e: FloatArray, lorentz: int) -> float:
    """Return how far a force is outside its cone at most: of the cone's face, or below the ground."""
    worst = 0.0
    for k in range(lorentz):
        i = 3 * k
        worst = max(worst, -x[i], (math.hypot(x[i + 1], x[i + 2]) - x[i]) / e[i])
    for i in range(3 * lorentz, x.size):
        worst = max(worst, -x[i])
    return worst


@inline_kernel
def _left_over(A: FloatArray, w: FloatArray, x: FloatArray) -> float:
    """Return the largest entry of w - A x."""
    worst = 0.0
    for j in range(w.size):
        s = w[j]
        for i in range(x.size):
            s -= A[j, i] * x[i]
        worst = max(worst, abs(s))
    return worst


@kernel
def proof_reach(A: FloatArray, w: FloatArray, y: FloatArray, lorentz: int) -> float:
    """Return how large x (m,) in K with A x = w must at least be: the sum of its heights and half-lines.

    A is (p, m), w and y (p,).

    A' y may leave K* by d, rounding included: then y.w = (A' y).x >= -d sum(x), so that the sum is at least
    |y.w| / d. Infinite where A' y is in K*; zero where y proves nothing.
    """
    work, rounding = 0.0, 0.0
    for j in range(w.size):
        work += y[j] * w[j]
        rounding += abs(y[j] * w[j])
    # Rounding is charged against the proof, here and below: what holds only by the luck of its sums does not
    # count.
    work += _ROUNDING * rounding
    if not work < 0.0:
        return 0.0
    lack = 0.0
    for k in range(lorentz):
        i = 3 * k
        z0, z1, z2, size = 0.0, 0.0, 0.0, 0.0
        for j in range(w.size):
            z0 += A[j, i] * y[j]
            z1 += A[j, i + 1] * y[j]
            z2 += A[j, i + 2] * y[j]
            size += max(abs(A[j, i]), abs(A[j, i + 1]), abs(A[j, i + 2])) * abs(y[j])
        # The Lorentz cone is its own dual: z leaves it by |z_t| - z_0, a half-line by -z_0.
        lack = max(lack, math.hypot(z1, z2) - z0 + _ROUNDING * size)
    for i in range(3 * lorentz, A.shape[1]):
        z0, size = 0.0, 0.0
        for j in range(w.size):
            z0 += A[j, i] * y[j]
            size += abs(A[j, i] * y[j])
        lack = max(lack, _ROUNDING * size - z0)
    return -work / lack if lack > 0.0 else math.inf


@kernel
def most_margin(
    A: FloatArray, e: FloatArray, w: FloatArray, lorentz: int, blocks: IntArray | None
) -> tuple[int, float, FloatArray, FloatArray, float]:
    """Maximise t with A x = w, x - t e in K; all quantities scaled (|w| about 1, rows about 1).

    Parameters
    ----------
    A, e, w
        (p, m), (m,), (p,).
    lorentz
        Number of 3-D Lorentz cones at the front of x; the rest are half-lines.
    blocks
        (g, 6): rows of A that are alone with their columns (`row_blocks`), at its end; None where none are.

    Returns
    -------
    tuple[int, float, FloatArray, FloatArray, float]
        Outcome, t, x (m,), y (p,) with A' y in K* and (A e).y = 1 (zero where there is none), and the
        reach of the proof that y is (zero where the outcome is not an infeasible one).
    """
    scales = _column_scales(e, lorentz)
    if not scales.size:
        return _most_margin(A, e, w, lorentz, blocks)
    # Forces and proof are judged in the columns as they were given: scaling moves what rounding spoils.
    outcome, t, x, y, reach = _most_margin(A * scales, e / scales, w, lorentz, blocks)
    for i in range(x.size):
        x[i] *= scales[i]
    if outcome in (FEASIBLE, ENDLESS):
        return _accept(A, e, w, lorentz, x, outcome), t, x, y, reach
    reach = proof_reach(A, w, y, lorentz)
    if reach < REACH:
        outcome = UNDECIDED
    elif outcome == UNDECIDED:  # a proof in the columns as they are, which the scaled ones did not show
        outcome = INFEASIBLE
    return outcome, t, x, y, reach


@inline_kernel
def _column_scales(e: FloatArray, lorentz: int) -> FloatArray:
    """Return (m,) scales of the columns; none of them, (0,), where they are good as they are.

    The axis of a cone with hardly any friction moves by e = 1 / mu, a bound's half-line by about one: beside
    each other they cost the margin as many digits as e has. Columns times the root of e share them out.
    """
    if e.size == 3 * lorentz or e.max() < _LONG_AXIS:
        return np.empty(0)
    scales = np.ones(e.size)
    for i in range(e.size):
        axis = e[i - i % 3] if i < 3 * lorentz else e[i]
        if axis >= _LONG_AXIS:
            scales[i] = math.sqrt(axis)
    return scales


@kernel
def _most_margin(
    A: FloatArray, e: FloatArray, w: FloatArray, lorentz: int, blocks: IntArray | None
) -> tuple[int, float, FloatArray, FloatArray, float]:
    """Return what `most_margin` does, in columns that need no scaling."""
    p, m = A.shape
    Q, T, pivots = np.empty((p, m)), np.empty((p, p)), np.empty(p, dtype=np.int64)
    b, a, h, full = np.zeros(p), np.zeros(p), np.zeros(p), np.zeros(p)
    x, y = np.zeros(m), np.zeros(p)
    spans = blocks if blocks is None else np.empty((p, 5), dtype=np.int64)
    rank = orthonormal_blocks(A, blocks, Q, T, pivots, spans)
    apart = local_rows(spans) > 0
    # A = T Q: A x = w is Q x = b, if w is in the range of A at all.
    if coordinates(T, pivots, rank, w, b) > BAND:
        _unreachable(T, pivots, rank, w, full, y)
        reach = proof_reach(A, w, y, lorentz)
        return (UNREACHABLE if reach >= REACH else UNDECIDED), -math.inf, x, y, reach
    for j in range(rank):
        advance_span(x, b[j], Q[j], spans, j)
    least_norm = x.copy()  # A⁺ w: what all solutions have in common; t0 is its margin
    for j in range(rank):
        a[j] = dot_span(Q[j], e, spans, j)
    # With x = u + t e, u in K: Q u + t a = b, a = Q e. Rows turned until a lies along the first one, that row
    # is c.u + t alpha = zero, and the others say nothing of t: the most t is the least c.u.
    steepest = e.max()
    alpha = math.sqrt(dot(a, a)) if apart else turn_first_row(Q, rank, a, h, b)
    t0 = depth(x, e, lorentz)
    squeeze = min(_SQUEEZE, 1.0 / steepest)
    # A e = 0: forces along all axes cancel, so the contacts squeeze each other as much as one likes.
    if alpha <= 1e-9 * math.sqrt(dot(e, e)):
        advance(x, max(0.0, squeeze - t0), e)
        _restore(Q, b, rank, x, spans)
        return _accept(A, e, w, lorentz, x, ENDLESS), math.inf, x, y, 0.0
    # a start strictly inside the cones, as the interior-point method needs it: depth t0 + start > 0
    start = 1.0 / (steepest * max(1, lorentz)) - 1.5 * min(t0, 0.0)
    if t0 > 0.0:
        start = max(0.0, start - t0)
    advance(x, start, e)
    z, unit = np.empty(m), alpha / steepest  # of the objective, for an axis that moves by one
    tol, rows = GAP * min(alpha, 4.0 * unit), rank if apart else rank - 1
    dual, axis, c, zero, first = np.empty(rows), np.empty(0), Q[0], b[0], rank - rows
    if apart:  # t stays an unknown of its own, along the direction of a; else row 0 alone has to do with it
        axis = a[:rank] / alpha
        c, zero = _combine(Q, axis, spans, m), dot(axis, b[:rank])
    status, _ = minimise(
        Q[first:rank], b[first:rank], c, lorentz, x, dual, z, tol, zero - _ENDLESS_MARGIN * unit, zero,
        spans, axis,
    )  # fmt: skip
    _raise_apices(c, zero, alpha, e, x)
    _restore(Q, b, rank, x, spans)
    t = depth(x, e, lorentz)
    if status == UNBOUNDED:
        share = min(1.0, (squeeze - t0) / (t - t0)) if t > t0 else 1.0
        for i in range(m):
            x[i] = least_norm[i] + share * (x[i] - least_norm[i])
        return _accept(A, e, w, lorentz, x, ENDLESS), math.inf, x, y, 0.0
    if _accept(A, e, w, lorentz, x, FEASIBLE) == FEASIBLE:
        return FEASIBLE, t, x, y, 0.0
    _in_rows_of_q(axis, dual, alpha, h, full)
    pull_back(T, pivots, rank, full, y)
    reach = proof_reach(A, w, y, lorentz)
    return (INFEASIBLE if reach >= REACH else UNDECIDED), t, x, y, reach


@inline_kernel
def _combine(Q: FloatArray, weights: FloatArray, spans: IntArray | None, m: int) -> FloatArray:
    """Return Q' weights (m,)."""
    out = np.zeros(m)
    for j in range(weights.size):
        advance_span(out, weights[j], Q[j], spans, j)
    return out


@inline_kernel
def _in_rows_of_q(axis: FloatArray, dual: FloatArray, alpha: float, h: FloatArray, full: FloatArray) -> None:
    """Set `full` to the y with Q' y = z / alpha, so that (A e).y = 1; h reflects rows in one piece."""
    if axis.size > 0:
        for j in range(axis.size):
            full[j] = (axis[j] - dual[j]) / alpha
    else:
        full[0] = 1.0 / alpha
        for j in range(dual.size):
            full[j + 1] = -dual[j] / alpha
        reflect(h, dual.size + 1, full)


@inline_kernel
def _raise_apices(c: FloatArray, zero: float, alpha: float, e: FloatArray, x: FloatArray) -> None:
    """Turn x - t e, which misses c.x = zero by t alpha, into x; c and e (m,)."""
    t = zero
    for i in range(x.size):  # term by term, as in `_restore`
        t -= c[i] * x[i]
    advance(x, t / alpha, e)


@inline_kernel
def _accept(A: FloatArray, e: FloatArray, w: FloatArray, lorentz: int, x: FloatArray, outcome: int) -> int:
    """Return the outcome where x is in its cones and gives the load within `BAND`, else UNDECIDED."""
    good = _outside(x, e, lorentz) <= BAND and _left_over(A, w, x) <= BAND
    return outcome if good else UNDECIDED


@inline_kernel
def _restore(Q: FloatArray, b: FloatArray, rank: int, x: FloatArray, spans: IntArray | None) -> None:
    """Move x onto Q x = b by the shortest way: the equations then hold to rounding."""
    for j in range(rank):
        s = b[j]
        # term by term: a sum taken off at the end would lose the last digits
        for low, high in pieces(spans, j, x.size):
            for i in range(low, high):
                s -= Q[j, i] * x[i]
        advance_span(x, s, Q[j], spans, j)


@kernel
def _unreachable(
    T: FloatArray, pivots: IntArray, rank: int, w: FloatArray, row: FloatArray, y: FloatArray
) -> None:
    """Set y to a direction in which no contact force acts (A' y = 0) but the load does (y.w < 0)."""
    p = T.shape[0]
    worst = 0.0
    best = np.zeros(p)
    taken = np.zeros(p, dtype=np.bool_)
    for q in range(rank):
        taken[pivots[q]] = True
    for j in range(p):
        if taken[j]:  # it can be met alone
            continue
        for q in range(rank):
            # A row that depends on the pivots' rows, less its combination of them: zero on all contact
            # forces. What is left of w in it is a load that no force can meet; the row with most of it proves
            # best.
            row[q] = T[j, q]
        pull_back(T, pivots, rank, row, y)
        s = w[j]
        for q in range(p):
            s -= y[q] * w[q]
        if abs(s) > worst:
            worst = abs(s)
            sign = -1.0 if s > 0.0 else 1.0
            for q in range(p):
                best[q] = -sign * y[q]
            best[j] += sign
    for q in range(p):  # as a slice it would take 2 s to compile
        y[q] = best[q]
