"""A stranger's robot as shapes, from the model that its recording keeps: no file of it is needed."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.body import SHADES
from surefoot.app.lab.drawing import Shape
from surefoot.app.lab.geometry import join_surfaces, pose_of
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import quaternion_about, quaternion_xyzw, rotation_from_quaternion
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

NEEDED = (
    "model_bodies", "model_parents", "model_positions", "model_orientations", "model_joint_kinds",
    "model_joint_bodies", "model_joint_axes", "model_joint_places", "model_geoms", "model_geom_bodies",
    "model_geom_types", "model_geom_sizes", "model_geom_positions", "model_geom_orientations",
)  # fmt: skip
"""Facts of a recording without which its robot is not drawn."""


class RecordedBody:
    """Draws the robot of a recording in a row of it.

    Parameters
    ----------
    log
        A recording whose facts have `NEEDED`, see `can_draw`.
    """

    def __init__(self, log: Log) -> None:
        self._fact = {name: log.fact(name) for name in NEEDED}
        self._log = log
        self._parents = np.asarray(self._fact["model_parents"], dtype=int).tolist()
        self._owners = np.asarray(self._fact["model_joint_bodies"], dtype=int)
        self._kinds = [str(kind) for kind in self._fact["model_joint_kinds"]]
        self._free = self._kinds[:1] == ["free"]
        self._links = self._surfaces()

    def shapes(self, q: FloatArray, origin: FloatArray) -> dict[str, Shape]:
        """Return the shapes at a (nq,) configuration [m, -, rad], seen from a (2,) place on the ground."""
        out: dict[str, Shape] = {}
        for body, (turn, place) in enumerate(self.poses(q)):
            if body in self._links:
                x, y, z = (place - [*origin, 0.0]).tolist()
                name, shade = str(self._fact["model_bodies"][body]), SHADES[body % len(SHADES)]
                out[f"/robot/{body}-{name}"] = draw.Mesh(
                    *self._links[body], shade, 1.0, (x, y, z), pose_of(turn)
                )
        return out

    def poses(self, q: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Return rotation (3, 3) and position (3,) of every link at a (nq,) configuration.

        Joints of a link turn or move it about places in its own axes, one after the other.
        """
        out: list[tuple[FloatArray, FloatArray]] = []
        at = 7 if self._free else 0
        for body, parent in enumerate(self._parents):
            if body == 0 and self._free:
                out.append((rotation_from_quaternion(q[3:7]), np.array(q[:3], dtype=np.float64)))
                continue
            own = rotation_from_quaternion(quaternion_xyzw(self._fact["model_orientations"][body]))
            place = np.asarray(self._fact["model_positions"][body], dtype=np.float64)
            if body > 0:
                place, own = out[parent][1] + out[parent][0] @ place, out[parent][0] @ own
            for k in np.flatnonzero(self._owners == body).tolist():
                axis = np.asarray(self._fact["model_joint_axes"][k], dtype=np.float64)
                if self._kinds[k + (1 if self._free else 0)] == "slide":
                    place = place + own @ axis * q[at + k]
                    continue
                anchor = np.asarray(self._fact["model_joint_places"][k], dtype=np.float64)
                turned = own @ _about(axis, float(q[at + k]))
                place, own = place + own @ anchor - turned @ anchor, turned
            out.append((own, place))
        return out

    def _surfaces(self) -> dict[int, tuple[FloatArray, IntArray]]:
        """Return link to its surface; meshes as their hulls, as boxes where the log keeps only their size."""
        parts: dict[int, list[tuple[FloatArray, IntArray]]] = {}
        fact = self._fact
        for k, body in enumerate(np.asarray(fact["model_geom_bodies"], dtype=int).tolist()):
            size = np.asarray(fact["model_geom_sizes"][k], dtype=np.float64)
            made = _surface(int(fact["model_geom_types"][k]), size, recorded_hull(self._log, k))
            if made is not None:
                turn = rotation_from_quaternion(quaternion_xyzw(fact["model_geom_orientations"][k]))
                moved = np.asarray(made.vertices) @ turn.T + np.asarray(fact["model_geom_positions"][k])
                parts.setdefault(body, []).append((moved, np.asarray(made.faces)))
        return {body: join_surfaces(pieces) for body, pieces in parts.items()}


def can_draw(log: Log) -> bool:
    """Return whether a recording keeps what its robot is drawn by: links with hinges and slides."""
    if "q" not in log or any(name not in log.facts for name in NEEDED):
        return False
    kinds = [str(kind) for kind in log.facts["model_joint_kinds"]]
    free = kinds[:1] == ["free"]
    joints = len(log.facts["model_joint_bodies"])
    simple = set(kinds[1:] if free else kinds) <= {"hinge", "slide"}
    return simple and log["q"].shape[1] == joints + (7 if free else 0)


def _surface(kind: int, size: FloatArray, corners: FloatArray) -> Any:
    """Return trimesh's surface of a shape in its own axes, or that of corners (n, 3); None for no size."""
    from trimesh import Trimesh, creation  # viser brings it

    if len(corners):
        return Trimesh(corners).convex_hull

    if kind == SPHERE:
        return creation.icosphere(radius=size[0], subdivisions=2)
    if kind == CAPSULE:
        made = creation.capsule(radius=size[0], height=2.0 * size[1], count=[16, 16])
        made.vertices -= made.bounds.mean(axis=0)
        return made
    if kind == ELLIPSOID:
        made = creation.icosphere(radius=1.0, subdivisions=2)
        made.vertices *= size
        return made
    if kind == CYLINDER:
        return creation.cylinder(radius=size[0], height=2.0 * size[1])
    return creation.box(extents=2.0 * size) if kind in (BOX, MESH) and (size > 0.0).all() else None


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Return the rotation by an angle [rad] about a (3,) axis of any length."""
    return rotation_from_quaternion(quaternion_about(axis / max(float(np.linalg.norm(axis)), 1e-12), angle))
