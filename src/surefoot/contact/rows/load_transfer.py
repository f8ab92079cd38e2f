"""Redundant rows pass load from one to another, round after round at the same pace: gone all the way at once.

Two contacts of one foot that nearly do the same keep an inner stress that hardly moves anything: the proximal
method carries it on by equal steps, thousands of them, until a block lets go. Where that is, is known.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.contact.rows.blocks import CONE_ROWS, DIM, DRY_ROW, FIRST, KIND, LIMIT, MU, SOFT_ROWS, STOP_ROW

FAR = 1e9
"""Rounds that are not gone at once: nothing lets go on this way."""
ON_CONE = 1e-9
"""Share of the cone's radius squared within which an impulse slides already [-]."""


@inline_kernel
def extend_transfer(table: IntArray, numbers: FloatArray, x: FloatArray, p: FloatArray) -> None:
    """Move impulses p (m,) on along p - x, to where the first block that holds lets go."""
    far = FAR
    for k in range(table.shape[0]):
        kind, at = table[k, KIND], table[k, FIRST]
        if kind in (CONE_ROWS, STOP_ROW):
            if p[at] > 0.0:
                far = min(far, _way_out(table[k, DIM], numbers[k, MU], x, p, at))
        elif kind == DRY_ROW:
            step, limit = p[at] - x[at], numbers[k, LIMIT]
            if abs(p[at]) < limit and step != 0.0:
                far = min(far, ((limit if step > 0.0 else -limit) - p[at]) / step)
    if far >= FAR:
        return
    for k in range(table.shape[0]):
        if table[k, KIND] != SOFT_ROWS:
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                p[i] += far * (p[i] - x[i])


@inline_kernel
def _way_out(dim: int, mu: float, x: FloatArray, p: FloatArray, at: int) -> float:
    """Return how many times p - x a cone's impulse p has to go until it leaves the cone; FAR for never."""
    drop = p[at] - x[at]
    far = -p[at] / drop if drop < 0.0 else FAR
    if dim == 1:
        return far
    # a t² + 2 b t + c = ||p_t + t d_t||² - mu² (p_n + t d_n)²
    a, b, c = -((mu * drop) ** 2), -mu * mu * p[at] * drop, -((mu * p[at]) ** 2)
    for i in range(at + 1, at + dim):
        step = p[i] - x[i]
        a, b, c = a + step * step, b + step * p[i], c + p[i] * p[i]
    if c >= -ON_CONE * (mu * p[at]) ** 2:
        return FAR
    square = b * b - a * c
    if square < 0.0:
        return far
    # c < 0: the least positive root
    root = math.sqrt(square)
    if a > 0.0:
        return float(min(far, (root - b) / a))
    return float(min(far, -c / (b + root))) if b + root > 0.0 else far
