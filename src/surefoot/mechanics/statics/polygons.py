"""Convex polygons of the plane, compiled: hulls, intersections of half-planes, and the gap between two.

Points, segments and needles are polygons too, with one, two or almost collinear corners. Nothing here divides
by an angle between neighbouring lines, so that nearly parallel ones cost no digits.

By hand though Shapely and Qhull exist, for the gap is a promise. Shapely 2.2 clips a segment that lies
across the axes down to a point, and takes 0.9 ms for what `enclose` does in 16 us (24 half-planes); Qhull
refuses points on a line. Regions of two feet, and at friction's limit, are such segments.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel


@inline_kernel
def _turn(p: FloatArray, a: int, b: int, c: int) -> float:
    """Return twice the signed area of a triangle of points, positive counter-clockwise."""
    return float((p[b, 0] - p[a, 0]) * (p[c, 1] - p[a, 1]) - (p[b, 1] - p[a, 1]) * (p[c, 0] - p[a, 0]))


@inline_kernel
def to_segment(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the distance of (x, y) from the segment a-b, in the unit of both."""
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    s = 0.0
    if length > 0.0:
        s = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / length))
    return math.hypot(x - ax - s * dx, y - ay - s * dy)


@kernel
def hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of (n, 2) points [m], counter-clockwise (Andrew's chain).

    Corners that stand out by less than rounding are left out; equal points count once. The chain runs along
    the longer side, so that points of a line keep both its ends.
    """
    n, turned = len(points), np.empty_like(points)
    wide = points[:, 0].max() - points[:, 0].min() if n else 0.0
    tall = points[:, 1].max() - points[:, 1].min() if n else 0.0
    for k in range(n):
        turned[k, 0] = points[k, 0] if wide >= tall else points[k, 1]
        turned[k, 1] = points[k, 1] if wide >= tall else -points[k, 0]
    order = np.argsort(turned[:, 0])
    for k in range(1, n):  # by the second coordinate where the first is the same
        i, at = order[k], k
        u, v = turned[i, 0], turned[i, 1]
        while at > 0 and turned[order[at - 1], 0] == u and turned[order[at - 1], 1] > v:
            order[at] = order[at - 1]
            at -= 1
        order[at] = i
    kept = 0
    for k in range(n):
        i, j = order[k], order[max(0, kept - 1)]
        if kept == 0 or turned[i, 0] != turned[j, 0] or turned[i, 1] != turned[j, 1]:
            order[kept] = i
            kept += 1
    if kept <= 2:
        return points[order[:kept]]
    # A turn is twice an area: rounding makes one of some eps times the square of the extent.
    flat = 1e-14 * max(wide, tall) ** 2
    chain, size = np.empty(2 * kept, dtype=np.int64), 0
    # the lower chain, then the upper one
    for side in range(2):
        first = size
        for k in range(kept):
            i = order[k] if side == 0 else order[kept - 1 - k]
            while size >= first + 2 and _turn(turned, chain[size - 2], chain[size - 1], i) <= flat:
                size -= 1
            chain[size] = i
            size += 1
        size -= 1
    return points[chain[:size]]


@kernel
def without_flat_corners(polygon: FloatArray, slack: float) -> FloatArray:
    """Drop corners of a convex polygon (k, 2) within `slack` [m] of the segment between their neighbours."""
    count = len(polygon)
    after, before = np.arange(1, count + 1) % count, np.arange(-1, count - 1) % count
    left = count
    for k in range(count):
        if left <= 1:
            break
        a, c = before[k], after[k]
        ax, ay, cx, cy = polygon[a, 0], polygon[a, 1], polygon[c, 0], polygon[c, 1]
        if to_segment(polygon[k, 0], polygon[k, 1], ax, ay, cx, cy) <= slack:
            after[a], before[c] = c, a
            before[k] = -1
            left -= 1
    return polygon[before >= 0]


@kernel
def intersection(directions: FloatArray, heights: FloatArray, middle: FloatArray, reach: float) -> FloatArray:
    """Return the corners (k, 2) of {p : directions @ p <= heights} inside a square about the middle (2,).

    Clipped one half-plane after the other, (h, 2) directions and (h,) heights (Sutherland and Hodgman 1974).
    Empty where nothing is left, up to rounding.
    """
    # Each half-plane cuts a convex polygon twice at most: one corner more than before.
    most = len(heights) + 5
    corners, other, level = np.empty((most, 2)), np.empty((most, 2)), np.empty(most)
    corners[:4] = np.array([[-reach, -reach], [reach, -reach], [reach, reach], [-reach, reach]])
    count = 4
    for k in range(len(heights)):
        h = heights[k] - directions[k, 0] * middle[0] - directions[k, 1] * middle[1]
        for i in range(count):
            level[i] = directions[k, 0] * corners[i, 0] + directions[k, 1] * corners[i, 1] - h
        size = 0
        for i in range(count):
            j = i - 1 if i > 0 else count - 1
            # Levels are signed distances outside: corners within stay, and edges that cross give the
            # crossing.
            s, t = level[i], level[j]
            if s * t < 0.0 and size < most:
                share = t / (t - s)
                for q in range(2):
                    other[size, q] = corners[j, q] + share * (corners[i, q] - corners[j, q])
                size += 1
            if s <= 0.0 and size < most:
                other[size] = corners[i]
                size += 1
        count = size
        for i in range(count):
            corners[i, 0], corners[i, 1] = other[i, 0], other[i, 1]
    return corners[:count] + middle


@kernel
def _farthest_from(corners: FloatArray, polygon: FloatArray) -> float:
    """Return the largest distance of points (n, 2) from a convex counter-clockwise polygon (k, 2).

    Infinite for no points at all: an intersection that rounding emptied says nothing.
    """
    worst, k = 0.0 if len(corners) else math.inf, len(polygon)
    for i in range(len(corners)):
        x, y = corners[i, 0], corners[i, 1]
        # Inside is to the left of every edge; a point or a segment has no inside.
        nearest, inside = math.inf, k >= 3
        for j in range(k):
            n = (j + 1) % k
            ax, ay, bx, by = polygon[j, 0], polygon[j, 1], polygon[n, 0], polygon[n, 1]
            nearest = min(nearest, to_segment(x, y, ax, ay, bx, by))
            inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
        if not inside:
            worst = max(worst, nearest)
    return worst


@kernel
def enclose(
    points: FloatArray, directions: FloatArray, heights: FloatArray, slack: float, tol: float
) -> tuple[FloatArray, float]:
    """Return the polygon of points (k, 2) of a region, less flat corners, and its gap to the half-planes.

    Those are directions (h, 2) and heights (h,) [m] around it.

    `heights` are raised in place to hold every point, and by the rounding of the coordinates: what they
    enclose is never empty. The gap is measured between what is returned and what they enclose. Corners that
    stand out by `slack` stay in where the gap would exceed `tol` without them.
    """
    whole = hull(points)
    middle, size = np.zeros(2), 0.0
    for q in range(2):
        middle[q] = whole[:, q].mean()
        size = max(size, np.abs(whole[:, q]).max())
    reach = 0.0
    for k in range(len(heights)):
        for i in range(len(points)):
            h = directions[k, 0] * points[i, 0] + directions[k, 1] * points[i, 1]
            # A point that was reached is in the region: a half-plane that leaves it out is wrong by rounding.
            heights[k] = max(heights[k], h)
    for k in range(len(heights)):
        reach = max(reach, heights[k] - directions[k, 0] * middle[0] - directions[k, 1] * middle[1])
    pad = 1e-15 * size + 1e-14 * reach + 1e-150  # whose square is a number
    heights += pad
    outside = intersection(directions, heights, middle, 10.0 * reach + 10.0 * pad)
    inner = without_flat_corners(whole, slack)
    gap = _farthest_from(outside, inner)
    if gap + 2.0 * pad > tol:
        inner = whole
        gap = _farthest_from(outside, inner)
    return inner, gap + 2.0 * pad
