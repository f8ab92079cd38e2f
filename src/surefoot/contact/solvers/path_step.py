"""One step along the central path by its length, compiled: where the path turns, gaps cannot be its measure.

Coulomb's law is not monotone, so its central path may turn back for a while, or nearly: within a hundredth of
the gap contacts go over from sticking to sliding, and steps that aim at a smaller gap end at the border of
the cones. Seen as a curve of points and log gaps it is smooth. A step has two parts with one factorised
matrix: back to the path, orthogonal to it, and on along its tangent. Lengths and angles are those of the
scaled variables over the root of the gap, in which the border is about one away.

Walls of equal bricks are symmetric, and their paths branch. With unequal shares of the gap, a contact each,
none does: there the sign of the determinant tells which way is on, however sharply the path turns, and a
third part of a step tells how the products of the cones bend it, by Mehrotra's second order. It is gone along
where it is short, and shortens a step that only goes back where it is long. With equal shares walls of light
and heavy bricks lose their path by it.

Source: E. Allgower, K. Georg, "Introduction to numerical continuation methods", 2003, chapters 2 and 6.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.central_step import (
    LESS,
    REFINEMENTS,
    Iterate,
    Scaling,
    ends_central,
    fill_direction,
    longest_inside,
)
from surefoot.contact.solvers.cone_pairs import aim_pairs, apply_scaling, centrality
from surefoot.contact.solvers.reduced_system import Factors, Rows

NEAR = 1.0
"""Distance to the path above which a step only goes back to it."""
BACK, ON, BACK_EQUAL = 0.9, 0.7, 0.5
"""Shares of the way to the border that a step takes back to the path, and on along it; and back to one of
equal shares."""
OFF_PATH, OFF_PATH_FAR = 0.05, 0.01
"""Least centrality after a step near the path, and after one that only goes back to it: there `LESS` of what
it was is enough, too."""
MOST_BENT = 1.0
"""Length of a step's bend up to which it is gone along: of longer ones second order knows too little."""
TURNING = 5.0
"""Times the length of a tangent, over that of a path whose contacts keep their modes, above which the path
may turn: then it goes on as it went, else the gap falls."""
UNEQUAL = 0.5
"""By how much the contacts' shares of the gap differ from each other's mean."""
SHORTER, SHORTEST = 0.7, 1e-6
"""By how much a step is shortened that leaves the centre, and where that ends."""


class Motion(NamedTuple):
    """The last step along a path: of x and y (n, 3), and (1,) of the logarithm of the gap; zero for none."""

    dx: FloatArray
    dy: FloatArray
    log: FloatArray


_PRIMES = 2.0, 3.0, 7.0, 11.0, 13.0, 17.0, 19.0
IRRATIONAL = (0.5 * (math.sqrt(5.0) - 1.0), *(math.sqrt(prime) % 1.0 for prime in _PRIMES))
"""Their multiples spread the shares; any others would do, but for equal ones."""


def unequal_shares(count: int, number: int = 0) -> FloatArray:
    """Return shares of the gap (n,), one a contact, of mean one or nearly, no two alike.

    The number, of `IRRATIONAL`, tells by which multiples they are spread.
    """
    spread = np.arange(1, count + 1) * IRRATIONAL[number] % 1.0
    return np.asarray(1.0 + UNEQUAL * (2.0 * spread - 1.0))


@inline_kernel
def _scale_steps(axes: FloatArray, gap: float, dx: FloatArray, dy: FloatArray, out: FloatArray) -> None:
    """Fill out (2, n, 3) with steps of x and y (n, 3) in the scaled variables, over the root of the gap."""
    root = 1.0 / math.sqrt(gap)
    for k in range(len(dx)):
        p, q, r = apply_scaling(axes[k], -1.0, dx[k])
        out[0, k, 0], out[0, k, 1], out[0, k, 2] = root * p, root * q, root * r
        p, q, r = apply_scaling(axes[k], 1.0, dy[k])
        out[1, k, 0], out[1, k, 1], out[1, k, 2] = root * p, root * q, root * r


@inline_kernel
def _inner(one: FloatArray, two: FloatArray) -> float:
    """Return the inner product of two scaled steps (2, n, 3), without that of their log gaps."""
    total = 0.0
    for side in range(2):
        for k in range(one.shape[1]):
            for a in range(3):
                total += one[side, k, a] * two[side, k, a]
    return total


@inline_kernel
def _fill_bend(
    factors: Factors, rows: Rows, point: Iterate, scaling: Scaling, gap: float,
    step: tuple[FloatArray, FloatArray], own: FloatArray, bx: FloatArray, by: FloatArray,
) -> float:  # fmt: skip
    """Fill bx, by (n, 3) with how the cones' products bend a step of x and y (n, 3), or zero where far.

    Return their length. A share t of the step ends at t times the step and t² times its bend. `own` (n, 3) is
    the aim of no step.
    """
    axes, scaled, weights = scaling
    space = np.zeros((3, *own.shape))
    aim, none, moved = space[0], space[1], space[2]
    aim_pairs(axes, scaled, step[0], step[1], 0.0, 1.0, aim)
    aim -= own
    fill_direction(factors, rows, weights, axes, point.y, 1.0, aim, none, moved, bx, by, 0)
    out = np.empty((2, *own.shape))
    _scale_steps(axes, gap, bx, by, out)
    length = math.sqrt(_inner(out, out))
    if not length <= MOST_BENT:
        bx[:], by[:] = 0.0, 0.0
    return length


@inline_kernel
def _arrive(
    point: Iterate, step: tuple[FloatArray, FloatArray], bend: tuple[FloatArray, FloatArray], length: float,
    least: float, after: Iterate,
) -> float:  # fmt: skip
    """Fill the point after a length of a step that bends, shortened until it is as central; return that."""
    while length > SHORTEST:
        dx, dy = step[0] + length * bend[0], step[1] + length * bend[1]
        if ends_central(point, dx, dy, length, least, after):
            return length
        length *= SHORTER
    return 0.0


@kernel
def path_step(
    factors: Factors, rows: Rows, point: Iterate, residual: FloatArray, scaling: Scaling, gap: float,
    motion: Motion, shares: FloatArray, sign: float, reach: float, after: Iterate,
) -> tuple[float, float, float]:  # fmt: skip
    """Fill the point after a step; return its length (zero for none), the log gap's change and how far off.

    The change is of first order, and how far off the path the step began is in the lengths of the module.
    Contacts have shares (n,) of the gap, and of the step on `reach` is the share that is taken. The sign is
    that of the gap's change; zero goes on as the last motion went, which is replaced. The others are those
    of `central_step`, with the shift's derivative in S.
    """
    x, border_x, y, border_y = point
    axes, scaled, weights = scaling
    n = len(x)
    space = np.zeros((9, n, 3))
    aim, ahead, moved, none = space[0], space[1], space[2], space[3]
    tx, ty, cx, cy, own = space[4], space[5], space[6], space[7], space[8]
    aim_pairs(axes, scaled, none, none, 0.0, 0.0, own)
    aim_pairs(axes, scaled, none, none, gap, 0.0, aim)
    ahead[:] = shares.reshape(n, 1) * (aim - own)
    aim[:] = own + ahead
    fill_direction(factors, rows, weights, axes, y, 1.0, ahead, none, moved, tx, ty, 0)
    fill_direction(factors, rows, weights, axes, y, 1.0, aim, residual, moved, cx, cy, REFINEMENTS)
    tangent, back_to = np.empty((2, n, 3)), np.empty((2, n, 3))
    _scale_steps(axes, gap, tx, ty, tangent)
    _scale_steps(axes, gap, cx, cy, back_to)
    size = math.sqrt(_inner(tangent, tangent) + n)
    equal = sign == 0.0
    if equal:
        sign = -1.0
        turns = size > TURNING * math.sqrt(2.0 * n)
        last = np.empty((2, n, 3))
        _scale_steps(axes, gap, motion.dx, motion.dy, last)
        along = _inner(last, tangent) + n * motion.log[0]
        sign = 1.0 if turns and along > 0.0 else -1.0
    part = _inner(back_to, tangent) / size**2
    cx -= part * tx
    cy -= part * ty
    back_to -= part * tangent
    off = math.sqrt(_inner(back_to, back_to) + n * part * part)
    back = min(1.0, (BACK_EQUAL if equal else BACK) * longest_inside(x, border_x, y, border_y, cx, cy))
    tx *= sign / size
    ty *= sign / size
    on = reach * ON * longest_inside(x, border_x, y, border_y, tx, ty) if off < NEAR else 0.0
    cx[:] = back * cx + on * tx
    cy[:] = back * cy + on * ty
    log = on * sign / size - back * part
    if not abs(log) < np.inf:
        return 0.0, 0.0, off
    tx[:], ty[:], length = 0.0, 0.0, 1.0
    if not equal:
        bend = _fill_bend(factors, rows, point, scaling, gap, (cx, cy), own, tx, ty)
        if on == 0.0 and bend > 0.0:
            length = min(1.0, back * off / bend)
    least = OFF_PATH if off < NEAR else min(OFF_PATH_FAR, LESS * centrality(x, border_x, y, border_y))
    length = _arrive(point, (cx, cy), (tx, ty), length, least, after)
    if length > 0.0 and on > 0.0:
        motion.dx[:], motion.dy[:], motion.log[0] = cx, cy, log
    return length, length * log, off
