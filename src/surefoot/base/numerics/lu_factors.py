"""LU factors that are kept: one elimination, many right-hand sides."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel


@kernel
def factor_lu(A: FloatArray, order: IntArray) -> bool:
    """Replace A (n, n) by its factors L U, and fill `order` (3, n); return False for a zero pivot.

    Its rows: the row that each was exchanged with, the last row of each column of L, the first of each of U.
    Zeros at the ends of a pivot's row and column are passed over: blocks and bands cost what they hold.
    """
    n = A.shape[0]
    for k in range(n):
        pivot = low = k
        for i in range(k + 1, n):
            if A[i, k] != 0.0:
                low = i
                if abs(A[i, k]) > abs(A[pivot, k]):
                    pivot = i
        order[0, k] = pivot
        if not abs(A[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for j in range(n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        inverse, far = 1.0 / A[k, k], n
        while far > k + 1 and A[k, far - 1] == 0.0:
            far -= 1
        for i in range(k + 1, low + 1):
            share = A[i, k] * inverse
            A[i, k] = share
            if share != 0.0:
                for j in range(k + 1, far):
                    A[i, j] -= share * A[k, j]
    for k in range(n):
        low, high = n - 1, 0
        while low > k and A[low, k] == 0.0:
            low -= 1
        while high < k and A[high, k] == 0.0:
            high += 1
        order[1, k], order[2, k] = low, high
    return True


@kernel
def apply_lu(A: FloatArray, order: IntArray, x: FloatArray) -> None:
    """Replace x (n,) by the solution of A y = x, from the factors of `factor_lu`."""
    n = x.size
    for k in range(n):
        if order[0, k] != k:
            x[k], x[order[0, k]] = x[order[0, k]], x[k]
    # column by column: sums along rows would wait for each addition
    for k in range(n):
        if x[k] != 0.0:
            for i in range(k + 1, order[1, k] + 1):
                x[i] -= A[i, k] * x[k]
    for k in range(n - 1, -1, -1):
        x[k] /= A[k, k]
        if x[k] != 0.0:
            for i in range(order[2, k], k):
                x[i] -= A[i, k] * x[k]
