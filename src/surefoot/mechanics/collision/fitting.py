"""A robot's collision geometry as solids: its primitives as they are, meshes by what fits them best."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.collision.rounded_shapes import Box, Capsule, Shape, Sphere, coal
from surefoot.mechanics.collision.solids import Geometry, Solid
from surefoot.mechanics.robot import Robot

CLEAR = 1e-3
"""Solids closer than this in the nominal pose are taken for neighbours [m]."""
THINNEST = 1e-4
"""Least extent of a fitted shape [m]."""

Fitted = tuple[Shape, FloatArray, FloatArray]
"""A shape with its rotation (3, 3) and position (3,) in the frame of what it was fitted to."""


def robot_geometry(robot: Robot) -> Geometry:
    """Return all that a robot may touch itself, the ground or others with.

    Spheres, boxes and capsules are taken as they are, cylinders and meshes by the box or capsule that fits
    best (`fitted`). A foot's own geometry gives way to its contact spheres, which keep their own contacts
    with the ground. Pairs on one joint, of neighbouring joints, of two joints on one moving body, and those
    that overlap in the nominal pose are never tested.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> geometry = robot_geometry(load_robot("go2"))
    >>> [(s.name, type(s.shape).__name__) for s in geometry.solids[:3]]
    [('base_0', 'Capsule'), ('FL_thigh_0', 'Capsule'), ('FL_calf_0', 'Capsule')]
    """
    feet = {foot.frame for foot in robot.feet}
    solids = []
    for item in robot.collision.geometryObjects:
        # feet are spheres of their own below, joint 0 is the world
        if item.parentFrame in feet or int(item.parentJoint) == 0:
            continue
        made = fitted(item.geometry)
        if made is None:
            continue
        shape, rotation, position = made
        place = item.placement
        solids.append(
            Solid(
                item.name,
                shape,
                int(item.parentJoint),
                place.rotation @ rotation,
                place.rotation @ position + place.translation,
            )
        )
    points = robot.contact_points
    solids += [
        Solid(name, Sphere(float(r)), int(joint), position=place.copy(), on_ground=False)
        for name, joint, place, r in zip(
            points.names, points.joints, points.places, points.radii, strict=True
        )
    ]
    return Geometry(tuple(solids), _apart(robot, solids))


def fitted(geometry: Any) -> Fitted | None:
    """Return the shape that stands for one of coal's, None for what has no volume or is not known."""
    kind = type(geometry).__name__
    maker = _PRIMITIVES.get(kind)
    if maker is not None:
        return maker(geometry), np.eye(3), np.zeros(3)
    if not kind.startswith(("BVHModel", "Convex")):
        return None
    count = geometry.num_vertices if hasattr(geometry, "num_vertices") else geometry.num_points
    vertex = geometry.vertex if hasattr(geometry, "vertex") else geometry.point
    return fit_points(np.array([vertex(k) for k in range(count)], dtype=np.float64))


def fit_points(points: FloatArray) -> Fitted | None:
    """Return the box or capsule that is nearest to the hull of (n, 3) points; None for fewer than four.

    Nearest in the mean square, over all directions, of how far each reaches. Boxes hold all points; they lie
    along the given axes or along those of the points' covariance. A capsule is as wide and as long as the
    points, so that corners at its ends may stick out.
    """
    if len(points) < 4:
        return None
    # the points' own axes, for parts that lie askew in their frame
    _, axes = np.linalg.eigh(np.cov(points.T))
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    options: list[Fitted] = []
    for turn in (np.eye(3), axes):
        local = points @ turn
        low, high = local.min(axis=0), local.max(axis=0)
        a, b, c = np.maximum(high - low, THINNEST).tolist()
        options.append((Box((a, b, c)), turn, turn @ (0.5 * (low + high))))
        for axis in range(3):
            made = _capsule(local, axis)
            if made is not None:
                shape, lie, place = made
                options.append((shape, turn @ lie, turn @ place))
    reach = (points @ DIRECTIONS.T).max(axis=0)
    return min(options, key=lambda fit: float(np.mean((_reach(fit) - reach) ** 2)))


def _directions(count: int) -> FloatArray:
    """Return unit vectors (count, 3) spread evenly: a spiral by the golden angle."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


DIRECTIONS = _directions(400)
"""Where shapes are compared."""


def _reach(fit: Fitted) -> FloatArray:
    """Return how far a fitted shape reaches along `DIRECTIONS` [m]."""
    # the support function: Σ |d·axis| core + radius + d·position
    shape, rotation, position = fit
    return np.asarray(np.abs(DIRECTIONS @ rotation) @ shape.core + shape.radius + DIRECTIONS @ position)


def _capsule(points: FloatArray, axis: int) -> tuple[Capsule, FloatArray, FloatArray] | None:
    """Return the capsule that fits points along one axis, with rotation and position; None for short ones."""
    others = [(axis + 1) % 3, (axis + 2) % 3]
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = float(np.linalg.norm(points[:, others] - middle[others], axis=1).max())
    length = float(high[axis] - low[axis]) - 2.0 * radius
    if not (radius > THINNEST and length > 0.0):
        return None
    lie = np.roll(np.eye(3), axis + 1, axis=0)  # its z axis along `axis`
    return Capsule(radius, length), lie, middle


def _cylinder(item: Any) -> Shape:
    """Return a long cylinder as the capsule inside it, a short one as the box of its height and volume."""
    r, length = float(item.radius), 2.0 * float(item.halfLength)
    # a square of the circle's area
    edge = float(np.sqrt(np.pi)) * r
    return Capsule(r, length - 2.0 * r) if length > 2.0 * r else Box((edge, edge, length))


_PRIMITIVES: dict[str, Callable[[Any], Shape]] = {
    "Sphere": lambda item: Sphere(float(item.radius)),
    "Box": lambda item: Box(tuple((2.0 * np.array(item.halfSide)).tolist())),
    "Capsule": lambda item: Capsule(float(item.radius), 2.0 * float(item.halfLength)),
    "Cylinder": _cylinder,
}
"""coal's class of a primitive to the shape that stands for it."""


def _apart(robot: Robot, solids: list[Solid]) -> frozenset[tuple[int, int]]:
    """Return the pairs that are neighbours on the robot, or overlap in its nominal pose."""
    import pinocchio

    library, model, data = coal(), robot.model, robot.model.createData()
    pinocchio.forwardKinematics(model, data, robot.nominal)
    shapes = [s.shape.solid() for s in solids]
    poses = []
    for s in solids:
        pose = data.oMi[s.joint] * pinocchio.SE3(s.rotation, s.position)
        poses.append(library.Transform3s(pose.rotation, pose.translation))
    out = set()
    for a, b in combinations(range(len(solids)), 2):
        one, two = solids[a].joint, solids[b].joint
        up, over = int(model.parents[one]), int(model.parents[two])
        # two links on one body, as hips on a trunk: boxes around what turns in its place would meet
        near = two in (one, up) or one == over or up == over > 0
        if near or (
            library.distance(
                shapes[a], poses[a], shapes[b], poses[b], library.DistanceRequest(), library.DistanceResult()
            )
            < CLEAR
        ):
            out.add((a, b))
    return frozenset(out)
