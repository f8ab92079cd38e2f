"""The corners of a sole, in order, and what its kernels want to know of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError

FLAT = 1e-6
"""Least width of a sole as a share of its length [-]: below it the corners count as a line."""
SIDES = ("toe", "left", "heel", "right")
"""Names of the edges whose outward normals point along +x, +y, -x and -y of the contact frame."""


def outline(corners: ArrayLike) -> FloatArray:
    """Return the corners (k, 2) [m] of the convex hull of (n, 2) points, clockwise from the front left.

    Points within the hull are left out: a force there is a sum of forces at the corners in the same cone.

    Raises
    ------
    ProblemError
        For values that are not finite, or points that lie on one line.
    """
    points = finite_array("corners", corners, (None, 2))
    middle = points.mean(axis=0) if len(points) else np.zeros(2)
    size = float(np.abs(points - middle).max(initial=0.0))
    kept = _hull((points - middle) / size) if size > 0.0 else np.zeros((0, 2))
    if len(kept) < 3:
        raise ProblemError(
            f"a sole needs three corners that are not in one line, got {points.tolist()!s:.100}; "
            "a line is two sf.PointContact"
        )
    # clockwise, beginning at the corner that is farthest to the front left
    kept = kept[::-1]
    first = int(np.argmax(np.round(kept @ [1.0, 1.0], 9)))
    return np.asarray(np.roll(kept, -first, axis=0) * size + middle)


def _hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of points of size one, counter-clockwise (Andrew's chain)."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]
    halves: list[FloatArray] = []
    for sequence in (ordered, ordered[::-1]):
        chain: list[FloatArray] = []
        for p in sequence:
            while len(chain) >= 2 and _turn(chain[-2], chain[-1], p) <= FLAT * 1e-3:
                chain.pop()
            chain.append(p)
        halves.extend(chain[:-1])
    kept = np.array(halves)
    spread = np.linalg.svd(kept - kept.mean(axis=0), compute_uv=False)
    return kept if len(kept) >= 3 and spread[-1] > FLAT * spread[0] else np.zeros((0, 2))


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Return twice the area of a triangle, positive where it turns left."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def middle_of(corners: FloatArray) -> tuple[FloatArray, float]:
    """Return the mean (2,) of corners (k, 2) and the largest distance of one from it [m]."""
    centre = corners.mean(axis=0)
    return centre, float(np.sqrt(((corners - centre) ** 2).sum(axis=1)).max())


def outward(corners: FloatArray) -> FloatArray:
    """Return the outward normals (k, 2) of the edges from each of the corners, clockwise, to the next one."""
    along = np.roll(corners, -1, axis=0) - corners
    return np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(along[:, 0], along[:, 1])[:, None]


def edge_names(normals: FloatArray) -> tuple[str, ...]:
    """Return a name for each edge with outward normals (k, 2): its side, numbered where it has several.

    >>> edge_names(np.array([[1.0, 0.0], [0.0, -1.0], [-1.0, 0.2], [-1.0, -0.2], [0.0, 1.0]]))
    ('toe edge', 'right edge', 'heel edge 1', 'heel edge 2', 'left edge')
    """
    turn = np.arctan2(normals[:, 1], normals[:, 0])
    sides = [SIDES[int(np.round(a / (0.5 * math.pi) + 1e-9)) % 4] for a in turn]
    seen: dict[str, int] = {}
    names = []
    for side in sides:
        seen[side] = seen.get(side, 0) + 1
        names.append(f"{side} edge {seen[side]}" if sides.count(side) > 1 else f"{side} edge")
    return tuple(names)


@dataclass(frozen=True, eq=False)
class SoleShape:
    """What the kernels know of a sole's corners, over its length.

    Attributes
    ----------
    centre, length
        (2,) mean of the corners and the largest distance of one from it [m].
    table
        (k, 4): each corner (x, y), and its levers (y, -x) for the moments of a normal force [-].
    start
        (k, 4, 5): least corner forces for a wrench's other five numbers, see `sole_program.begin`.
    edges
        (k, 2): row @ (m_x, m_y) is the normal force that an edge takes for these moments.
    """

    centre: FloatArray
    length: float
    table: FloatArray
    start: FloatArray
    edges: FloatArray


def shape_of(corners: FloatArray, torsional_radius: float) -> SoleShape:
    """Return the shape of corners (k, 2) [m] in the order of `outline`."""
    centre, length = middle_of(corners)
    q = (corners - centre) / length
    k, radius = len(q), torsional_radius / length
    give = np.zeros((5, k, 4))
    give[0, :, 1] = give[1, :, 2] = 1.0
    give[2, :, 0], give[3, :, 0] = q[:, 1], -q[:, 0]
    give[4, :, 1], give[4, :, 2], give[4, :, 3] = -q[:, 1], q[:, 0], radius
    start = np.linalg.pinv(give.reshape(5, 4 * k)).reshape(k, 4, 5)
    normals = outward(q)
    far = (normals * q).sum(axis=1)
    # pressure at (-m_y, m_x) / f_z beyond an edge at distance `far`
    edges = np.column_stack([normals[:, 1], -normals[:, 0]]) / far[:, None]
    table = np.ascontiguousarray(np.column_stack([q, q[:, 1], -q[:, 0]]))
    return SoleShape(centre, length, table, np.ascontiguousarray(start), np.ascontiguousarray(edges))
