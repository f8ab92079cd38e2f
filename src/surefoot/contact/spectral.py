"""The spectral norm of a Delassus operator, which every residual is scaled by.

Lanczos without orthogonalisation: copies of eigenvalues that come up twice do not move the largest one. It
stops by the residual of the Ritz vector, whose last entry s satisfies s² = p_{k-1}(θ) / p_k'(θ) with the
characteristic polynomials p of the leading blocks of the tridiagonal matrix; θ itself is found by Laguerre's
iteration from above, which never passes the largest root.

Source: B. N. Parlett, "The Symmetric Eigenvalue Problem", SIAM 1998, chapters 4, 7 and 13.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.blocks import block_product
from surefoot.kernels import inline_kernel, kernel

STEPS = 400
FIRST, BETWEEN = 6, 3
"""Lanczos steps before the first look at the Ritz value, and between looks."""
RESIDUAL = 1e-7
"""Wanted residual of the Ritz vector over its value: the value's error is its square over the gap."""
BREAKDOWN = 1e-13
"""A step below this share of the norm has left the space."""


@kernel
def _start_vector(size: int) -> FloatArray:
    """Return a fixed unit vector without symmetry that a mechanism could share."""
    v = np.empty(size)
    state = 12345
    total = 0.0
    for i in range(size):
        state = (1103515245 * state + 12345) % 2147483648
        v[i] = 0.5 + state / 2147483648.0
        total += v[i] * v[i]
    return v / math.sqrt(total)


@inline_kernel
def _all_below(diagonal: FloatArray, off: FloatArray, count: int, sign: float, bound: float) -> bool:
    """Tell whether all eigenvalues of sign * T are below the bound (T - bound I is negative definite)."""
    pivot = -1.0
    for i in range(count):
        pivot = sign * diagonal[i] - bound - (off[i - 1] ** 2 / pivot if i > 0 else 0.0)
        if pivot >= 0.0:
            return False
    return True


@inline_kernel
def _largest_eigenvalue(
    diagonal: FloatArray, off: FloatArray, count: int, sign: float
) -> tuple[float, float]:
    """Return the largest eigenvalue of sign * T (0 if negative), and its vector's last entry squared."""
    bound = 0.0
    for i in range(count):
        reach = sign * diagonal[i]
        reach += abs(off[i - 1]) if i > 0 else 0.0
        reach += abs(off[i]) if i < count - 1 else 0.0
        bound = max(bound, reach)
    if not bound > 0.0:
        return 0.0, 0.0
    share = 1.0 / bound
    x, last = 1.0, 1.0  # x in units of the bound: no polynomial overflows
    for _ in range(50):
        before, slope_before, bend_before = 1.0, 0.0, 0.0
        value, slope, bend = x - sign * diagonal[0] * share, 1.0, 0.0  # bend: half the second derivative
        for i in range(1, count):
            t, b = x - sign * diagonal[i] * share, (off[i - 1] * share) ** 2
            before, value = value, t * value - b * before
            slope_before, slope, grown = slope, t * slope + before - b * slope_before, slope
            bend_before, bend = bend, t * bend + grown - b * bend_before
        last = before / slope if slope > 0.0 else last
        if value <= 0.0 or slope <= 0.0:  # at the root, but for rounding
            break
        g = slope / value
        h = g * g - 2.0 * bend / value
        step = count / (g + math.sqrt(max(0.0, (count - 1) * (count * h - g * g))))
        x -= step
        if not x > 0.0:
            return 0.0, 0.0
        if step <= 1e-13 * x:
            break
    return x * bound, max(last, 0.0)


@inline_kernel
def _take_step(
    k: int, v: FloatArray, before: FloatArray, w: FloatArray, diagonal: FloatArray, off: FloatArray
) -> None:
    """Extend T by w = G v and move on to the next vector, unless that vanishes."""
    beta = off[k - 1] if k > 0 else 0.0
    dot = total = 0.0
    for j in range(v.size):
        w[j] -= beta * before[j]
        dot += w[j] * v[j]
    for j in range(v.size):
        w[j] -= dot * v[j]
        total += w[j] * w[j]
    diagonal[k], off[k] = dot, math.sqrt(total)
    share = 1.0 / off[k] if off[k] > 0.0 else 0.0
    for j in range(v.size):
        before[j], v[j] = v[j], w[j] * share


@inline_kernel
def _judge(diagonal: FloatArray, off: FloatArray, count: int, most: int) -> tuple[bool, float]:
    """Tell whether the largest |eigenvalue| of T is that of G, and return it."""
    scale = 0.0
    for i in range(count):
        scale = max(scale, abs(diagonal[i]), off[i])
    last = count == most or off[count - 1] <= BREAKDOWN * scale
    if not last and (count < FIRST or (count - FIRST) % BETWEEN != 0):
        return False, 0.0
    value, share = _largest_eigenvalue(diagonal, off, count, 1.0)
    if not _all_below(diagonal, off, count, -1.0, 0.5 * value):  # not semidefinite: the other end may win
        other, other_share = _largest_eigenvalue(diagonal, off, count, -1.0)
        share = max(share, other_share) if other < 2.0 * value else other_share
        value = max(value, other)
    return last or off[count - 1] ** 2 * share <= (RESIDUAL * value) ** 2, value


@kernel
def spectral_norm(G: FloatArray) -> float:
    """Return ||G||₂ of a dense symmetric matrix, to about 1e-9 relative."""
    size = G.shape[0]
    most = min(3 * size, STEPS)
    v, before, w = _start_vector(size), np.zeros(size), np.empty(size)
    diagonal, off = np.empty(most), np.empty(most)
    for k in range(most):
        for j in range(size):
            w[j] = 0.0
        for i in range(size):
            x = v[i]
            for j in range(size):
                w[j] += G[i, j] * x
        _take_step(k, v, before, w, diagonal, off)
        done, value = _judge(diagonal, off, k + 1, most)
        if done:
            return value
    return 0.0


@kernel
def spectral_norm_blocks(starts: IntArray, columns: IntArray, values: FloatArray) -> float:
    """Return ||G||₂ of a symmetric block matrix, to about 1e-9 relative."""
    size = 3 * (starts.size - 1)
    most = min(3 * size, STEPS)
    v, before = _start_vector(size), np.zeros(size)
    diagonal, off = np.empty(most), np.empty(most)
    for k in range(most):
        w = block_product(starts, columns, values, v)
        _take_step(k, v, before, w, diagonal, off)
        done, value = _judge(diagonal, off, k + 1, most)
        if done:
            return value
    return 0.0
