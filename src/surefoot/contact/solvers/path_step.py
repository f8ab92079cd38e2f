"""One step along the central path by its length, compiled: where the path turns, gaps cannot be its measure.

Coulomb's law is not monotone, so its central path may turn back for a while, or nearly: within a hundredth of
the gap contacts go over from sticking to sliding, and steps that aim at a smaller gap end at the border of
the cones. Seen as a curve of points and log gaps it is smooth. A step has two parts with one factorised
matrix: back to the path, orthogonal to it, and on along its tangent. Lengths and angles are those of the
scaled variables over the root of the gap, in which the border is about one away.

Source: E. Allgower, K. Georg, "Introduction to numerical continuation methods", 2003, chapters 2 and 6.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.central_step import Iterate, Scaling, fill_direction, longest_inside
from surefoot.contact.solvers.cone_pairs import aim_pairs, apply_scaling, centrality, move_points

NEAR = 1.0
"""Distance to the path above which a step only goes back to it."""
BACK, ON = 0.5, 0.7
"""Shares of the way to the border that a step takes back to the path, and on along it."""
OFF_PATH, OFF_PATH_FAR = 0.05, 0.01
"""Least centrality after a step near the path, and after one that only goes back to it."""
TURNING = 5.0
"""Times the length of a tangent, over that of a path whose contacts keep their modes, above which the path
may turn: then it goes on as it went, else the gap falls."""
SHORTER, SHORTEST = 0.7, 1e-6
"""By how much a step is shortened that leaves the centre, and where that ends."""


class Motion(NamedTuple):
    """The last step along a path: of x and y (n, 3), and (1,) of the logarithm of the gap; zero for none."""

    dx: FloatArray
    dy: FloatArray
    log: FloatArray


@inline_kernel
def _inner(
    axes: FloatArray, gap: float, dx: FloatArray, dy: FloatArray, px: FloatArray, py: FloatArray
) -> float:
    """Return the inner product of two steps of x and y (n, 3), without that of their log gaps."""
    total = 0.0
    for k in range(len(dx)):
        a, b, c = apply_scaling(axes[k], -1.0, dx[k])
        p, q, r = apply_scaling(axes[k], -1.0, px[k])
        total += a * p + b * q + c * r
        a, b, c = apply_scaling(axes[k], 1.0, dy[k])
        p, q, r = apply_scaling(axes[k], 1.0, py[k])
        total += a * p + b * q + c * r
    return total / gap


@kernel
def path_step(
    factors: FloatArray, pivots: IntArray, rows: FloatArray, across: FloatArray, point: Iterate,
    residual: FloatArray, scaling: Scaling, gap: float, motion: Motion, after: Iterate,
) -> tuple[float, float]:  # fmt: skip
    """Fill the point after a step; return its length (zero where there is none) and the log gap's change.

    The change is of first order. The arguments are those of `central_step`, with the shift's derivative in S;
    the last motion is replaced.
    """
    x, border_x, y, border_y = point
    axes, scaled, weights = scaling
    n = len(x)
    space = np.zeros((8, n, 3))
    aim, ahead, moved, none = space[0], space[1], space[2], space[3]
    tx, ty, cx, cy = space[4], space[5], space[6], space[7]
    aim_pairs(axes, scaled, none, none, 0.0, 0.0, ahead)
    aim_pairs(axes, scaled, none, none, gap, 0.0, aim)
    ahead[:] = aim - ahead
    fill_direction(factors, pivots, rows, across, weights, axes, y, 1.0, ahead, none, moved, tx, ty)
    fill_direction(factors, pivots, rows, across, weights, axes, y, 1.0, aim, residual, moved, cx, cy)
    size = math.sqrt(_inner(axes, gap, tx, ty, tx, ty) + n)
    sign = -1.0
    if size > TURNING * math.sqrt(2.0 * n):
        along = _inner(axes, gap, motion.dx, motion.dy, tx, ty) + n * motion.log[0]
        sign = 1.0 if along > 0.0 else -1.0
    part = _inner(axes, gap, cx, cy, tx, ty) / size**2
    cx -= part * tx
    cy -= part * ty
    off = math.sqrt(_inner(axes, gap, cx, cy, cx, cy) + n * part * part)
    back = min(1.0, BACK * longest_inside(x, border_x, y, border_y, cx, cy))
    tx *= sign / size
    ty *= sign / size
    on = ON * longest_inside(x, border_x, y, border_y, tx, ty) if off < NEAR else 0.0
    cx[:] = back * cx + on * tx
    cy[:] = back * cy + on * ty
    log = on * sign / size - back * part
    if not abs(log) < np.inf:
        return 0.0, 0.0
    length, least = 1.0, OFF_PATH if off < NEAR else OFF_PATH_FAR
    while length > SHORTEST:
        inside = move_points(x, border_x, cx, length, after.x, after.border_x)
        inside = move_points(y, border_y, cy, length, after.y, after.border_y) and inside
        if inside and centrality(after.x, after.border_x, after.y, after.border_y) >= least:
            if on > 0.0:
                motion.dx[:], motion.dy[:], motion.log[0] = cx, cy, log
            return length, length * log
        length *= SHORTER
    return 0.0, 0.0
