"""Actuators in MuJoCo: rotors, damping and dry friction in its joints."""

from __future__ import annotations

from typing import Any

from surefoot.control.actuators import Actuators
from surefoot.robot import Robot

FRICTION_TIME = (0.004, 1.0)
"""Time constant [s] and damping ratio of MuJoCo's dry friction of joints: as stiff as its contacts."""
FRICTION_IMPEDANCE = (0.99, 0.99, 0.001, 0.5, 2.0)
"""Its impedance: MuJoCo's own default takes a hundredth of a radian off a leg's swing."""


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
