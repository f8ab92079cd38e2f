"""The collision shapes of a foot as points with radii: each is the hull of balls about its points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray

ROUND = 32
"""Points on the rim of a cylinder."""
LYING = 0.17
"""A cylinder lies on its side if its axis is no steeper than this, sine of 10 degrees."""


@dataclass(frozen=True, eq=False)
class FootPart:
    """One shape of a foot, in the frame of the foot.

    Attributes
    ----------
    name
        Of the shape, as the file or its parser has it.
    kind
        "sphere", "capsule", "box", "cylinder", "ellipsoid", "cone" or "mesh".
    points
        (k, 3) points whose balls' hull is the shape [m].
    radius
        Of those balls [m]; zero for shapes with corners.
    axis
        (3,) along a capsule or cylinder; zeros for others.
    """

    name: str
    kind: str
    points: FloatArray
    radius: float
    axis: FloatArray


def foot_part(item: Any, foot_from_item: Any, up: FloatArray) -> FootPart | None:
    """Return a GeometryObject of Pinocchio as a part of a foot, None for shapes without an end.

    Parameters
    ----------
    item
        The GeometryObject.
    foot_from_item
        Pinocchio's SE3 of the shape in the foot's frame.
    up
        (3,) the vertical in the foot's frame.
    """
    shape, kind = item.geometry, type(item.geometry).__name__
    local = foot_from_item.rotation.T @ up
    radius = 0.0
    if kind == "Sphere":
        name, points, radius = "sphere", np.zeros((1, 3)), float(shape.radius)
    elif kind == "Capsule":
        name, points, radius = "capsule", _ends(shape), float(shape.radius)
    elif kind == "Cylinder" and abs(local[2]) < LYING:
        # on its side it touches along a line, as a capsule does
        name, points, radius = "cylinder", _ends(shape), float(shape.radius)
    elif kind in ("Cylinder", "Cone"):
        top = 1.0 if kind == "Cylinder" else 0.0
        rim = float(shape.radius) * _circle(ROUND)
        half = np.full((ROUND, 1), float(shape.halfLength))
        name, points = kind.lower(), np.vstack([np.hstack([rim, -half]), np.hstack([top * rim, half])])
    elif kind == "Box":
        signs = np.array(np.meshgrid([1.0, -1.0], [1.0, -1.0], [1.0, -1.0])).reshape(3, -1).T
        name, points = "box", signs * np.array(shape.halfSide)
    elif kind == "Ellipsoid":
        turns = np.linspace(-0.5, 0.5, ROUND // 2)[:, None] * np.pi
        ring = np.hstack([np.cos(turns), np.zeros_like(turns), np.sin(turns)])
        c, s = _circle(ROUND).T
        ball = np.vstack([ring[:, :1] * c, ring[:, :1] * s, np.repeat(ring[:, 2:], ROUND, axis=1)])
        name, points = "ellipsoid", ball.reshape(3, -1).T * np.array(shape.radii)
    elif kind.startswith(("BVHModel", "Convex")):
        name, points = "mesh", vertices(shape)
    else:
        return None
    if not len(points) or not np.isfinite(points).all():
        return None
    axis = foot_from_item.rotation[:, 2] * (1.0 if kind in ("Capsule", "Cylinder") else 0.0)
    placed = points @ foot_from_item.rotation.T + foot_from_item.translation
    return FootPart(str(item.name), name, placed, radius, axis)


def vertices(shape: Any) -> FloatArray:
    """Return the (k, 3) corners of one of coal's meshes or hulls [m]."""
    if hasattr(shape, "num_vertices"):
        return np.array([shape.vertex(k) for k in range(shape.num_vertices)], dtype=np.float64).reshape(-1, 3)
    return np.array([shape.point(k) for k in range(shape.num_points)], dtype=np.float64).reshape(-1, 3)


def _ends(shape: Any) -> FloatArray:
    """Return the ends of an axis along z: (2, 3)."""
    half = float(shape.halfLength)
    return np.array([[0.0, 0.0, half], [0.0, 0.0, -half]])


def _circle(count: int) -> FloatArray:
    """Return (count, 2) points of the unit circle."""
    turns = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(turns), np.sin(turns)])


def disc_points(points: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the outlines of discs about (k, 2) points as points: (m, 2) [m]."""
    sharp = points[radii <= 0.0]
    discs = [p + r * _circle(16) for p, r in zip(points, radii, strict=True) if r > 0.0]
    return np.vstack([sharp, *discs])


def describe(parts: Iterable[FootPart]) -> str:
    """Return parts in words: "4 spheres and a box", with the names of meshes."""
    kinds: dict[str, list[str]] = {}
    for part in parts:
        kinds.setdefault(part.kind, []).append(part.name)
    words = []
    for kind, names in kinds.items():
        many = f"{len(names)} {kind}{'es' if kind in ('box', 'mesh') else 's'}"
        words.append(many if len(names) > 1 else f"the {kind} {names[0]}")
    return " and ".join(words)
