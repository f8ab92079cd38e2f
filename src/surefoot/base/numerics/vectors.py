"""Vectors: three numbers in registers, or arrays of any length."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.kernels import inline_kernel, kernel, releasing_kernel

Three = tuple[float, float, float]
_FLOAT = np.dtype(np.float64)
_SQUARED_LEAST = 1e-146
"""The least length whose square keeps all digits [-]."""


@inline_kernel
def cross(a: Three, b: Three) -> Three:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inline_kernel
def times(A: FloatArray, v: Three) -> Three:
    """Return A v for A (3, 3)."""
    return (
        A[0, 0] * v[0] + A[0, 1] * v[1] + A[0, 2] * v[2],
        A[1, 0] * v[0] + A[1, 1] * v[1] + A[1, 2] * v[2],
        A[2, 0] * v[0] + A[2, 1] * v[1] + A[2, 2] * v[2],
    )


def planar_lengths(vectors: FloatArray) -> FloatArray:
    """Return sqrt(x^2 + y^2) of the first two of (T, p, k) components: (T, p), at any size."""
    out = np.empty(vectors.shape[:2])
    _planar_lengths(vectors, out)
    return out


@releasing_kernel
def _planar_lengths(vectors: FloatArray, out: FloatArray) -> None:
    """Fill out (T, p) with what `planar_lengths` returns."""
    for t in range(out.shape[0]):
        for k in range(out.shape[1]):
            x, y = vectors[t, k, 0], vectors[t, k, 1]
            size = math.sqrt(x * x + y * y)
            if not _SQUARED_LEAST < size < math.inf:  # the squares leave the range of doubles
                size = math.hypot(x, y)
            out[t, k] = size


@inline_kernel
def dot(x: FloatArray, y: FloatArray) -> float:
    """Return x . y for arrays (n,)."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@inline_kernel
def advance(x: FloatArray, t: float, d: FloatArray) -> None:
    """Add t d to x (n,)."""
    for i in range(x.size):
        x[i] += t * d[i]


@kernel
def largest(x: FloatArray) -> float:
    """Return the largest magnitude in x (n,), in any unit, infinity where an entry is not a number."""
    out = 0.0
    for i in range(x.size):
        # Not `>`: NaN compares false with everything, and has to count as the largest.
        if not abs(x[i]) <= out:
            out = abs(x[i]) if abs(x[i]) < np.inf else np.inf
    return out


def finite_vector(name: str, value: FloatArray, size: int) -> FloatArray:
    """Return a finite (size,) array, in any unit; the fast way in for what is one already."""
    if (
        type(value) is np.ndarray
        and value.dtype == _FLOAT
        and value.shape == (size,)
        and largest(value) < np.inf
    ):
        return value
    return finite_array(name, value, (size,))
