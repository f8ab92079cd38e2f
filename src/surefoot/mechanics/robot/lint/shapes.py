"""Measures of coal's shapes: how low one reaches, and how large it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray


def vertices(shape: Any) -> FloatArray | None:
    """Return the (n, 3) vertices of a mesh [m], None for another shape."""
    if not hasattr(shape, "num_vertices"):
        return None
    array = getattr(shape, "vertices", None)
    if callable(array):
        return np.asarray(array(), dtype=np.float64).reshape(-1, 3)
    return np.array([shape.vertex(k) for k in range(shape.num_vertices)], dtype=np.float64).reshape(-1, 3)


def lowest_point(shape: Any, place: Any) -> float | None:
    """Return the least height of a shape at an SE3 [m]; None for what has none here."""
    down, height = np.asarray(place.rotation)[2], float(place.translation[2])
    kind = type(shape).__name__
    if kind == "Sphere":
        return height - float(shape.radius)
    if kind == "Box":
        return height - float(np.abs(down) @ np.asarray(shape.halfSide))
    if kind == "Ellipsoid":
        return height - float(np.linalg.norm(down * np.asarray(shape.radii)))
    if kind == "Capsule":
        return height - abs(float(down[2])) * float(shape.halfLength) - float(shape.radius)
    if kind == "Cylinder":
        rim = float(shape.radius) * math.hypot(float(down[0]), float(down[1]))
        return height - abs(float(down[2])) * float(shape.halfLength) - rim
    corners = vertices(shape)
    return None if corners is None or not len(corners) else height + float((corners @ down).min())


def largest_size(shape: Any) -> float:
    """Return the longest side of a shape's box [m]."""
    shape.computeLocalAABB()
    box = shape.aabb_local
    return float((np.asarray(box.max_) - np.asarray(box.min_)).max())
