"""What a sole weighs to those who move it: its leg's inertia there, rotors included."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Actuators, Robot, joint_inertias, with_rotors
from surefoot.motion.walking.biped.biped_settings import BIPED_WALK


def sole_inertias(robot: Robot, actuators: Actuators | None = None) -> FloatArray:
    """Return what each sole resists with in the nominal pose: (n, 3).

    Its apparent mass along the vertical, with the base held [kg], and its apparent moments of inertia about
    the axes ahead and to the left, of the free robot [kg m²]: inverse diagonal entries of J M⁻¹ Jᵀ.

    Parameters
    ----------
    robot
        With flat feet, which point ahead.
    actuators
        Whose rotors count; None for ideal ones, which have none.

    Raises
    ------
    ModelError
        If a joint moves next to nothing.
    """
    import pinocchio

    robot = robot if actuators is None else with_rotors(robot, actuators.armature)
    joint_inertias(robot)  # which refuses a robot whose mass matrix is singular
    model, base = robot.model, robot.base_dof
    data = model.createData()
    upper = np.triu(pinocchio.crba(model, data, robot.nominal))
    mass = upper + np.triu(upper, 1).T
    pinocchio.computeJointJacobians(model, data, robot.nominal)
    pinocchio.updateFramePlacements(model, data)
    found, frame = np.empty((len(robot.feet), 3)), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for row, foot in zip(found, robot.feet, strict=True):
        jacobian = pinocchio.getFrameJacobian(model, data, foot.frame, frame)
        lifted, turned = jacobian[2, base:], jacobian[3:5]
        row[0] = lifted @ np.linalg.solve(mass[base:, base:], lifted)
        row[1:] = np.diag(turned @ np.linalg.solve(mass, turned.T))
    return np.asarray(1.0 / np.maximum(found, 1e-12))


def check_rotors(robot: Robot, inertias: FloatArray) -> None:
    """Refuse a robot whose legs are heavier to move than the robot is: steps are planned for light ones.

    Raises
    ------
    ModelError
        If a sole's apparent mass, first column of (n, 3) `sole_inertias`, is beyond what is walked with.
    """
    k = int(inertias[:, 0].argmax())
    apparent = float(inertias[k, 0])
    if apparent > BIPED_WALK.heavy_rotors * robot.mass:
        most = BIPED_WALK.heavy_rotors
        raise ModelError(
            f"{robot.name} cannot walk here: with the rotors of its joints (armature) "
            f"{robot.feet[k].name} is as heavy to lift as {apparent:.2g} kg, "
            f"{apparent / robot.mass:.2g} times the robot, and steps are planned for {most:g} times at "
            "most. Check the armature in its file (a rotor's inertia times the gear ratio squared). "
            "Standing takes less: surefoot stand"
        )


def turning_share(robot: Robot, inertias: FloatArray) -> float:
    """Return which share of its rate the damping of turning soles may have: 1 unless they are very light.

    Half the robot's weight at a sole's edge is what planned forces are off by while the sole does not lie yet
    where it is believed. Where that turns it so fast, about both axes, that a controller sees it too late,
    fast damping adds to it.

    Parameters
    ----------
    robot
        With flat feet.
    inertias
        (n, 3) `sole_inertias`.
    """
    edge = 0.25 * robot.mass * GRAVITY * np.array([foot.size[1::-1] for foot in robot.feet])
    turned = float((edge / inertias[:, 1:]).min(axis=1).max())  # rad/s²
    return (
        min(1.0, BIPED_WALK.light_sole * GRAVITY / turned) if math.isfinite(turned) and turned > 0.0 else 1.0
    )
