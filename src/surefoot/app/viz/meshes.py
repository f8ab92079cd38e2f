"""A robot's visual meshes for MuJoCo, as Pinocchio read them and mended where loading broke them.

By hand though trimesh exists: it knows nothing of parts that a loader has numbered twice, and goes by the
volume of watertight meshes, which robots' visuals are not (none of Go2's 17). Its `fix_normals` (5.2, with
networkx) leaves 6,900 of Go2's 6,932 inside-out triangles as they are and takes 2.4 s where this takes 0.1
s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.mechanics import Robot
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

BODY_COLOURS = ((0.25, 0.28, 0.32, 1.0), (0.45, 0.49, 0.54, 1.0), (0.33, 0.37, 0.42, 1.0))


def add_meshes(spec: Any, robot: Robot) -> None:
    """Draw the robot's visual meshes (collision shapes where there are none); nothing of it collides."""
    mujoco = import_mujoco()
    shapes = robot.visual.geometryObjects
    shapes = shapes if len(shapes) else robot.collision.geometryObjects
    for k, item in enumerate(shapes):
        body = spec.worldbody
        if item.parentJoint:
            name = str(robot.model.names[item.parentJoint])
            body = spec.body("base:0" if robot.floating and item.parentJoint == 1 else f"joint:{name}")
        placement = {
            "pos": item.placement.translation,
            "quat": quaternion_wxyz(quaternion_from_rotation(item.placement.rotation)),
            "contype": 0,
            "conaffinity": 0,
            "density": 0.0,
            "rgba": list(BODY_COLOURS[item.parentJoint % 3]),
        }
        kind, shape = type(item.geometry).__name__, item.geometry
        if kind.startswith("BVHModel") and shape.num_vertices > 3:
            vertices, faces = triangles(item)
            spec.add_mesh(
                name=f"mesh:{k}",
                uservert=vertices.ravel(),
                userface=faces.ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"mesh:{k}", **placement)
        elif kind in _FORMS:
            form, sizes = _FORMS[kind]
            body.add_geom(type=getattr(mujoco.mjtGeom, form), size=sizes(shape), **placement)


_FORMS: dict[str, tuple[str, Callable[[Any], list[float]]]] = {
    "Box": ("mjGEOM_BOX", lambda shape: list(shape.halfSide)),
    "Sphere": ("mjGEOM_SPHERE", lambda shape: [shape.radius, 0, 0]),
    "Cylinder": ("mjGEOM_CYLINDER", lambda shape: [shape.radius, shape.halfLength, 0]),
    "Capsule": ("mjGEOM_CAPSULE", lambda shape: [shape.radius, shape.halfLength, 0]),
}
"""Class of coal -> MuJoCo's kind of geom, and its size."""


def triangles(item: Any) -> tuple[FloatArray, IntArray]:
    """Return the (n, 3) vertices and (m, 3) triangles of a geometry object's mesh."""
    shape = item.geometry
    vertices = np.array(shape.vertices()) * np.asarray(item.meshScale)
    faces = np.array([[t[0], t[1], t[2]] for t in map(shape.tri_indices, range(shape.num_tris))])
    return vertices, _face_outwards(vertices, _separate_parts(faces, len(vertices)))


def _separate_parts(faces: IntArray, count: int) -> IntArray:
    """Return triangles whose parts each use their own vertices.

    The loader numbers every part of a file's mesh from zero, so that the second part draws with the
    first one's vertices. A part begins with the triangle (0, 1, 2); if the parts' sizes add up to the
    number of vertices, that is what happened, and each is moved to its place.
    """
    starts = np.flatnonzero((faces == [0, 1, 2]).all(axis=1))
    if len(starts) < 2 or starts[0] != 0:
        return faces
    parts = np.split(faces, starts[1:])
    sizes = [int(part.max()) + 1 for part in parts]
    if sum(sizes) != count:
        return faces
    offsets = np.cumsum([0, *sizes[:-1]])
    return np.vstack([part + offset for part, offset in zip(parts, offsets, strict=True)])


def _face_outwards(vertices: FloatArray, faces: IntArray) -> IntArray:
    """Return the triangles with every connected part turned outwards.

    Mirrored meshes come with some parts inside out, which OpenGL would not draw. Vertices at the same
    place count as one: files repeat them where shading is flat.
    """
    _, weld = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    count, joined = len(vertices), weld.ravel()[faces]
    ends = joined[:, [0, 1, 0]].ravel(), joined[:, [1, 2, 2]].ravel()
    _, part = connected_components(csr_matrix((np.ones(ends[0].size), ends), (count, count)), directed=False)
    mine = part[joined[:, 0]]
    size = np.maximum(np.bincount(mine, minlength=count), 1)
    places = vertices[faces].mean(axis=1)
    middle = np.array([np.bincount(mine, places[:, k], minlength=count) for k in range(3)]).T / size[:, None]
    a, b, c = (vertices[faces[:, k]] - middle[mine] for k in range(3))
    volume = np.bincount(mine, np.einsum("ij,ij->i", a, np.cross(b, c)), minlength=count)
    inside_out = (volume < 0.0)[mine]
    return np.where(inside_out[:, None], faces[:, ::-1], faces)
