"""Worlds whose robots have actuators: what every such world does alike."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, of_kind
from surefoot.base.discrete_damping import HELD
from surefoot.mechanics import Actuators, Robot, actuators_of, joint_inertias, with_rotors


def equipped(robot: Robot, actuators: str | Actuators) -> tuple[Robot, Actuators | None]:
    """Return the robot with the rotors of its actuators, and these; the robot itself and None for ideal ones.

    Raises
    ------
    ProblemError
        For an unknown name, or a value that does not fit the robot.
    ModelError
        If a joint moves next to nothing, see `joint_inertias`.
    """
    of_kind("robot", robot, Robot)
    chosen = actuators_of(robot, actuators)
    robot = robot if chosen is None else with_rotors(robot, chosen.armature)
    joint_inertias(robot)  # which refuses such a robot
    return robot, chosen


class JointFriction:
    """Damping and dry friction as torques for a world that takes explicit ones.

    Dry friction is that of a joint faster than a creep speed, friction dt / (`HELD` I), and proportional to
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
        inertia = joint_inertias(robot)
        self._damping = actuators.damping / (1.0 + actuators.damping * dt / (HELD * inertia))
        self._friction = actuators.friction
        self._creep = np.maximum(actuators.friction * dt / (HELD * inertia), 1e-9)

    def torques(self, speed: FloatArray) -> FloatArray:
        """Return the torques (joints,) on joints of (joints,) speeds, against the motion [N m]."""
        dry = np.minimum(np.maximum(speed / self._creep, -1.0), 1.0)
        return np.asarray(-self._damping * speed - self._friction * dry)
