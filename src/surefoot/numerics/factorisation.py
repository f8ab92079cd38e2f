"""Factors of dense definite matrices of a hundred unknowns, inside kernels; smaller ones: `elimination`."""

from __future__ import annotations

from surefoot.arrays import FloatArray
from surefoot.kernels import kernel


@kernel
def factor(U: FloatArray) -> None:
    """Factor a definite (n, n) matrix (upper triangle), in place, as Uᵀ D⁻¹ U, D its diagonal.

    Four pivots at a time, so that each row is read and written a quarter as often.
    """
    n = U.shape[0]
    k = 0
    while k + 4 <= n:
        a, b, c, d = U[k], U[k + 1], U[k + 2], U[k + 3]
        # the four pivot rows among themselves ...
        p = 1.0 / a[k]
        s = a[k + 1] * p
        for j in range(k + 1, n):
            b[j] -= s * a[j]
        q = 1.0 / b[k + 1]
        s, t = a[k + 2] * p, b[k + 2] * q
        for j in range(k + 2, n):
            c[j] -= s * a[j] + t * b[j]
        r = 1.0 / c[k + 2]
        s, t, u = a[k + 3] * p, b[k + 3] * q, c[k + 3] * r
        for j in range(k + 3, n):
            d[j] -= s * a[j] + t * b[j] + u * c[j]
        w = 1.0 / d[k + 3]
        # ... then all rows below, in one pass
        for i in range(k + 4, n):
            row = U[i]
            s, t, u, v = a[i] * p, b[i] * q, c[i] * r, d[i] * w
            for j in range(i, n):
                row[j] -= s * a[j] + t * b[j] + u * c[j] + v * d[j]
        k += 4
    # what is left of four
    for m in range(k, n - 1):
        a = U[m]
        p = 1.0 / a[m]
        for i in range(m + 1, n):
            row = U[i]
            s = a[i] * p
            for j in range(i, n):
                row[j] -= s * a[j]


@kernel
def solve_factored(U: FloatArray, x: FloatArray) -> None:
    """Solve with the (n, n) matrix that `factor` factored; x (n,) is the right side, then the solution."""
    n = x.size
    for k in range(n):
        row = U[k]
        s = x[k] / row[k]
        for j in range(k + 1, n):
            x[j] -= s * row[j]
    for k in range(n - 1, -1, -1):
        row = U[k]
        s = x[k]
        for j in range(k + 1, n):
            s -= row[j] * x[j]
        x[k] = s / row[k]
