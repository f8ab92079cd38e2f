"""Dense linear systems of a few dozen unknowns, inside kernels: a call into LAPACK would take longer."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel

PAIRED = 24
"""Equations from which on an elimination takes two columns at a time."""


@inline_kernel
def _back_substitute(A: FloatArray, b: FloatArray, m: int) -> None:
    """Solve with the upper triangle of A in place."""
    for k in range(m - 1, -1, -1):  # column by column: what waits for an unknown is one product, not a sum
        x = b[k] / A[k, k]
        b[k] = x
        for i in range(k):
            b[i] -= A[i, k] * x


@kernel
def symmetric_solve(A: FloatArray, b: FloatArray, m: int) -> bool:
    """Solve A x = b with a positive definite A (m, m) in place (x in b (m,)); False if it is not.

    Elimination on the upper half, two columns at a time, without pivoting.
    """
    for k in range(0, m, 2):
        if not A[k, k] > 0.0:
            return False
        if k + 1 == m:
            break
        # two pivots before the rows below are touched: they are read and written half as often
        first = 1.0 / A[k, k]
        factor = A[k, k + 1] * first
        for j in range(k + 1, m):
            A[k + 1, j] -= factor * A[k, j]
        b[k + 1] -= factor * b[k]
        if not A[k + 1, k + 1] > 0.0:
            return False
        second = 1.0 / A[k + 1, k + 1]
        for i in range(k + 2, m):
            p, q = A[k, i] * first, A[k + 1, i] * second
            for j in range(i, m):
                A[i, j] -= p * A[k, j] + q * A[k + 1, j]
            b[i] -= p * b[k] + q * b[k + 1]
    _back_substitute(A, b, m)
    return True


@inline_kernel
def _pivot(A: FloatArray, b: FloatArray, k: int, m: int, first: int) -> bool:
    """Bring the largest entry of column k to its diagonal, rows from `first` on; False if all are zero."""
    pivot, best = k, abs(A[k, k])
    for i in range(k + 1, m):
        size = abs(A[i, k])
        more = size > best  # a choice of values, not a branch: nobody can predict it
        pivot, best = i if more else pivot, size if more else best
    if not best > 0.0:
        return False
    if pivot != k:
        for j in range(first, m):
            A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        b[k], b[pivot] = b[pivot], b[k]
    return True


@kernel
def _lu_small(A: FloatArray, b: FloatArray, m: int) -> bool:
    for k in range(m):
        if not _pivot(A, b, k, m, k):
            return False
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, m):
            p = A[i, k] * inverse
            if p != 0.0:
                for j in range(k + 1, m):
                    A[i, j] -= p * A[k, j]
                b[i] -= p * b[k]
    _back_substitute(A, b, m)
    return True


@kernel
def _lu_pairs(A: FloatArray, b: FloatArray, m: int) -> bool:
    """Eliminate two columns at a time: half as often through the matrix."""
    for k in range(0, m, 2):
        if not _pivot(A, b, k, m, k):
            return False
        if k + 1 == m:
            break
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, m):
            # the second column must be up to date before its pivot is chosen
            A[i, k] *= inverse
            A[i, k + 1] -= A[i, k] * A[k, k + 1]
        if not _pivot(A, b, k + 1, m, k):
            return False
        inverse = 1.0 / A[k + 1, k + 1]
        factor = A[k + 1, k]
        for j in range(k + 2, m):
            A[k + 1, j] -= factor * A[k, j]
        b[k + 1] -= factor * b[k]
        for i in range(k + 2, m):
            p, q = A[i, k], A[i, k + 1] * inverse
            if p != 0.0 or q != 0.0:
                for j in range(k + 2, m):
                    A[i, j] -= p * A[k, j] + q * A[k + 1, j]
                b[i] -= p * b[k] + q * b[k + 1]
    _back_substitute(A, b, m)
    return True


@kernel
def lu_solve(A: FloatArray, b: FloatArray, m: int) -> bool:
    """Solve A x = b, A (m, m), in place (x in b (m,)), pivoting rows; return False for a zero pivot."""
    return _lu_small(A, b, m) if m < PAIRED else _lu_pairs(A, b, m)


@kernel
def lu_solve_many(A: FloatArray, B: FloatArray, m: int) -> bool:
    """Solve m equations A X = B for all columns of B (m, c) in place; False for a zero pivot."""
    for k in range(m):
        pivot = k
        for i in range(k + 1, m):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        # zero, or not a number
        if not abs(A[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for j in range(k, m):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            for j in range(B.shape[1]):
                B[k, j], B[pivot, j] = B[pivot, j], B[k, j]
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, m):
            p = A[i, k] * inverse
            if p != 0.0:
                for j in range(k + 1, m):
                    A[i, j] -= p * A[k, j]
                for j in range(B.shape[1]):
                    B[i, j] -= p * B[k, j]
    for k in range(m - 1, -1, -1):
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, m):
            p = A[k, i]
            for j in range(B.shape[1]):
                B[k, j] -= p * B[i, j]
        for j in range(B.shape[1]):
            B[k, j] *= inverse
    return True


@inline_kernel
def invert_shifted(G: FloatArray, shift: float, out: FloatArray) -> None:
    """Fill out (m, m) with the inverse of a definite G + shift I, by Gauss-Jordan on its diagonal."""
    m = G.shape[0]
    for i in range(m):
        for j in range(m):
            out[i, j] = G[i, j]
        out[i, i] += shift
    for k in range(m):
        # without pivoting: the diagonal of a definite matrix serves
        pivot = 1.0 / out[k, k]
        out[k, k] = 1.0
        for j in range(m):
            out[k, j] *= pivot
        for i in range(m):
            factor = out[i, k]
            if i != k and factor != 0.0:
                out[i, k] = 0.0
                for j in range(m):
                    out[i, j] -= factor * out[k, j]
