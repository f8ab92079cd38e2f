"""What a joint's gear and rotor do to a robot: figures of its model, and a robot that carries its rotors."""

from __future__ import annotations

import copy
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.robot import Robot


class JointFigures(NamedTuple):
    """What a model's file says about its joints; zero where it says nothing.

    Attributes
    ----------
    armature
        (joints,) inertia of the rotors as the joints feel it [kg m²].
    damping
        (joints,) viscous friction [N m s].
    friction
        (joints,) dry friction [N m].
    """

    armature: FloatArray
    damping: FloatArray
    friction: FloatArray


def joint_figures(robot: Robot) -> JointFigures:
    """Return what the robot's file says: URDF's ``<dynamics>``, MJCF's armature, damping, frictionloss.

    Ideal joints, which are the default everywhere, leave all of it out: see `robot.actuators`.
    """
    model, first = robot.model, robot.base_dof
    rotors = np.array(model.rotorInertia) * np.array(model.rotorGearRatio) ** 2
    figures = (
        np.array(model.armature) + rotors,
        np.array(model.damping),
        np.array(model.upperDryFrictionLimit),
    )
    return JointFigures(*(np.asarray(row[first:], dtype=np.float64) for row in figures))


def with_rotors(robot: Robot, armature: ArrayLike) -> Robot:
    """Return the same robot with rotors in its joints: its mass matrix has their inertia on the diagonal.

    Parameters
    ----------
    robot
        Stays as it is.
    armature
        (joints,) rotor inertia times the gear ratio squared [kg m²].

    Raises
    ------
    ProblemError
        For inertias that are negative, not finite, or not one for every joint.
    """
    given = np.asarray(armature, dtype=np.float64)
    if given.shape != (robot.joints,) or not (np.isfinite(given).all() and (given >= 0.0).all()):
        raise ProblemError(f"armature must be (joints,) = ({robot.joints},) numbers >= 0, got {given}")
    out = copy.copy(robot)
    out.model = robot.model.copy()
    held = np.zeros(robot.model.nv)
    held[robot.base_dof :] = given
    out.model.armature = held
    out.data = out.model.createData()
    return out
