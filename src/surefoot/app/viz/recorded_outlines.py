"""Outlines of a body without joints, from the shapes that its recording keeps."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import quaternion_xyzw, rotation_from_quaternion
from surefoot.records import Log
from surefoot.worlds.replay.recorded_model import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    MESH,
    SPHERE,
    recorded_hull,
)

NEEDED = ("model_geom_types", "model_geom_sizes", "model_geom_positions", "model_geom_orientations")
"""Facts of a recording without which nothing is drawn."""
TURNS = 24
"""Corners of a circle."""


def shape_points(log: Log) -> list[FloatArray]:
    """Return points (n, 3) whose hull is a shape, in the body's axes [m], of each of its shapes."""
    if any(name not in log.facts for name in NEEDED):
        return []
    kinds, sizes, places, turns = (np.asarray(log.fact(name), dtype=np.float64) for name in NEEDED)
    out = []
    for k, kind in enumerate(kinds.astype(int).tolist()):
        points = _points(kind, sizes[k], recorded_hull(log, k))
        if len(points):
            out.append(points @ rotation_from_quaternion(quaternion_xyzw(turns[k])).T + places[k])
    return out


def outline(points: FloatArray) -> FloatArray:
    """Return the corners (k, 2) of the hull of points (n, 2); the points of a line as they are."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return points


def _points(kind: int, size: FloatArray, corners: FloatArray) -> FloatArray:
    """Return points of a shape in its own axes; none of one without a size."""
    signs = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T
    turn = np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(TURNS)], axis=1)
    rise = np.linspace(-0.5 * np.pi, 0.5 * np.pi, TURNS // 2 + 1)
    ball = (np.cos(rise)[:, None, None] * ring + np.sin(rise)[:, None, None] * [0.0, 0.0, 1.0]).reshape(-1, 3)
    if len(corners):
        return corners
    if kind == SPHERE:
        return np.asarray(ball * size[0])
    if kind == ELLIPSOID:
        return np.asarray(ball * size)
    if kind in (CAPSULE, CYLINDER):
        end = ball if kind == CAPSULE else ring
        ends = [end * size[0] + np.array([0.0, 0.0, side * size[1]]) for side in (-1.0, 1.0)]
        return np.concatenate(ends)
    return signs * size if kind in (BOX, MESH) and (size > 0.0).all() else np.zeros((0, 3))
