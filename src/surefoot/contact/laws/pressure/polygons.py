"""Flat convex polygons in space: clipping by linear functions, and integrals over them."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray

_A, _B = 0.445948490915965, 0.091576213509771
_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
_PLACES = np.array([[1.0 - 2.0 * s if i == j else s for j in range(3)] for s in (_A, _B) for i in range(3)])
"""Dunavant's rule of degree 4 on a triangle: exact for a pressure of degree two and its first moments."""


def clipped(polygon: FloatArray, values: FloatArray) -> FloatArray:
    """Return the part of a polygon (k, 3) where a linear function, `values` (k,) at its corners, is >= 0."""
    if (values >= 0.0).all():
        return polygon
    if (values < 0.0).all():
        return polygon[:0]
    out = []
    for a, b, x, y in zip(polygon, np.roll(polygon, -1, 0), values, np.roll(values, -1), strict=True):
        if x >= 0.0:
            out.append(a)
        if (x >= 0.0) != (y >= 0.0):
            out.append(a + x / (x - y) * (b - a))
    return np.array(out) if len(out) >= 3 else polygon[:0]


def fans(polygons: list[FloatArray]) -> FloatArray:
    """Return the triangles (t, 3, 3) of convex polygons."""
    parts = [np.stack([np.broadcast_to(p[0], (len(p) - 2, 3)), p[1:-1], p[2:]], axis=1) for p in polygons]
    return np.concatenate(parts) if parts else np.zeros((0, 3, 3))


def nodes(triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (t, 6, 3) and weights (t, 6) [m²] that integrate over triangles (t, 3, 3)."""
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=-1)
    return np.einsum("nj,tjd->tnd", _PLACES, triangles), areas[:, None] * _WEIGHTS


def nodes_about(
    centre: FloatArray, polygon: FloatArray, normal: FloatArray, along: int = 24, out: int = 8
) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and signed weights (n,) that integrate over a polygon what turns about a point.

    The polygon is the signed sum of the triangles that its edges make with the centre; on rays from there a
    direction of sliding is constant, and Gauss's rule exact; edges are cut below the centre, where the
    direction turns fastest.
    """
    starts, ends = polygon, np.roll(polygon, -1, 0)
    edges = ends - starts
    squares = np.maximum((edges * edges).sum(-1), 1e-300)
    foot = np.clip(((centre - starts) * edges).sum(-1) / squares, 0.0, 1.0)[:, None]
    middle = starts + foot * edges
    starts, ends = np.concatenate([starts, middle]), np.concatenate([middle, ends])
    t, wt = np.polynomial.legendre.leggauss(along)
    s, ws = np.polynomial.legendre.leggauss(out)
    t, wt, s, ws = 0.5 * (t + 1.0), 0.5 * wt, 0.5 * (s + 1.0), 0.5 * ws
    # t^3 draws the points to the foot of the perpendicular, at the start of every second half
    first = np.arange(len(starts)) < len(polygon)
    near, slope = t**3, 3.0 * t**2 * wt
    share = np.where(first[:, None], 1.0 - near, near)
    rim = starts[:, None] + share[..., None] * (ends - starts)[:, None]
    double = np.cross(starts - centre, ends - centre) @ normal
    points = centre + s[:, None] * (rim[:, :, None] - centre)
    weights = double[:, None, None] * slope[None, :, None] * (s * ws)
    return points.reshape(-1, 3), weights.ravel()
