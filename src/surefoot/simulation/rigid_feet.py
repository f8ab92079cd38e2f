"""The contact spheres of a robot's feet as frames of a model of the rigid world's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.robot import Robot


@dataclass(frozen=True)
class Spheres:
    """Contact spheres, in the order of the robot's feet.

    Attributes
    ----------
    foot
        (p,) index of each sphere's foot.
    frame
        Its frame in the model.
    radius
        (p,) [m].
    support
        (p, nv) which velocity components move it.
    """

    foot: IntArray
    frame: list[int]
    radius: FloatArray
    support: BoolArray


def loaded_model(robot: Robot, payload: float) -> Any:
    """Return a copy of the robot's model with a point mass [kg] at the base's origin."""
    import pinocchio

    model = robot.model.copy()
    if payload > 0.0 and robot.floating:
        load = pinocchio.Inertia(payload, np.zeros(3), 1e-3 * payload * np.eye(3))
        model.inertias[1] = model.inertias[1] + load
    return model


def add_spheres(model: Any, robot: Robot) -> Spheres:
    """Add a frame to the model for each contact sphere of the robot's feet."""
    import pinocchio

    spheres = [(k, foot, centre) for k, foot in enumerate(robot.feet) for centre in foot.centres]
    frames, support = [], np.zeros((len(spheres), model.nv), dtype=np.bool_)
    for row, (_, foot, centre) in enumerate(spheres):
        frame = model.frames[foot.frame]
        joint = int(frame.parentJoint)
        place = frame.placement * pinocchio.SE3(np.eye(3), centre)
        sphere = pinocchio.Frame(
            f"{foot.name}:sphere{row}", joint, foot.frame, place, pinocchio.FrameType.OP_FRAME
        )
        frames.append(int(model.addFrame(sphere)))
        while joint > 0:
            first = model.joints[joint].idx_v
            support[row, first : first + model.joints[joint].nv] = True
            joint = int(model.parents[joint])
    owner = np.array([k for k, _, _ in spheres], dtype=np.int64)
    return Spheres(owner, frames, np.array([foot.radius for _, foot, _ in spheres]), support)
