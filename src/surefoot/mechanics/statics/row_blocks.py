"""Rows of a cone program that touch few unknowns each: blocks of them, and the border that touches all.

A bound on one contact's force is a row among that contact's unknowns and its own slack. Rows of different
contacts have no unknown in common, so that their products are zero: with the blocks first and the border (the
wrench) last, A D A' and its factor are blocks beside a border, and cost as much as there are contacts.

The span of a row j is (first, a, b, c, d): it touches columns a to b and c to d, and rows from `first` on.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import HUGE, VANISHED
from surefoot.base.numerics.orthogonal import orthonormal_rows, scale_row
from surefoot.base.numerics.vectors import advance, dot

IN_ONE = None
"""No blocks, and no spans: rows are in one piece, and kernels are compiled for that."""
MANY = 32
"""Rows from which on blocks are looked for: fewer cost less in one piece."""


def find_blocks(rows: FloatArray, unit: int) -> tuple[IntArray, IntArray]:
    """Group rows (l, m) by the columns that they touch, those in an interval of their own together.

    Parameters
    ----------
    rows
        Each with a slack of its own besides.
    unit
        How many columns belong together: those of one cone.

    Returns
    -------
    tuple[IntArray, IntArray]
        The order (l,) that brings groups together, rows that touch more than half of the columns first; and
        groups (g, 6): rows from and to, columns from and to, slacks from and to, all counted in that order.
    """
    count, m = rows.shape
    if count < MANY:
        return np.arange(count), np.zeros((0, 6), dtype=np.int64)
    touched = rows != 0.0
    some = touched.any(axis=1)
    low = np.where(some, touched.argmax(axis=1) // unit * unit, 0)
    high = np.where(some, -(-(m - touched[:, ::-1].argmax(axis=1)) // unit) * unit, 0)
    # A row over most of the columns (a sum of all normal forces) would tie all blocks together: it joins the
    # border.
    wide = 2 * (high - low) > m
    order = np.lexsort((low, ~wide))
    groups: list[list[int]] = []
    for at in range(int(wide.sum()), count):
        a, b = int(low[order[at]]), int(high[order[at]])
        if groups and a < groups[-1][3]:
            groups[-1][1], groups[-1][3] = at + 1, max(b, groups[-1][3])
        else:
            groups.append([at, at + 1, a, b])
    return order, np.array([[*g, g[0], g[1]] for g in groups], dtype=np.int64).reshape(-1, 6)


@inline_kernel
def first_row(spans: IntArray | None, j: int) -> int:
    """Return the row from which on row j touches others; `spans` (m, 6), None for rows in one piece."""
    return 0 if spans is None else spans[j, 0]


@inline_kernel
def pieces(spans: IntArray | None, j: int, m: int) -> tuple[tuple[int, int], ...]:
    """Return from where to where row j touches columns, m in all; `spans` (m, 6), None for all of them."""
    # 0 m is no literal: both are of one type
    return ((0 * m, m), (m, m)) if spans is None else ((spans[j, 1], spans[j, 2]), (spans[j, 3], spans[j, 4]))


@inline_kernel
def dot_span(u: FloatArray, v: FloatArray, spans: IntArray | None, j: int) -> float:
    """Return u . v over the columns of row j, u and v (m,)."""
    if spans is None:
        return float(dot(u, v))
    total = 0.0
    for low, high in pieces(spans, j, u.size):
        for i in range(low, high):
            total += u[i] * v[i]
    return total


@inline_kernel
def advance_span(u: FloatArray, t: float, v: FloatArray, spans: IntArray | None, j: int) -> None:
    """Add t v to u over the columns of row j, u and v (m,)."""
    if spans is None:
        advance(u, t, v)
        return
    for low, high in pieces(spans, j, u.size):
        for i in range(low, high):
            u[i] += t * v[i]


@inline_kernel
def _touch_all(spans: IntArray, m: int, low: int) -> None:
    """Set spans (p, 5) from `low` on to those of rows that touch all m columns and all rows."""
    for j in range(low, spans.shape[0]):
        spans[j, 0] = spans[j, 1] = 0
        spans[j, 2] = spans[j, 3] = spans[j, 4] = m


@kernel
def orthonormal_blocks(
    A: FloatArray, blocks: IntArray | None, Q: FloatArray, T: FloatArray, pivots: IntArray,
    spans: IntArray | None,
) -> int:  # fmt: skip
    """Factor A = T Q as `orthonormal_rows` does, with the rows of each block in that block's span.

    Parameters
    ----------
    A
        (p, m), the border's rows first.
    blocks
        (g, 6): rows from and to, columns from and to, columns of slacks from and to. None: all in one piece.
    Q, T, pivots, spans
        (p, m), (p, p), (p,), (p, 5): outputs, blocks first and the border last; no spans without blocks.

    Returns
    -------
    int
        The rank. Rows are in one piece, with nothing in blocks (`local_rows`), where there are no blocks or
        the rows of one depend on each other, so that its own factor would not do.
    """
    if blocks is None or spans is None:
        return orthonormal_rows(A, Q, T, pivots)
    T[:, :] = 0.0
    Q[:, :] = 0.0
    rank = 0
    for g in range(blocks.shape[0]):
        top, a, b, c, d = blocks[g, 0], blocks[g, 2], blocks[g, 3], blocks[g, 4], blocks[g, 5]
        count = blocks[g, 1] - top
        part = np.zeros((count, b - a + d - c))
        for j in range(count):
            for i in range(a, b):
                part[j, i - a] = A[top + j, i]
            for i in range(c, d):
                part[j, b - a + i - c] = A[top + j, i]
        q, t, at = np.empty_like(part), np.empty((count, count)), np.empty(count, dtype=np.int64)
        # Rows of a block that depend on each other may still hold as a whole, with the border: only the
        # factor in one piece can tell.
        if orthonormal_rows(part, q, t, at) < count:
            _touch_all(spans, A.shape[1], 0)
            return orthonormal_rows(A, Q, T, pivots)
        for k in range(count):
            row = rank + k
            for i in range(a, b):
                Q[row, i] = q[k, i - a]
            for i in range(c, d):
                Q[row, i] = q[k, b - a + i - c]
            for j in range(count):
                T[top + j, row] = t[j, k]
            pivots[row] = top + at[k]
            spans[row, 0], spans[row, 1], spans[row, 2], spans[row, 3], spans[row, 4] = rank, a, b, c, d
        rank += count
    return rank + _border(A, rank, Q, T, pivots, spans)


@inline_kernel
def _border(
    A: FloatArray, local: int, Q: FloatArray, T: FloatArray, pivots: IntArray, spans: IntArray
) -> int:
    """Factor the rows of A that are in no block, after the `local` rows of the blocks; return their rank."""
    p, m = A.shape
    head = p - local
    rest = np.zeros((head, m))
    for j in range(head):
        for i in range(m):
            rest[j, i] = A[j, i]
        for _ in range(2):  # Gram-Schmidt, twice against rounding
            for k in range(local):
                s = dot_span(rest[j], Q[k], spans, k)
                advance_span(rest[j], -s, Q[k], spans, k)
                T[j, k] += s
    q, t, at = np.empty_like(rest), np.empty((head, head)), np.empty(head, dtype=np.int64)
    more = orthonormal_rows(rest, q, t, at)
    for n in range(more):
        # What rounding has left along the blocks' rows is taken out once more, and the length restored.
        row = local + n
        for k in range(local):
            advance_span(q[n], -dot_span(q[n], Q[k], spans, k), Q[k], spans, k)
        size = 0.0
        for i in range(m):
            size += q[n, i] * q[n, i]
        scale_row(q, n, math.sqrt(size))
        for i in range(m):
            Q[row, i] = q[n, i]
        for j in range(head):
            T[j, row] = t[j, n]
        pivots[row] = at[n]
    _touch_all(spans, m, local)
    return more


@inline_kernel
def local_rows(spans: IntArray | None) -> int:
    """Return how many rows of (rows, 5) spans are in blocks: those with their own slacks."""
    count = 0
    while spans is not None and count < spans.shape[0] and spans[count, 3] < spans[count, 4]:
        count += 1
    return count


@inline_kernel
def _reduce_entry(A: FloatArray, i: int, j: int, spans: IntArray | None) -> float:
    """Return A[i, j] less the product of what rows i and j of the factor have before column j."""
    total: float = A[i, j]
    for k in range(max(first_row(spans, i), first_row(spans, j)), j):
        total -= A[i, k] * A[j, k]
    return total


@inline_kernel
def guarded_cholesky(A: FloatArray, spans: IntArray | None, low: int, high: int) -> float:
    """Factor columns `low` to `high` of a semidefinite A (n, n), in its lower triangle, those before done.

    Pivots that vanish are made huge; entries before a row's first one are zero and are not read. Returns the
    least share of its diagonal entry that a pivot has kept (1 for no rows), NaN where A is not finite.
    """
    least = 1.0
    for j in range(low, high):
        top, square = A[j, j], _reduce_entry(A, j, j, spans)
        if not math.isfinite(square):
            return math.nan
        # The share of its diagonal that a pivot keeps tells how many digits cancellation has left it.
        if square < least * top:
            least = square / top
        # A row that depends on those before gives no equation of its own: a huge pivot makes its multiplier
        # zero.
        A[j, j] = math.sqrt(square) if square > VANISHED * top else HUGE
        for i in range(j + 1, A.shape[0]):
            if first_row(spans, i) <= j:
                A[i, j] = _reduce_entry(A, i, j, spans) / A[j, j]
    return least


@inline_kernel
def _free_share(
    L: FloatArray, spans: IntArray | None, axis: FloatArray, free: FloatArray, j: int, low: int
) -> float:
    """Return entry j of `axis` less what the factor's rows before `low` account for."""
    total: float = axis[j]
    for k in range(first_row(spans, j), low):
        total -= L[j, k] * free[k]
    return total


@inline_kernel
def factor(M: FloatArray, spans: IntArray | None, axis: FloatArray, free: FloatArray) -> float:
    """Factor M (r, r), and with it the unknown along `axis` (r,), if any; return the least share kept.

    M u + axis t = v, axis.u = 0: M alone is nearly singular close to a solution. The blocks L L' are taken
    out first, then t, whose pivot is -|L^-1 axis|^2, and the border last, which t makes definite. `free`
    (r + 1,) keeps what t has to do with every row, and its pivot; (0,) without an axis.
    """
    r, pivot = M.shape[0], 0.0
    if axis.size == 0:
        return float(guarded_cholesky(M, spans, 0, r))
    # Elimination by blocks, then t, then the border. Blocks first keeps them sparse; t before the border
    # makes the border's nearly singular Schur complement definite, by + free freeᵀ / |free|².
    local = local_rows(spans)
    kept = guarded_cholesky(M, spans, 0, local)
    for j in range(local):
        free[j] = _free_share(M, spans, axis, free, j, j) / M[j, j]
        pivot += free[j] * free[j]
    for j in range(local, r):
        free[j] = _free_share(M, spans, axis, free, j, local)
        for q in range(local, j + 1):
            M[j, q] += free[j] * free[q] / pivot
    free[r] = pivot
    other = guarded_cholesky(M, spans, local, r)
    return float(other) if math.isnan(other) else min(float(kept), float(other))


@inline_kernel
def _remove(rows: FloatArray, M: FloatArray, spans: IntArray | None, j: int, low: int, high: int) -> None:
    """Take what lies along rows `low` to `high` out of row j, twice against rounding, and note it in M."""
    last = rows.shape[1] - 1
    for _ in range(2):
        for k in range(low, high):
            s = dot_span(rows[k], rows[j], spans, k) + rows[k, last] * rows[j, last]
            advance_span(rows[j], -s, rows[k], spans, k)
            rows[j, last] -= s * rows[k, last]
            M[j, k] += s


@inline_kernel
def factor_rows(
    BW: FloatArray, M: FloatArray, spans: IntArray | None, axis: FloatArray, free: FloatArray
) -> None:
    """Set the lower triangle of M (r, r) to the factor L of BW = L rows, both (r, m); `free` as in `factor`.

    The same as Cholesky's gives, to twice its digits: near the cones' boundary the products in M lose half.
    """
    (r, m), local, pivot = BW.shape, local_rows(spans), 0.0
    rows = np.empty((r, m + 1))
    for j in range(r):
        first = first_row(spans, j)
        for a, b in pieces(spans, j, m):
            for i in range(a, b):
                rows[j, i] = BW[j, i]
        rows[j, m], top = 0.0, dot_span(BW[j], BW[j], spans, j)
        for k in range(first, j):
            M[j, k] = 0.0
        _remove(rows, M, spans, j, first, min(j, local))
        if axis.size > 0 and j >= local:  # one more column: the unknown's along the axis
            free[j] = _free_share(M, spans, axis, free, j, local)
            rows[j, m] = free[j] / math.sqrt(pivot)
            top += rows[j, m] ** 2
        _remove(rows, M, spans, j, max(local, first), j)
        size = math.sqrt(dot_span(rows[j], rows[j], spans, j) + rows[j, m] ** 2)
        # a row that depends on those before carries no new equation: a huge pivot drops it
        M[j, j] = size if size > 1e-14 * math.sqrt(top) else HUGE
        for a, b in pieces(spans, j, m):
            for i in range(a, b):
                rows[j, i] /= M[j, j]
        rows[j, m] /= M[j, j]
        if axis.size > 0 and j < local:
            free[j] = _free_share(M, spans, axis, free, j, j) / M[j, j]
            pivot += free[j] * free[j]
    if axis.size > 0:
        free[r] = pivot


@inline_kernel
def solve_factored(L: FloatArray, v: FloatArray, spans: IntArray | None, free: FloatArray) -> None:
    """Replace v (r,) by the solution u of M u + axis t = v, axis.u = 0, or of M u = v without an axis."""
    # Forward through blocks, t and border, then backward through border, t and blocks; `across` over the
    # pivot of t is t itself, once the border's part is in it.
    r, local, across = v.size, local_rows(spans), 0.0
    for i in range(r):
        total = v[i]
        if free.size > 0 and i >= local:
            total -= free[i] * across / free[r]
        for k in range(first_row(spans, i), i):
            total -= L[i, k] * v[k]
        v[i] = total / L[i, i]
        if free.size > 0 and i < local:
            across += free[i] * v[i]
    for i in range(r - 1, -1, -1):
        if free.size > 0 and i == local - 1:  # the border is known, and with it t
            for j in range(local, r):
                across += free[j] * v[j]
            for j in range(local):
                v[j] -= free[j] * across / free[r]
        total = v[i]
        for k in range(i + 1, r):
            if first_row(spans, k) <= i:
                total -= L[k, i] * v[k]
        v[i] = total / L[i, i]
