"""Where legs and trunk of a robot on four feet are: found in the model's geometry, not in its names."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError, ProblemError
from surefoot.mechanics.robot.robot import Robot

TRUNK_DEPTH = 0.3
"""Half the height of the box that stands for the trunk, as a share of its half length."""
NEAR, PARALLEL = 1e-3, 0.99
"""How far a joint may be from the mirror image of another [m], and least cosine between their axes."""


def quadruped_order(robot: Robot) -> list[int]:
    """Return the indices of the feet in the order front left, front right, rear left, rear right.

    Raises
    ------
    ProblemError
        For a robot that has not four feet.
    """
    import pinocchio

    if not robot.floating or len(robot.feet) != 4:
        raise ProblemError(f"the task is for robots on four feet, {robot.name} has {len(robot.feet)}")
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.nominal)
    places = np.array([data.oMf[k].translation for k in robot.contact_points.frames]) - robot.nominal[:3]
    return sorted(range(4), key=lambda k: (places[k, 0] <= 0, places[k, 1] <= 0))


def body_corners(robot: Robot) -> tuple[IntArray, FloatArray]:
    """Return points that must not touch the ground: (m,) joints that carry them, (m, 3) places [m].

    The joints above the feet, and the corners of a box about the trunk as long and wide as the legs' first
    joints stand apart.
    """
    model, points = robot.model, robot.contact_points
    knees = np.unique(points.joints)
    hips = [model.jointPlacements[k].translation for k in range(2, model.njoints) if model.parents[k] == 1]
    half = np.abs(np.array(hips)).max(axis=0)
    half[2] = TRUNK_DEPTH * half[0]
    signs = np.array(np.meshgrid([1.0, -1.0], [1.0, -1.0], [1.0, -1.0])).reshape(3, -1).T
    joints = np.concatenate([knees, np.ones(len(signs), dtype=np.int64)])
    return joints, np.vstack([np.zeros((len(knees), 3)), signs * half])


def mirrored_joints(robot: Robot) -> tuple[IntArray, FloatArray]:
    """Return for each joint the index of its mirror image and the sign of its angle there, (joints,) each.

    The mirror is the base's plane y = 0; a joint in it is its own image. Places and axes are those of the
    zero configuration: a reflection turns an axis (x, y, z) of rotation into (-x, y, -z).

    Raises
    ------
    ModelError
        For a robot that is not symmetric, or with joints other than revolute ones.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> other, sign = mirrored_joints(load_robot("go2"))
    >>> other[:6].tolist(), sign[:3].tolist()
    ([3, 4, 5, 0, 1, 2], [-1.0, 1.0, 1.0])
    """
    import pinocchio

    model = robot.model
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    numbers = [k for k in range(2, model.njoints) if model.joints[k].nv == 1]
    if len(numbers) != robot.joints:
        raise ModelError(f"{robot.name} has joints of more than one degree of freedom: no mirror is known")
    places = np.array([data.oMi[1].actInv(data.oMi[k].translation) for k in numbers])
    axes = np.array([data.oMi[k].rotation @ np.array(data.joints[k].S).reshape(6)[3:] for k in numbers])
    image = places * [1.0, -1.0, 1.0]
    other, sign = np.zeros(len(numbers), dtype=np.int64), np.zeros(len(numbers))
    for k, axis in enumerate(axes):
        turned = axis * [-1.0, 1.0, -1.0]
        far = np.linalg.norm(places - image[k], axis=1)
        along = axes @ turned
        good = (far < NEAR) & (np.abs(along) > PARALLEL)
        if not good.any():
            raise ModelError(f"{robot.name} is not symmetric: {robot.joint_names[k]} has no mirror image")
        other[k] = int(np.flatnonzero(good)[0])
        sign[k] = float(np.sign(along[other[k]]))
    return other, sign
