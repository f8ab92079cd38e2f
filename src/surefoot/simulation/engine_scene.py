"""A robot and its terrain as plain data for an engine to build anew: joints, contact spheres, ground."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.errors import ModelError
from surefoot.robot import Robot
from surefoot.stepping.bodies import loaded_model
from surefoot.terrain import Box, Plane, Terrain


def scene_of(
    robot: Robot, terrain: Terrain, payload: float = 0.0, payload_position: ArrayLike = (0.0, 0.0, 0.0)
) -> dict[str, Any]:
    """Return a robot's tree of joints, its contact spheres and the ground as plain data.

    `payload_position` is (3,) in base axes [m].

    Raises
    ------
    ModelError
        For a joint or a shape of ground that these worlds do not build.
    """
    model, points = loaded_model(robot, payload, payload_position), robot.contact_points
    joints = [_joint(model, index, robot.floating) for index in range(1, model.njoints)]
    spheres = [
        [int(joint), place.tolist(), float(radius)]
        for joint, place, radius in zip(points.joints, points.places, points.radii, strict=True)
    ]
    ground = []
    for shape in terrain.shapes():
        if type(shape) not in _GROUND:
            raise ModelError(
                f"this world takes planes and boxes, a {type(terrain).__name__} is made of a "
                f"{type(shape).__name__}"
            )
        ground.append(_GROUND[type(shape)](shape))
    gravity = np.array(model.gravity.linear).tolist()
    return {"joints": joints, "spheres": spheres, "ground": ground, "gravity": gravity}


def _joint(model: Any, index: int, floating: bool) -> dict[str, Any]:
    """Return a joint and the body that it carries."""
    joint, pose, inertia = model.joints[index], model.jointPlacements[index], model.inertias[index]
    words: dict[str, Any] = {
        "parent": int(model.parents[index]), "rotation": pose.rotation.tolist(),
        "place": pose.translation.tolist(), "mass": float(inertia.mass), "com": inertia.lever.tolist(),
        "inertia": inertia.inertia.tolist(),
    }  # fmt: skip
    kind, axis = _kind(joint, str(model.names[index]))
    low, high = -np.inf, np.inf
    if kind != "free":
        low, high = (
            float(limits[joint.idx_q]) for limits in (model.lowerPositionLimit, model.upperPositionLimit)
        )
        if not low < high:
            low, high = -np.inf, np.inf
    return {**words, "kind": kind, "axis": axis, "low": low, "high": high}


def _kind(joint: Any, name: str) -> tuple[str, list[float]]:
    """Return free, revolute or prismatic, and the axis."""
    kind, axes = joint.shortname().removeprefix("JointModel"), np.eye(3)
    if kind == "FreeFlyer":
        return "free", [0.0, 0.0, 0.0]
    words = {"R": "revolute", "P": "prismatic"}
    if kind in ("RevoluteUnaligned", "PrismaticUnaligned"):
        return words[kind[0]], np.array(joint.extract().axis).tolist()
    if len(kind) == 2 and kind[0] in words and kind[1] in "XYZ":
        return words[kind[0]], axes["XYZ".index(kind[1])].tolist()
    raise ModelError(f"joint {name} is a {kind}; this world takes revolute and prismatic joints")


def _plane(plane: Plane) -> dict[str, Any]:
    return {"rotation": plane.rotation.tolist(), "place": plane.point.tolist()}


def _box(box: Box) -> dict[str, Any]:
    return {"rotation": np.eye(3).tolist(), "place": box.centre.tolist(), "size": box.size.tolist()}


_GROUND: dict[type, Any] = {Plane: _plane, Box: _box}
