"""Worlds whose robots have actuators: what every such world does alike."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, of_kind
from surefoot.robot import Robot
from surefoot.robot.actuators import Actuators, actuators_of
from surefoot.robot.rotors import with_rotors

HOLD = 0.5
"""Share of a joint's momentum that its friction may take away in a step: all of it would chatter."""


def equipped(robot: Robot, actuators: str | Actuators) -> tuple[Robot, Actuators | None]:
    """Return the robot with the rotors of its actuators, and these; the robot itself and None for ideal ones.

    Raises
    ------
    ProblemError
        For an unknown name, or a value that does not fit the robot.
    """
    of_kind("robot", robot, Robot)
    chosen = actuators_of(robot, actuators)
    return (robot, None) if chosen is None else (with_rotors(robot, chosen.armature), chosen)


class JointFriction:
    """Damping and dry friction as torques for a world that takes explicit ones.

    Dry friction is that of a joint faster than a creep speed, friction dt / (`HOLD` I), and proportional to
    the speed below it; I is the inertia that a free joint feels in the nominal pose, rotors included. With
    rotors of the Go2's that is 0.01 rad/s at 1 ms.

    Parameters
    ----------
    robot
        With its rotors, see `with_rotors`.
    actuators
        What rubs.
    dt
        Length of a step [s].
    """

    def __init__(self, robot: Robot, actuators: Actuators, dt: float) -> None:
        import pinocchio

        M = np.triu(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))
        M = M + np.triu(M, 1).T
        inertia = 1.0 / np.diag(np.linalg.inv(M))[robot.base_dof :]
        self._damping = actuators.damping / (1.0 + actuators.damping * dt / (HOLD * inertia))
        self._friction = actuators.friction
        self._creep = np.maximum(actuators.friction * dt / (HOLD * inertia), 1e-9)

    def torques(self, speed: FloatArray) -> FloatArray:
        """Return the torques (joints,) on joints of (joints,) speeds, against the motion [N m]."""
        dry = np.minimum(np.maximum(speed / self._creep, -1.0), 1.0)
        return np.asarray(-self._damping * speed - self._friction * dry)
