"""A robot as shapes: its visual meshes, coarsened for the browser; lines from joint to joint without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.lab import drawing as draw
from surefoot.lab.drawing import Shape
from surefoot.lab.geometry import pose_of
from surefoot.robot import Robot
from surefoot.viz.meshes import triangles
from surefoot.viz.shapes import bones

CELL = 0.006
"""Vertices nearer to each other than this are drawn as one [m]."""
SPECK = 0.03
"""Radius of what has neither shapes nor bones [m]."""
CIRCLE = 16
"""Sides of what is round."""
SHADES = ((64, 71, 82), (115, 125, 138), (84, 94, 107))


@dataclass(frozen=True, eq=False)
class Link:
    """What is fixed to a joint: (n, 3) vertices in the joint's frame [m] and (m, 3) triangles."""

    joint: int
    vertices: FloatArray
    faces: IntArray


class RobotBody:
    """Draws a robot at any configuration.

    Parameters
    ----------
    robot
        Whose visual geometry it is. Its data are not touched: a body has its own.

    Attributes
    ----------
    links
        See `links_of`.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.links = links_of(robot)
        self._data = robot.model.createData()

    def shapes(self, q: FloatArray, held: bool = False) -> dict[str, Shape]:
        """Return the shapes at a (nq,) configuration [m, -, rad]; `held` for the mouse."""
        import pinocchio

        if not self.links:
            lines = bones(self.robot, q)
            if np.ptp(lines, axis=1).any():
                return {"/robot/bones": draw.Lines(lines, draw.BODY, 6.0)}
            radius = max([*self.robot.contact_points.radii.tolist(), SPECK])  # a point mass, a ball
            return {"/robot/ball": draw.Ball(self.robot.com(q), radius, draw.BODY)}
        model, data = self.robot.model, self._data
        pinocchio.forwardKinematics(model, data, np.asarray(q, dtype=np.float64))
        out: dict[str, Shape] = {}
        for link in self.links:
            pose = data.oMi[link.joint]
            x, y, z = np.array(pose.translation).tolist()
            shade, turn = SHADES[link.joint % len(SHADES)], pose_of(np.array(pose.rotation))
            name = f"/robot/{model.names[link.joint]}"
            out[name] = draw.Mesh(link.vertices, link.faces, shade, 1.0, (x, y, z), turn, held)
        return out


@lru_cache(maxsize=8)
def links_of(robot: Robot) -> tuple[Link, ...]:
    """Return a link for each joint with something to see; none without visual geometry."""
    parts: dict[int, list[tuple[FloatArray, IntArray]]] = {}
    for item in robot.visual.geometryObjects:
        made = _surface(item)
        if made is not None:
            local = made[0] @ np.array(item.placement.rotation).T + np.array(item.placement.translation)
            parts.setdefault(int(item.parentJoint), []).append((local, made[1]))
    return tuple(Link(joint, *_joined(pieces)) for joint, pieces in sorted(parts.items()))


def _joined(pieces: list[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return several surfaces as one."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in pieces[:-1])])
    faces = [faces + offset for (_, faces), offset in zip(pieces, offsets, strict=True)]
    return np.vstack([vertices for vertices, _ in pieces]), np.vstack(faces)


def coarse(vertices: FloatArray, faces: IntArray, cell: float) -> tuple[FloatArray, IntArray]:
    """Return (k, 3) vertices that are the means of those in one `cell` of a grid [m], and (m, 3) triangles.

    Vertex clustering: Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex
    scenes", 1993. Triangles that lose their area are left out, and so are doubles.
    """
    _, owner, count = np.unique(np.round(vertices / cell), axis=0, return_inverse=True, return_counts=True)
    owner = owner.ravel()
    middle = np.column_stack([np.bincount(owner, vertices[:, k]) for k in range(3)]) / count[:, None]
    joined = owner[faces]
    a, b, c = joined.T
    kept = joined[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
    return middle, kept[np.sort(first)]


def _surface(item: Any) -> tuple[FloatArray, IntArray] | None:
    """Return vertices and triangles of a geometry object in its own frame; None for what cannot be drawn."""
    kind, shape = type(item.geometry).__name__, item.geometry
    if kind.startswith("BVHModel"):
        return coarse(*triangles(item), CELL) if shape.num_vertices > 3 else None
    points = _POINTS.get(kind)
    return None if points is None else _hull(points(shape))


def _hull(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the convex hull of (n, 3) points as a surface."""
    from scipy.spatial import ConvexHull

    return points, np.array(ConvexHull(points).simplices, dtype=np.int64)


def _ring(radius: float, height: float) -> FloatArray:
    angle = 2.0 * np.pi * np.arange(CIRCLE) / CIRCLE
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(CIRCLE, height)])


def _ball(radius: float, stretch: float = 0.0) -> FloatArray:
    """Return points of a ball whose halves are `stretch` above and below its middle [m]."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, CIRCLE)
    rings = [
        _ring(max(radius * np.cos(a), 1e-4 * radius), radius * np.sin(a) + np.sign(a) * stretch)
        for a in angles
    ]
    return np.vstack(rings)


_POINTS: dict[str, Callable[[Any], FloatArray]] = {
    "Box": lambda s: (
        np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(s.halfSide)
    ),
    "Sphere": lambda s: _ball(s.radius),
    "Cylinder": lambda s: np.vstack([_ring(s.radius, -s.halfLength), _ring(s.radius, s.halfLength)]),
    "Capsule": lambda s: _ball(s.radius, s.halfLength),
}
"""Points whose convex hull is a shape, by the name of coal's class."""
