"""Cholesky's factor of small definite matrices, in place in the lower triangle, and triangular solves."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel

VANISHED, HUGE = 1e-15, 1e100
"""A pivot below this share of its diagonal entry counts as zero; what takes its place, so that its unknown is
zero."""


@inline_kernel
def _remainder(A: FloatArray, i: int, j: int) -> float:
    """Return A[i, j] less the product of what rows i and j of the factor have before column j."""
    total: float = A[i, j]
    for k in range(j):
        total -= A[i, k] * A[j, k]
    return total


@inline_kernel
def _fill_column(A: FloatArray, j: int) -> None:
    """Set column j of the factor below its diagonal: by columns no entry waits for another."""
    for i in range(j + 1, A.shape[0]):
        A[i, j] = _remainder(A, i, j) / A[j, j]


@kernel
def cholesky(A: FloatArray) -> bool:
    """Replace the lower triangle of A (n, n) by its Cholesky factor; False if A is not positive definite."""
    for j in range(A.shape[0]):
        square = _remainder(A, j, j)
        # "not >" catches a NaN as well
        if not square > 0.0:
            return False
        A[j, j] = math.sqrt(square)
        _fill_column(A, j)
    return True


@inline_kernel
def solve_lower(L: FloatArray, x: FloatArray) -> None:
    """Replace x (n,) by L⁻¹ x, L lower triangular."""
    for i in range(x.size):
        total = x[i]
        for k in range(i):
            total -= L[i, k] * x[k]
        x[i] = total / L[i, i]


@inline_kernel
def solve_upper(L: FloatArray, x: FloatArray) -> None:
    """Replace x (n,) by L⁻ᵀ x, L lower triangular."""
    for i in range(x.size - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, x.size):
            total -= L[k, i] * x[k]
        x[i] = total / L[i, i]


@inline_kernel
def _subtract_row(B: FloatArray, i: int, s: float, k: int) -> None:
    if s != 0.0:  # factors of robots' matrices are full of zeros
        for j in range(B.shape[1]):
            B[i, j] -= s * B[k, j]


@inline_kernel
def _scale_row(B: FloatArray, i: int, s: float) -> None:
    for j in range(B.shape[1]):
        B[i, j] *= s


@kernel
def solve_columns(L: FloatArray, B: FloatArray) -> None:
    """Replace the columns of B (n, m) by those of (L Lᵀ)⁻¹ B, row by row."""
    n = L.shape[0]
    # rows of B lie side by side in memory: all columns advance together
    for i in range(n):
        for k in range(i):
            _subtract_row(B, i, L[i, k], k)
        _scale_row(B, i, 1.0 / L[i, i])
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            _subtract_row(B, i, L[k, i], k)
        _scale_row(B, i, 1.0 / L[i, i])


@kernel
def invert(L: FloatArray, half: FloatArray, out: FloatArray) -> None:
    """Fill the lower triangle of half (n, n) with L⁻¹, zeros above it, and out (n, n) with (L Lᵀ)⁻¹."""
    n = L.shape[0]
    for i in range(n):
        for j in range(n):
            half[i, j] = out[i, j] = 0.0
        for k in range(i):
            s = L[i, k]
            for j in range(k + 1):
                half[i, j] -= s * half[k, j]
        half[i, i] = 1.0
        s = 1.0 / L[i, i]
        for j in range(i + 1):
            half[i, j] *= s
    # (L Lᵀ)⁻¹ = L⁻ᵀ L⁻¹: the sum over rows k of L⁻¹ of its own outer products
    for k in range(n):
        for i in range(k + 1):
            s = half[k, i]
            for j in range(k + 1):
                out[i, j] += s * half[k, j]


@inline_kernel
def _add_four(x: FloatArray, B: FloatArray, k: int, s: float, t: float, u: float, v: float) -> None:
    for j in range(x.size):
        x[j] = x[j] + s * B[k, j] + t * B[k + 1, j] + u * B[k + 2, j] + v * B[k + 3, j]


@kernel
def product(A: FloatArray, B: FloatArray, out: FloatArray) -> None:
    """Set out (n, m) to A B, for small A (n, k) and B (k, m)."""
    whole = A.shape[1] // 4 * 4
    for i in range(A.shape[0]):
        for j in range(B.shape[1]):
            out[i, j] = 0.0
        for k in range(0, whole, 4):
            s, t, u, v = A[i, k], A[i, k + 1], A[i, k + 2], A[i, k + 3]
            if s != 0.0 or t != 0.0 or u != 0.0 or v != 0.0:
                _add_four(out[i], B, k, s, t, u, v)
        for k in range(whole, A.shape[1]):
            s = A[i, k]
            if s != 0.0:
                for j in range(B.shape[1]):
                    out[i, j] += s * B[k, j]
