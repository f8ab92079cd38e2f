"""LU factors that are kept: one elimination, many right-hand sides."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel


@kernel
def factor_lu(A: FloatArray, order: IntArray) -> bool:
    """Replace A (n, n) by its factors L U, rows pivoted into `order` (n,); return False for a zero pivot.

    Zeros at the ends of a pivot's row and column are passed over: blocks and bands cost what they hold.
    """
    n = order.size
    for k in range(n):
        pivot = low = k
        for i in range(k + 1, n):
            if A[i, k] != 0.0:
                low = i
                if abs(A[i, k]) > abs(A[pivot, k]):
                    pivot = i
        order[k] = pivot
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
    return True


@kernel
def apply_lu(A: FloatArray, order: IntArray, x: FloatArray) -> None:
    """Replace x (n,) by the solution of A y = x, from the factors of `factor_lu`."""
    n = order.size
    for k in range(n):
        if order[k] != k:
            x[k], x[order[k]] = x[order[k]], x[k]
    for i in range(n):
        total = x[i]
        for j in range(i):
            total -= A[i, j] * x[j]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i]
        for j in range(i + 1, n):
            total -= A[i, j] * x[j]
        x[i] = total / A[i, i]
