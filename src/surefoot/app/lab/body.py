"""A robot as shapes: its visual meshes, coarsened where they are many; lines between joints without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.drawing import Shape
from surefoot.app.lab.geometry import join_surfaces, pose_of
from surefoot.app.viz.meshes import triangles
from surefoot.app.viz.shapes import bones
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics import Robot

MOST_TRIANGLES = 100_000
"""A robot with no more is drawn as it is: 2 MB for the browser."""
CELLS = (0.0, 0.002, 0.004, 0.006, 0.01, 0.02)
"""Vertices nearer to each other than this are drawn as one [m]: the first with few enough triangles."""
SPECK = 0.03
"""Radius of what has neither shapes nor bones [m]."""
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
    whole: list[tuple[int, FloatArray, IntArray]] = []
    for item in robot.visual.geometryObjects:
        made = _surface(item)
        if made is not None:
            local = made[0] @ np.array(item.placement.rotation).T + np.array(item.placement.translation)
            whole.append((int(item.parentJoint), local, made[1]))
    parts: dict[int, list[tuple[FloatArray, IntArray]]] = {}
    for cell in CELLS:
        parts = {}
        for joint, vertices, faces in whole:
            parts.setdefault(joint, []).append(coarse(vertices, faces, cell))
        if sum(len(faces) for pieces in parts.values() for _, faces in pieces) <= MOST_TRIANGLES:
            break
    return tuple(Link(joint, *join_surfaces(pieces)) for joint, pieces in sorted(parts.items()))


def coarse(vertices: FloatArray, faces: IntArray, cell: float) -> tuple[FloatArray, IntArray]:
    """Return (k, 3) vertices that are the means of those in one `cell` of a grid [m], and (m, 3) triangles.

    Vertex clustering: Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex
    scenes", 1993, by the octant of a vertex's normal as well: the two sides of a thin wall would else be
    one, whose shading has no direction. Triangles that lose their area are left out, and so are doubles. As
    they are with a cell of 0.
    """
    if not cell:
        return vertices, faces
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = np.column_stack(
        [np.bincount(faces.ravel(), np.repeat(across[:, k], 3), len(vertices)) for k in range(3)]
    )
    keys = np.column_stack([np.round(vertices / cell), normals >= 0.0])
    _, owner, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    owner = owner.ravel()
    middle = np.column_stack([np.bincount(owner, vertices[:, k]) for k in range(3)]) / count[:, None]
    joined = owner[faces]
    i, j, k = joined.T
    kept = joined[(i != j) & (j != k) & (k != i)]
    _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
    return middle, kept[np.sort(first)]


def _surface(item: Any) -> tuple[FloatArray, IntArray] | None:
    """Return vertices and triangles of a geometry object in its own frame; None for what cannot be drawn."""
    kind, shape = type(item.geometry).__name__, item.geometry
    if kind.startswith("BVHModel"):
        return triangles(item) if shape.num_vertices > 3 else None
    if kind not in _FORMS:
        return None
    from trimesh import creation  # viser brings it

    form, sizes = _FORMS[kind]
    mesh = getattr(creation, form)(**sizes(shape))
    return np.array(mesh.vertices), np.array(mesh.faces)


_FORMS: dict[str, tuple[str, Callable[[Any], dict[str, Any]]]] = {
    "Box": ("box", lambda s: {"extents": 2.0 * np.array(s.halfSide)}),
    "Sphere": ("icosphere", lambda s: {"radius": s.radius, "subdivisions": 2}),
    "Cylinder": ("cylinder", lambda s: {"radius": s.radius, "height": 2.0 * s.halfLength}),
    "Capsule": ("capsule", lambda s: {"radius": s.radius, "height": 2.0 * s.halfLength, "count": (16, 16)}),
}
"""Class of coal to trimesh's function that makes its surface, about the shape's own frame, and its sizes."""
