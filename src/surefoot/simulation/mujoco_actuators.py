"""Actuators in MuJoCo: rotors, damping and dry friction in its joints."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import REAL, VECTOR, kernel
from surefoot.robot import Robot
from surefoot.robot.actuators import Actuators
from surefoot.robot.motor_limits import hold_to_motors
from surefoot.stepping.arithmetic import largest

FRICTION_TIME = (0.004, 1.0)
"""Time constant [s] and damping ratio of MuJoCo's dry friction of joints: as stiff as its contacts."""
FRICTION_IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Its impedance: MuJoCo's own default takes a hundredth of a radian off a leg's swing."""


LOAD_TYPES = (VECTOR, VECTOR, VECTOR, REAL, REAL, *(VECTOR,) * 6)
"""Types of the arguments of `load_joints`."""


@kernel
def load_joints(
    torques: FloatArray, effort: FloatArray, fastest: FloatArray, knee: float, driving: float,
    given: FloatArray, applied: FloatArray, qpos: FloatArray, qvel: FloatArray, kept_qpos: FloatArray,
    kept_qvel: FloatArray,
) -> bool:  # fmt: skip
    """Fill in what motors give of (joints,) torques [N m]; return whether these are finite.

    If they are not, nothing is filled in.

    Parameters
    ----------
    torques, effort, fastest, knee, driving
        What is asked for, and the motors; see `MotorLimits`.
    given, applied
        (joints,) what the motors give [N m]; filled, both.
    qpos, qvel
        (nq,), (nv,) MuJoCo's state, the joints last.
    kept_qpos, kept_qvel
        The same; filled.
    """
    if not largest(torques) < np.inf:
        return False
    given[:] = torques
    hold_to_motors(given, qvel[len(qvel) - len(given) :], effort, fastest, knee, driving)
    applied[:], kept_qpos[:], kept_qvel[:] = given, qpos, qvel
    return True


def motor_figures(actuators: Actuators | None, joints: int) -> tuple[FloatArray, FloatArray, float, float]:
    """Return effort and speed limits (joints,) [N m, rad/s], knee and driving shares; no limits for None."""
    if actuators is None:
        return np.full(joints, np.inf), np.full(joints, np.inf), 1.0, 1.0
    limits = actuators.limits
    effort, speed = np.ascontiguousarray(limits.effort), np.ascontiguousarray(limits.speed)
    return effort, speed, float(limits.knee), float(limits.driving)


def fit_actuators(spec: Any, robot: Robot, actuators: Actuators | None) -> None:
    """Give the joints of an MjSpec, see `robot_spec`, what `actuators` say; nothing for None.

    MuJoCo's dry friction is a constraint with its own softness: a joint that it holds creeps, for the Go2 by
    less than 0.01 rad/s.
    """
    if actuators is None:
        return
    for k, name in enumerate(robot.joint_names):
        joint = spec.joint(name)
        joint.armature = float(actuators.armature[k])
        joint.damping[0] = float(actuators.damping[k])
        joint.frictionloss = float(actuators.friction[k])
        joint.solref_friction, joint.solimp_friction = FRICTION_TIME, FRICTION_IMPEDANCE
