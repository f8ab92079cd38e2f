"""Trace a convex region of the plane between an inner and an outer polygon.

T. Bretl, S. Lall, "Testing Static Equilibrium for Legged Robots", IEEE T-RO 2008: maximise along a
direction; the point reached belongs to the region, the half-plane behind it holds all of the region; go on
along the normal of the inner edge whose gap is largest. The half-planes here come from the dual
solution, and what its slack leaves the cone by is charged on the largest forces there can be, so the outer
polygon is an upper bound whatever the solver's accuracy. The gap that steers the search is an estimate;
`polygons.enclose` measures the one that is stated.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import dot
from surefoot.mechanics.statics.cone_program import UNBOUNDED, minimise
from surefoot.mechanics.statics.margin import GAP
from surefoot.mechanics.statics.polygons import to_segment
from surefoot.mechanics.statics.row_blocks import IN_ONE

TRACED, WITHOUT_BOUND, OUT_OF_DIRECTIONS = 0, 1, 2
"""Outcomes of `trace`: done; forces without bound; the gap stayed above the tolerance, because there were too
few directions or because no further one would have helped."""
_MOST_FORCE = 1e6
"""Forces that may add up to more loads than this count as forces without bound."""
_COARSE = 1e-2
_MENDABLE = 1.5
"""A corner this many times as far out as the half-planes beside it are from their points can be mended."""
_ROUNDING = 32.0 * 2.0**-53
"""Share of the largest terms by which a dual slack may be wrong."""


@inline_kernel
def _corner(
    ax: float, ay: float, ah: float, bx: float, by: float, bh: float, vx: float, vy: float
) -> tuple[float, float]:
    """Return where the lines a.q = ah and b.q = bh meet; parallel lines meet at (vx, vy)."""
    # Half-planes of nearly one direction meet wherever rounding says: the point reached stands for the
    # corner.
    det = ax * by - ay * bx
    if abs(det) < 1e-9:
        return vx, vy
    return (ah * by - bh * ay) / det, (ax * bh - bx * ah) / det


@inline_kernel
def _lower_bound(
    B: FloatArray, b: FloatArray, c: FloatArray, lorentz: int, y: FloatArray
) -> tuple[float, float]:
    """Return b.y, and by how much c - B' y leaves the cone at most, both with their rounding against us.

    Every x of the program has c.x >= b.y - lack sum(x), sum(x) over heights of cones and half-lines.
    """
    r, m = B.shape
    value, lack = 0.0, 0.0
    for j in range(r):
        # Weak duality: c.x = b.y + (c - B'y).x for every x with B x = b, whatever y the solver left. The
        # first term less its own rounding.
        value += b[j] * y[j] - _ROUNDING * abs(b[j] * y[j])
    s0, s1, size = 0.0, 0.0, 0.0
    for i in range(m):
        s, weight = c[i], abs(c[i])
        for j in range(r):
            s -= B[j, i] * y[j]
            weight += abs(B[j, i] * y[j])
        if i >= 3 * lorentz:
            # The slack s = c - B'y should be in the dual cone, where s.x >= 0. What it lacks to be so, added
            # to the height of a cone or to a half-line, puts it there: hence lack sum(x). Rounding of its
            # terms counts as lacking.
            lack = max(lack, _ROUNDING * weight - s)
        elif i % 3 == 0:
            s0, size = s, weight
        elif i % 3 == 1:
            s1, size = s, max(size, weight)
        else:
            lack = max(lack, math.hypot(s1, s) - s0 + _ROUNDING * max(size, weight))
    return value, lack


@inline_kernel
def _most_force(
    B: FloatArray, b: FloatArray, lorentz: int, start: FloatArray,
    x: FloatArray, y: FloatArray, z: FloatArray, c: FloatArray,
) -> float:  # fmt: skip
    """Return a bound on the sum of heights and half-lines of every solution; infinite where there is none."""
    for i in range(c.size):
        c[i] = -1.0 if i >= 3 * lorentz or i % 3 == 0 else 0.0
        x[i] = start[i]
    status, _ = minimise(B, b, c, lorentz, x, y, z, _COARSE, -_MOST_FORCE, 0.0, IN_ONE, c[:0])
    # -sum(x) = c.x >= value - lack sum(x): solved for the sum.
    value, lack = _lower_bound(B, b, c, lorentz, y)
    if status == UNBOUNDED or lack >= 0.5 or not -value < _MOST_FORCE:
        return math.inf
    return max(0.0, -value) / (1.0 - lack)


@kernel
def trace(
    B: FloatArray, b: FloatArray, lorentz: int, start: FloatArray, G: FloatArray, offset: FloatArray,
    tol: float, directions: FloatArray, heights: FloatArray, points: FloatArray,
) -> tuple[int, int, float]:  # fmt: skip
    """Trace {G x + offset : B x = b, x in the cone} to a gap of at most tol.

    Parameters
    ----------
    B, b, lorentz
        (r, m), (r,): orthonormal rows, as in `cone_program.minimise`.
    start
        (m,) strictly feasible.
    G, offset
        (2, m), (2,): the point that x stands for.
    tol
        Wanted distance between the polygons, in the units of G x.
    directions, heights, points
        (most, 2), (most,), (most, 2): outputs, counter-clockwise: directions, with the region inside
        directions[k].q <= heights[k], and the point reached along each.

    Returns
    -------
    tuple[int, int, float]
        Outcome, number of directions, estimated gap.
    """
    r, m = B.shape
    most = heights.size
    x, y, z, c = np.empty(m), np.empty(r), np.empty(m), np.empty(m)
    count, at = 0, 0
    most_force = _most_force(B, b, lorentz, start, x, y, z, c)
    if most_force == math.inf:
        return WITHOUT_BOUND, count, math.inf
    # start with the four axes: any bounded region has a support there
    for k in range(4):
        directions[k, 0], directions[k, 1] = math.cos(0.5 * math.pi * k), math.sin(0.5 * math.pi * k)
    pending, total, gap = 0, 4, math.inf
    while True:
        while pending < total:
            k = at if total > 4 else pending
            dx, dy = directions[k, 0], directions[k, 1]
            # the farthest point along d: minimise -d·(G x + offset)
            for i in range(m):
                c[i] = -(dx * G[0, i] + dy * G[1, i])
                x[i] = start[i]
            # The objective is brought to size one, so that the tolerance of the program is one of distances.
            size = math.sqrt(dot(c, c))
            size = size if size > 0.0 else 1.0
            for i in range(m):
                c[i] /= size
            status, _ = minimise(B, b, c, lorentz, x, y, z, GAP + 1e-5 * tol / size, -1e7, 0.0, IN_ONE, c[:0])
            if status == UNBOUNDED:
                return WITHOUT_BOUND, count, math.inf
            for q in range(2):
                points[k, q] = offset[q] + dot(G[q], x)
            # the half-plane comes from the dual, which proves it; the point is inside whatever the solver did
            value, lack = _lower_bound(B, b, c, lorentz, y)
            # d.q = d.offset - size c.x, and c.x >= b.y - lack sum(x) for every x of the program, solved or
            # not.
            heights[k] = dx * offset[0] + dy * offset[1] - size * (value - lack * most_force)
            heights[k] = max(heights[k], dx * points[k, 0] + dy * points[k, 1])
            pending += 1
        count = total
        # next where the polygon of half-planes stands out the most
        gap, at = _widest_gap(directions, heights, points, count)
        if gap <= tol:
            return TRACED, count, gap
        if count == most or at < 0 or not _insert(directions, heights, points, count, at):
            return OUT_OF_DIRECTIONS, count, gap
        at += 1
        total += 1


@inline_kernel
def _widest_gap(
    directions: FloatArray, heights: FloatArray, points: FloatArray, count: int
) -> tuple[float, int]:
    """Return the largest distance of an outer corner from its inner edge, and the edge to go on from.

    That is the one with the largest distance of those that a further direction can mend; -1 if there are
    none.
    """
    widest, mendable, at = 0.0, 0.0, -1
    for k in range(count):
        n = (k + 1) % count
        qx, qy = _corner(
            directions[k, 0], directions[k, 1], heights[k],
            directions[n, 0], directions[n, 1], heights[n], points[k, 0], points[k, 1],
        )  # fmt: skip
        # Between two directions the region lies between the points reached and the corner of their
        # half-planes: no point of it is farther from the inner polygon than that corner.
        d = to_segment(qx, qy, points[k, 0], points[k, 1], points[n, 0], points[n, 1])
        widest = max(widest, d)
        # A half-plane that stands off its own point by as much came out of a program that was not solved to
        # the end. One more direction leaves that as it is: the edge counts for the gap, and is not gone on
        # from.
        if d > mendable and d > _MENDABLE * max(
            _play(directions, heights, points, k), _play(directions, heights, points, n)
        ):
            mendable, at = d, k
    return widest, at


@inline_kernel
def _play(directions: FloatArray, heights: FloatArray, points: FloatArray, k: int) -> float:
    """Return how far the half-plane of a direction is from the point reached: what no search can close."""
    return float(heights[k] - directions[k, 0] * points[k, 0] - directions[k, 1] * points[k, 1])


@inline_kernel
def _insert(directions: FloatArray, heights: FloatArray, points: FloatArray, count: int, at: int) -> bool:
    """Make room after entry `at` for a direction normal to the inner edge there; False if there is none.

    Where the edge has no length, or its normal is one of the two directions already, the direction
    halfway between them serves.
    """
    n = (at + 1) % count
    dx, dy = points[n, 0] - points[at, 0], points[n, 1] - points[at, 1]
    length = math.hypot(dx, dy)
    nx, ny = 0.0, 0.0
    # The normal must lie strictly between the neighbours' directions: half-planes are in order of their
    # angle.
    usable = length > 0.0
    if usable:
        nx, ny = dy / length, -dx / length
        before = directions[at, 0] * ny - directions[at, 1] * nx
        after = nx * directions[n, 1] - ny * directions[n, 0]
        usable = before > 1e-9 and after > 1e-9
    if not usable:
        nx, ny = directions[at, 0] + directions[n, 0], directions[at, 1] + directions[n, 1]
        length = math.hypot(nx, ny)
        nx, ny = nx / length, ny / length
        if abs(directions[at, 0] * ny - directions[at, 1] * nx) < 1e-9:
            return False
    for k in range(count, at + 1, -1):
        heights[k] = heights[k - 1]
        for q in range(2):
            directions[k, q], points[k, q] = directions[k - 1, q], points[k - 1, q]
    directions[at + 1, 0], directions[at + 1, 1] = nx, ny
    return True
