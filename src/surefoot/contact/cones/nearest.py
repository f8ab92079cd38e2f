"""The nearest point of a cone that is given by rays: non-negative least squares.

C. L. Lawson, L. J. Hanson, "Solving Least Squares Problems" (1974), chapter 23, with the passive columns
kept orthonormal by Gram-Schmidt, twice. Written here because SciPy's `nnls` (seen with 1.17.1) can
stop at a wrong point where x is on the cone's boundary, which is where projections end.

Limits: dense, one point after the other; columns that depend on the passive ones to 1e-11 are passed
over.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import solve_upper
from surefoot.base.numerics.orthogonal import remove_rows, scale_row
from surefoot.base.numerics.vectors import dot

_DEPENDENT = 1e-11


@kernel
def nearest_points(rays: FloatArray, points: FloatArray, out: FloatArray) -> bool:
    """Project points onto cone(rays); rays of length one.

    Parameters
    ----------
    rays, points, out
        (r, d), (n, d), (n, d): out receives the nearest points.

    Returns
    -------
    bool
        Whether every point was finished within the iteration limit.
    """
    r, d = rays.shape
    beta, w = np.empty(r), np.empty(r)
    passive = np.empty(d, dtype=np.int64)
    used = np.empty(r, dtype=np.int64)
    basis, L, y = np.empty((d, d)), np.empty((d, d)), np.empty(d)
    done = True
    for n in range(points.shape[0]):
        done = _project(rays, points[n], beta, w, passive, used, basis, L, y) and done
        for q in range(d):
            s = 0.0
            for k in range(r):
                s += beta[k] * rays[k, q]
            out[n, q] = s
    return done


@inline_kernel
def _project(
    rays: FloatArray, x: FloatArray, beta: FloatArray, w: FloatArray, passive: IntArray, used: IntArray,
    basis: FloatArray, L: FloatArray, y: FloatArray,
) -> bool:  # fmt: skip
    """Find the weights beta >= 0 of the nearest point; used marks passive (1) and refused (2) rays."""
    r, d = rays.shape
    beta[:], used[:] = 0.0, 0
    # of the point's own size: what rounding leaves of a residual that is orthogonal to a ray
    tol = 1e-13 * math.sqrt(dot(x, x))
    count = 0
    for _ in range(10 * (r + d)):
        # the ray along which the distance falls fastest (Lawson and Hanson 1974, NNLS)
        best, at = tol, -1
        # Karush-Kuhn-Tucker: at the nearest point no ray that is out has a positive product with the residual
        for k in range(r):
            if used[k] != 0:
                continue
            s = 0.0
            for q in range(d):
                rest = x[q]
                for j in range(count):
                    rest -= beta[passive[j]] * rays[passive[j], q]
                s += rays[k, q] * rest
            if s > best:
                best, at = s, k
        if at < 0:
            return True
        # more than d rays depend on each other, and d of them span the space already
        if count == d or not _append(rays, at, count, basis, L):
            used[at] = 2  # depends on the passive ones: it cannot come in now
            continue
        passive[count] = at
        count += 1
        used[at] = 1
        _weights(x, count, basis, L, y)
        if y[count - 1] <= 0.0:  # only rounding said that this ray would help
            count -= 1
            used[at] = 2
            continue
        count = _leave(rays, x, count, passive, used, beta, basis, L, y)
        # passive rays have changed: what depended on them may be wanted now
        for k in range(r):
            if used[k] == 2:
                used[k] = 0
    return False


@inline_kernel
def _leave(
    rays: FloatArray, x: FloatArray, count: int, passive: IntArray, used: IntArray, beta: FloatArray,
    basis: FloatArray, L: FloatArray, y: FloatArray,
) -> int:  # fmt: skip
    """Step towards the least-squares weights y, dropping rays whose weight would turn negative."""
    while True:
        # the longest step from beta towards y that keeps all weights >= 0
        step = 1.0
        for j in range(count):
            if y[j] <= 0.0:
                b = beta[passive[j]]
                step = min(step, b / (b - y[j]) if b > y[j] else 0.0)
        for j in range(count):
            k = passive[j]
            beta[k] += step * (y[j] - beta[k])
        if step >= 1.0:
            return count
        # rays whose weight has reached zero leave
        kept = 0
        for j in range(count):
            k = passive[j]
            if beta[k] > 0.0 and (y[j] > 0.0 or beta[k] > 1e-14 * abs(y[j])):
                passive[kept] = k
                kept += 1
            else:
                beta[k] = 0.0
                used[k] = 0
        # the basis without them, from the start: rays are few
        count = 0
        for j in range(kept):
            if _append(rays, passive[j], count, basis, L):
                passive[count] = passive[j]
                count += 1
        _weights(x, count, basis, L, y)


@inline_kernel
def _append(rays: FloatArray, at: int, count: int, basis: FloatArray, L: FloatArray) -> bool:
    """Make ray `at` the next orthonormal vector; False if it depends on the others.

    Row `count` of L holds what the ray has of each: passive rays = L basis.
    """
    for q in range(rays.shape[1]):
        basis[count, q], L[count, q] = rays[at, q], 0.0
    size = remove_rows(basis, count, L[count])
    if size < _DEPENDENT:
        return False
    L[count, count] = size
    scale_row(basis, count, size)
    return True


@inline_kernel
def _weights(x: FloatArray, count: int, basis: FloatArray, L: FloatArray, y: FloatArray) -> None:
    """Set y to the least-squares weights of the passive rays: Lᵀ y = basis x."""
    for j in range(count):
        y[j] = dot(basis[j], x)
    solve_upper(L, y[:count])


def nearest_in_cone(rays: FloatArray, points: FloatArray) -> FloatArray:
    """Return the nearest points of cone(rays) to (n, d) points; rays (r, d) of any length, zeros too.

    Raises
    ------
    ArithmeticError
        If the active-set method does not finish (not seen to happen).
    """
    size = np.sqrt(np.einsum("ij,ij->i", rays, rays))
    unit = np.ascontiguousarray(rays[size > 0.0] / size[size > 0.0, None])
    out = np.zeros(points.shape)
    if len(unit) and len(points) and not nearest_points(unit, np.ascontiguousarray(points), out):
        raise ArithmeticError("non-negative least squares did not finish")
    return out
