"""Flat outlines: hulls, their area, and the largest rectangle inside."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray

CUTS = 65
"""Lines across an outline between which rectangles are sought, besides those through its corners."""
ROUNDING = 1e-9
"""Extents below this are none [m]."""


def hull_of(points: FloatArray) -> FloatArray:
    """Return the corners of the hull of (k, 2) points, around it; both ends, or one, of flat ones."""
    from scipy.spatial import ConvexHull, QhullError

    middle = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = (points - middle) @ axes[0]
    ends = points[[int(along.argmin()), int(along.argmax())]]
    if len(points) < 3 or spread.size < 2 or spread[1] < ROUNDING:
        return ends if np.ptp(along) > ROUNDING else ends[:1]
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return ends


def few_corners(hull: FloatArray, most: int, lost: float) -> FloatArray:
    """Return (k, 2) of the corners of a hull, around it: those whose polygon is nearly as large.

    One after the other the corner with the smallest triangle is left out, while more than `most` are left or
    all that are out make less than the share `lost` of the area. Each corner that is left is then moved along
    the hull to where the polygon is largest, until none gains; the polygon is inside the hull.
    """
    kept, area, out = list(range(len(hull))), area_of(hull), 0.0
    while len(kept) > 3:
        sizes = [_triangle(hull, kept[k - 1], kept[k], kept[(k + 1) % len(kept)]) for k in range(len(kept))]
        least = int(np.argmin(sizes))
        out += sizes[least]
        if len(kept) <= most and out > lost * area:
            break
        kept.pop(least)
    for _ in range(len(hull)):
        before = list(kept)
        for k in range(len(kept)):
            first, last = kept[k - 1], kept[(k + 1) % len(kept)]
            between = [(first + j) % len(hull) for j in range(1, (last - first) % len(hull))]
            sizes = [_triangle(hull, first, i, last) for i in between]
            if max(sizes) > (1.0 + ROUNDING) * _triangle(hull, first, kept[k], last):
                kept[k] = between[int(np.argmax(sizes))]
        if kept == before:
            break
    return np.asarray(hull[kept])


def _triangle(points: FloatArray, i: int, j: int, k: int) -> float:
    """Return the area of the triangle of three of (n, 2) points [m²]."""
    a, b = points[i] - points[j], points[k] - points[j]
    return 0.5 * float(abs(a[0] * b[1] - a[1] * b[0]))


def moved_in(corners: FloatArray, distance: float) -> FloatArray:
    """Return the corners (k, 2) of a convex polygon whose edges are moved inwards by a distance [m].

    Edges that vanish on the way are left out; the polygon has to be wider than that.
    """
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    hull = ConvexHull(corners)
    rows = hull.equations + np.array([0.0, 0.0, distance])
    middle = corners[hull.vertices].mean(axis=0)
    points = HalfspaceIntersection(rows, middle).intersections
    return hull_of(np.unique(np.round(points, 9), axis=0))


def cut_of(points: FloatArray, height: float) -> FloatArray:
    """Return where the edges of the hull of (k, 3) points go through a height: (m, 2), none for flat ones."""
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4 or points[:, 2].max() <= height:
        return np.zeros((0, 2))
    try:
        faces = ConvexHull(points).simplices
    except QhullError:
        return np.zeros((0, 2))
    a, b = points[faces].reshape(-1, 3), points[np.roll(faces, -1, axis=1)].reshape(-1, 3)
    through = (a[:, 2] <= height) & (b[:, 2] > height) | (b[:, 2] <= height) & (a[:, 2] > height)
    a, b = a[through], b[through]
    return np.asarray(a[:, :2] + ((height - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None] * (b - a)[:, :2])


def area_of(corners: FloatArray) -> float:
    """Return the area inside (k, 2) corners around an outline [m²]."""
    x, y = (corners - corners.mean(axis=0)).T
    return 0.5 * float(abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))


def centroid_of(corners: FloatArray) -> FloatArray:
    """Return the centre (2,) of the area inside (k, 2) corners around an outline [m]."""
    middle = corners.mean(axis=0)
    a = corners - middle
    b = np.roll(a, -1, axis=0)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.asarray(middle + twice @ (a + b) / (3.0 * twice.sum()))


def inner_rectangle(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the corners, (2,) each, of the largest rectangle along the axes in (k, 2) corners of a hull [m].

    Exact for outlines whose largest rectangle has its sides through corners; else to a cut's width.
    """
    x = corners[:, 0]
    cuts = np.unique(np.concatenate([x, np.linspace(x.min(), x.max(), CUTS)]))
    low, high = _chords(corners, cuts)
    top = np.minimum(high[:, None], high[None, :])
    bottom = np.maximum(low[:, None], low[None, :])
    areas = np.where(top > bottom, (top - bottom) * (cuts[None, :] - cuts[:, None]), 0.0)
    i, j = np.unravel_index(int(areas.argmax()), areas.shape)
    return np.array([cuts[i], bottom[i, j]]), np.array([cuts[j], top[i, j]])


def _chords(corners: FloatArray, cuts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where lines x = cut meet a convex outline: lowest and highest y of each."""
    low, high = np.full(len(cuts), np.inf), np.full(len(cuts), -np.inf)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        on = (cuts >= min(x0, x1) - ROUNDING) & (cuts <= max(x0, x1) + ROUNDING)
        if abs(x1 - x0) < ROUNDING:
            ys = np.array([y0, y1])
            low[on], high[on] = np.minimum(low[on], ys.min()), np.maximum(high[on], ys.max())
            continue
        y = y0 + np.clip((cuts[on] - x0) / (x1 - x0), 0.0, 1.0) * (y1 - y0)
        low[on], high[on] = np.minimum(low[on], y), np.maximum(high[on], y)
    return low, high


def turned_rectangle(corners: FloatArray, turn: float) -> tuple[float, FloatArray, FloatArray]:
    """Return area [m²] and corners, (2,) each, of the largest rectangle in (k, 2) corners, turned [rad]."""
    c, s = np.cos(turn), np.sin(turn)
    low, high = inner_rectangle(corners @ np.array([[c, -s], [s, c]]))
    return float(np.prod(high - low)), low, high
