"""Orthonormal rows: Gram-Schmidt, done twice against rounding, with the rank; reflections.

A stance's equations come to this form before any question to it: two feet have rank five (no moment about the
line through them), one point has rank three, and a load outside the rows' range can never be carried.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import advance, dot

RANK_TOLERANCE = 1e-10
"""Share of a row that must be independent of the others for the row to count."""


@inline_kernel
def remove_rows(Q: FloatArray, k: int, shares: FloatArray, passes: int = 2) -> float:
    """Take what lies along the rows before k, orthonormal, out of row k of Q; return the length that is left.

    Adds what each took to `shares` (k or more,). The second pass takes out what rounding left of the first.
    """
    row = Q[k]
    for _ in range(passes):
        for j in range(k):
            s = dot(Q[j], row)
            advance(row, -s, Q[j])
            shares[j] += s
    return math.sqrt(dot(row, row))


@inline_kernel
def scale_row(Q: FloatArray, k: int, size: float) -> None:
    """Divide row k of Q (p, m) by `size`."""
    for i in range(Q.shape[1]):
        Q[k, i] /= size


@kernel
def orthonormal_rows(A: FloatArray, Q: FloatArray, T: FloatArray, pivots: IntArray) -> int:
    """Factor A = T Q with orthonormal rows Q, by Gram-Schmidt with row pivoting, twice.

    Parameters
    ----------
    A
        (p, m), rows of comparable size.
    Q, T, pivots
        (p, m), (p, p), (p,): outputs; the first `rank` rows of Q, columns of T and entries of pivots
        count. T[pivots] is lower triangular.

    Returns
    -------
    int
        The rank.
    """
    p: int = A.shape[0]
    rest = A.copy()
    first, spare = np.empty(p), np.zeros(p)
    taken = np.zeros(p, dtype=np.bool_)
    T[:, :] = 0.0
    for j in range(p):
        first[j] = math.sqrt(dot(A[j], A[j]))
    for k in range(p):
        # the row with most left comes next: small pivots would make Q of rounding
        best, at = -1.0, -1
        for j in range(p):
            s = -1.0 if taken[j] else dot(rest[j], rest[j])
            if s > best:
                best, at = s, j
        length = math.sqrt(best)
        # what is left of every row is rounding: the rank is reached
        if length <= RANK_TOLERANCE * first[at] or length <= RANK_TOLERANCE * 1e-3:
            return k
        for i in range(A.shape[1]):
            Q[k, i] = rest[at, i] / length
        scale_row(Q, k, remove_rows(Q, k, spare, 1))  # once more, against rounding
        pivots[k] = at
        taken[at] = True
        for j in range(p):
            # modified Gram-Schmidt: every row that is left loses its part at once
            s = dot(rest[j], Q[k])
            T[j, k] = s if not taken[j] or j == at else 0.0
            if not taken[j]:
                advance(rest[j], -s, Q[k])
    return p


@kernel
def coordinates(T: FloatArray, pivots: IntArray, rank: int, w: FloatArray, out: FloatArray) -> float:
    """Solve T out = w (p,) on the pivot rows, out (rank,); return the largest violation on the other rows.

    The violation is how far w is outside the range of A, in the units of w.
    """
    p = T.shape[0]
    for k in range(rank):
        s = w[pivots[k]]
        for q in range(k):
            s -= T[pivots[k], q] * out[q]
        out[k] = s / T[pivots[k], k]
    # rows that are no pivots depend on them: what they contradict no unknown can answer
    worst = 0.0
    for j in range(p):
        s = w[j]
        for q in range(rank):
            s -= T[j, q] * out[q]
        worst = max(worst, abs(s))
    return worst


@kernel
def pull_back(T: FloatArray, pivots: IntArray, rank: int, y: FloatArray, out: FloatArray) -> None:
    """Find u (p,) with Aᵀ u = Qᵀ y, y (rank,): zero off the pivot rows, back substitution on them."""
    for k in range(out.size):
        out[k] = 0.0
    for k in range(rank - 1, -1, -1):
        s = y[k]
        for q in range(k + 1, rank):
            s -= T[pivots[q], k] * out[pivots[q]]
        out[pivots[k]] = s / T[pivots[k], k]


@kernel
def turn_first_row(Q: FloatArray, rank: int, a: FloatArray, h: FloatArray, b: FloatArray) -> float:
    """Reflect the rows of Q (and b) so that the row-space vector a points along the first row.

    h (rank,) receives the reflector (I - 2 h h'), zero for none; returns the length of a with the sign
    that the first coordinate gets: it is always >= 0.
    """
    length = 0.0
    for j in range(rank):
        length += a[j] * a[j]
    length = math.sqrt(length)
    for j in range(rank):
        h[j] = 0.0
    if length == 0.0:
        return 0.0
    size = 0.0
    for j in range(rank):
        h[j] = a[j] / length
    # the reflector of a / ||a|| and e_1: h = (a / ||a|| - e_1) / || · || (Householder)
    h[0] -= 1.0
    for j in range(rank):
        size += h[j] * h[j]
    # it points there already
    if size < 1e-30:
        for j in range(rank):
            h[j] = 0.0
        return length
    size = 1.0 / math.sqrt(size)
    for j in range(rank):
        h[j] *= size
    for i in range(Q.shape[1]):
        s = 0.0
        for j in range(rank):
            s += h[j] * Q[j, i]
        for j in range(rank):
            Q[j, i] -= 2.0 * s * h[j]
    reflect(h, rank, b)
    return length


@kernel
def reflect(h: FloatArray, rank: int, v: FloatArray) -> None:
    """Apply I - 2 h hᵀ, h (rank,), to the first `rank` entries of v, in place (its own inverse)."""
    s = 0.0
    for j in range(rank):
        s += h[j] * v[j]
    for j in range(rank):
        v[j] -= 2.0 * s * h[j]
