"""LU factors that are kept: one elimination, many right-hand sides."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel

KEPT = 1e-3
"""Share of the largest entry of its column at which a diagonal entry stays the pivot [-]: an exchange of rows
fills zeros. SuperLU's default for matrices of symmetric pattern."""


@inline_kernel
def _eliminate(A: FloatArray, k: int, low: int) -> None:
    """Take pivot k out of the rows above it, from `low` on; zeros at the row's beginning are passed over."""
    inverse, first = 1.0 / A[k, k], 0
    while first < k and A[k, first] == 0.0:
        first += 1
    for i in range(low, k):
        share = A[i, k] * inverse
        A[i, k] = share
        if share != 0.0:
            for j in range(first, k):
                A[i, j] -= share * A[k, j]


@kernel
def eliminate_last(A: FloatArray, kept: int) -> bool:
    """Replace A (n, n) by the factors of its columns from `kept` on, before them their Schur complement.

    Nothing is exchanged; False where a pivot is small beside its column.
    """
    for k in range(A.shape[0] - 1, kept - 1, -1):
        low, most = k, 0.0
        for i in range(k - 1, -1, -1):
            if A[i, k] != 0.0:
                low, most = i, max(most, abs(A[i, k]))
        if not (abs(A[k, k]) > 0.0 and abs(A[k, k]) >= KEPT * most):
            return False
        _eliminate(A, k, low)
    return True


@kernel
def factor_lu(A: FloatArray, order: IntArray) -> bool:
    """Replace A (n, n) by its factors U L, from the last pivot on; return False for a zero pivot.

    Rows of `order` (3, n): the row that each was exchanged with, the first row of each column of U, the last
    of each of L.
    Zeros at the ends of a pivot's row and column are passed over: blocks and bands cost what they hold, and
    trees whose parents come first, as joints of robots do, fill no zero.
    """
    n = A.shape[0]
    for k in range(n - 1, -1, -1):
        pivot = low = k
        for i in range(k - 1, -1, -1):
            if A[i, k] != 0.0:
                low = i
                if abs(A[i, k]) > abs(A[pivot, k]):
                    pivot = i
        if not abs(A[pivot, k]) > 0.0:
            return False
        if abs(A[k, k]) >= KEPT * abs(A[pivot, k]):
            pivot = k
        order[0, k] = pivot
        if pivot != k:
            for j in range(n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        _eliminate(A, k, low)
    for k in range(n):
        low, high = 0, n - 1
        while low < k and A[low, k] == 0.0:
            low += 1
        while high > k and A[high, k] == 0.0:
            high -= 1
        order[1, k], order[2, k] = low, high
    return True


@kernel
def apply_lu(A: FloatArray, order: IntArray, x: FloatArray) -> None:
    """Replace x (n,) by the solution of A y = x, from the factors of `factor_lu`."""
    n = x.size
    for k in range(n - 1, -1, -1):
        if order[0, k] != k:
            x[k], x[order[0, k]] = x[order[0, k]], x[k]
    # column by column: sums along rows would wait for each addition
    for k in range(n - 1, -1, -1):
        if x[k] != 0.0:
            for i in range(order[1, k], k):
                x[i] -= A[i, k] * x[k]
    for k in range(n):
        x[k] /= A[k, k]
        if x[k] != 0.0:
            for i in range(k + 1, order[2, k] + 1):
                x[i] -= A[i, k] * x[k]
