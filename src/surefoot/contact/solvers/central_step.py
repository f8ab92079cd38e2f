"""One step along the central path of pairs in second-order cones, compiled: predictor, corrector, length.

A Newton step on x and y, one pair a contact, that are to keep y = Y Yᵀ x + g + shift: see `interior_point`
for the equations, `cone_pairs` for the scaling. Compiled whole, because a step of four contacts takes
microseconds and each call from Python takes one.

Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIOPT 2, 1992.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.cone_pairs import (
    aim_pairs,
    centrality,
    finish_direction,
    longest_step,
    move_points,
)
from surefoot.contact.solvers.reduced_system import Factors, Rows, apply_rows, gather_rows, solve_factors

TO_BORDER = 0.99
"""Share of the way to the border that a step takes."""
OFF_CENTRE, LESS = 1e-2, 0.9
"""Least centrality after a step; from a point farther from the centre, as light and heavy bodies begin, this
share of its own is enough."""
REFINEMENTS = 1
"""Corrections of a step by its own residual; a direction that only tells how far to go needs none."""
EXACT = 1e-9
"""Residual of a direction, over its own size, that needs no correction."""
SHORTER, SHORTEST = 0.8, 1e-10
"""By how much a step is shortened that leaves the centre, and where that ends."""


@inline_kernel
def fill_direction(
    factors: Factors, rows: Rows, weights: FloatArray, axes: FloatArray, y: FloatArray, share: float,
    aim: FloatArray, residual: FloatArray, moved: FloatArray, dx: FloatArray, dy: FloatArray, times: int,
) -> None:  # fmt: skip
    """Fill the steps dx, dy (n, 3) with dx + P dy = aim and S dy = Y Yᵀ dx - residual.

    They are corrected by their own residual so many times, as long as there is one.
    """
    n, r = len(aim), rows.size
    v, change, flat = np.empty(r), np.empty(r), np.empty(3 * n)
    for k in range(n):
        for a in range(3):
            dx[k, a] = aim[k, a]
            for b in range(3):
                dx[k, a] += weights[k, a, b] * residual[k, b]
    gather_rows(rows, dx, v)
    solve_factors(factors, v)
    for turn in range(times + 1):
        apply_rows(rows, v, flat)
        for k in range(n):
            for a in range(3):
                moved[k, a] = flat[3 * k + a] - residual[k, a]
        finish_direction(axes, y, share, aim, moved, dx, dy)
        if turn == times:
            return
        gather_rows(rows, dx, change)
        missed = size = 0.0
        for j in range(r):
            change[j] -= v[j]
            missed, size = max(missed, abs(change[j])), max(size, abs(v[j]))
        if missed <= EXACT * size:
            return
        solve_factors(factors, change)
        for j in range(r):
            v[j] += change[j]


@inline_kernel
def longest_inside(
    x: FloatArray, border_x: FloatArray, y: FloatArray, border_y: FloatArray, dx: FloatArray, dy: FloatArray
) -> float:
    """Return the longest multiple of the steps dx, dy (n, 3) from x, y (n, 3) inside both cones."""
    return min(longest_step(x, border_x, dx), longest_step(y, border_y, dy))


class Iterate(NamedTuple):
    """Forces and velocities (n, 3) in the cone L, with their distances (n,) to its border."""

    x: FloatArray
    border_x: FloatArray
    y: FloatArray
    border_y: FloatArray


@inline_kernel
def ends_central(
    point: Iterate, dx: FloatArray, dy: FloatArray, length: float, least: float, after: Iterate
) -> bool:
    """Fill the point after a length of a step (n, 3); return whether it is in both cones, and central."""
    inside = move_points(point.x, point.border_x, dx, length, after.x, after.border_x)
    inside = move_points(point.y, point.border_y, dy, length, after.y, after.border_y) and inside
    return inside and centrality(after.x, after.border_x, after.y, after.border_y) >= least


class Scaling(NamedTuple):
    """What `scale_pairs` fills: axes (n, 4), l (n, 3) and P S⁻¹ (n, 3, 3)."""

    axes: FloatArray
    scaled: FloatArray
    weights: FloatArray


@kernel
def central_step(
    factors: Factors, rows: Rows, point: Iterate, residual: FloatArray, scaling: Scaling, gap: float,
    share: float, least: float, after: Iterate,
) -> float:  # fmt: skip
    """Fill the point after a step; return its length, zero where there is none.

    Parameters
    ----------
    factors, rows
        Of I + Yᵀ P S⁻¹ Y, and the scaled rows of Y: see `ReducedSystem`.
    point, after
        Where the step begins, and memory for where it ends.
    residual
        y less what x asks for, (n, 3).
    scaling, gap
        Of `scale_pairs`.
    share
        Of the shift's derivative in S: 1, or 0 where it is held.
    least
        Least centring.
    """
    x, border_x, y, border_y = point
    axes, scaled, weights = scaling
    n = len(x)
    space = np.zeros((4, n, 3))
    aim, moved, dx, dy = space[0], space[1], space[2], space[3]
    aim_pairs(axes, scaled, dx, dy, 0.0, 0.0, aim)
    fill_direction(factors, rows, weights, axes, y, share, aim, residual, moved, dx, dy, 0)
    length = min(1.0, longest_inside(x, border_x, y, border_y, dx, dy))
    if not length >= 0.0:
        return 0.0
    left = 0.0
    for k in range(n):
        for a in range(3):
            left += (x[k, a] + length * dx[k, a]) * (y[k, a] + length * dy[k, a])
    # Mehrotra's rule: centre little where the predictor got far
    centre = max(min(max(left / n / gap, 0.0), 1.0) ** 3, least)
    aim_pairs(axes, scaled, dx, dy, centre * gap, length * length, aim)
    fill_direction(factors, rows, weights, axes, y, share, aim, residual, moved, dx, dy, REFINEMENTS)
    length = min(1.0, TO_BORDER * longest_inside(x, border_x, y, border_y, dx, dy))
    enough = min(OFF_CENTRE, LESS * centrality(x, border_x, y, border_y))
    while length > SHORTEST:
        if ends_central(point, dx, dy, length, enough, after):
            return length
        length *= SHORTER
    return 0.0


@kernel
def fill_residual(
    y: FloatArray, scale: FloatArray, u: FloatArray, lift: FloatArray, speed: FloatArray, out: FloatArray
) -> float:
    """Fill out (n, 3) with y less the scaled velocities and the lift (n,); return the most over the speeds.

    An empty lift stands for the length of y's own tangents.
    """
    worst = 0.0
    for k in range(len(y)):
        for a in range(3):
            out[k, a] = y[k, a] - scale[k, a] * u[k, a]
        out[k, 2] -= lift[k] if lift.size else np.sqrt(y[k, 0] ** 2 + y[k, 1] ** 2)
        for a in range(3):
            worst = max(worst, abs(out[k, a]) / speed[k])
    return worst
