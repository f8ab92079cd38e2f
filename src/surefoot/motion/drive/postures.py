"""Postures that a robot takes without knowing where it is: lying folded, sitting, standing, and ways between.

A posture is a place of the body over its feet, which stay where they stand below a robot in its nominal pose:
so much lower, and pitched. The joints' angles follow by inverse kinematics, and on the way from one posture
to another as well, so that no foot slides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.discrete_damping import POSED, largest_damping, largest_stiffness
from surefoot.base.spatial import GRAVITY, rotation_about
from surefoot.mechanics import Actuators, Legs, Robot

STIFFNESS = 1.5
"""A joint's stiffness over m g h per radian, h the height of the base: legs give way by 4 degrees or so."""
DAMPING = 0.04
"""Ratio of a joint's damping to its stiffness [s]."""
WAYPOINTS = 12
"""Postures between two."""
RISING, FOLDING = 1.5, 1.2
"""Time for a way over the feet [s], and mean speed of the fastest joint on its way to one [rad/s]."""
REACHED = 1e-3
"""A posture can be taken if the feet are so near to their places [m]."""


class PostureMotion(NamedTuple):
    """Joint angles to pass through, from rest to rest.

    Attributes
    ----------
    points
        (k, joints) at equal distances [rad].
    duration
        From the first to the last [s].
    """

    points: FloatArray
    duration: float

    def at(self, time: float) -> FloatArray:
        """Return (joints,) angles at a time since the start [rad]; the last ones after its end."""
        share = min(max(time / self.duration, 0.0), 1.0)
        place = (len(self.points) - 1) * share * share * (3.0 - 2.0 * share)
        k = min(int(place), len(self.points) - 2)
        return np.asarray(self.points[k] + (place - k) * (self.points[k + 1] - self.points[k]))

    def speeds(self, time: float, dt: float) -> FloatArray:
        """Return (joints,) mean speeds in the step of dt [s] from a time on [rad/s]."""
        return np.asarray((self.at(time + dt) - self.at(time)) / dt)


class BodyPostures:
    """The postures of a robot, each as how far the body is below its nominal height [m] and its pitch [rad].

    Parameters
    ----------
    robot
        With a floating base.

    Attributes
    ----------
    stand, sit, lie
        Two feet only stand.
    """

    stand = (0.0, 0.0)

    def __init__(self, robot: Robot) -> None:
        self.robot, self._legs = robot, Legs(robot)
        self._nominal = robot.nominal[7:].copy()
        self._feet = self._legs.feet(self._nominal)
        height = max(float(robot.nominal[2]), 0.05)
        self.sit = self.lie = self.stand
        if len(robot.feet) > 2:
            length = float(np.ptp(self._feet[:, 0]))
            lowest = self._furthest([(share * height, 0.0) for share in np.linspace(0.1, 0.9, 33)])
            rear = np.linspace(0.0, 1.0, 17) * lowest[0]
            self.lie, self.sit = lowest, self._furthest([(0.5 * d, -math.atan(d / length)) for d in rear])

    def _furthest(self, postures: list[tuple[float, float]]) -> tuple[float, float]:
        """Return the last posture before the first one that the legs do not reach."""
        joints, best = self._nominal, self.stand
        for posture in postures:
            joints, miss = self._reach(posture, joints)
            if miss > REACHED:
                break
            best = posture
        return best

    def _reach(self, posture: tuple[float, float], near: FloatArray) -> tuple[FloatArray, float]:
        """Return (joints,) angles of a posture, and how far feet are from where they should be [m]."""
        down, pitch = posture
        feet = (self._feet + np.array([0.0, 0.0, down])) @ rotation_about([0.0, 1.0, 0.0], pitch)
        joints = self._legs.reach(feet, near)
        return joints, float(np.abs(self._legs.feet(joints) - feet).max())

    def way(self, begin: tuple[float, float], end: tuple[float, float]) -> PostureMotion:
        """Return the motion from one posture to another."""
        joints, points = self._nominal, []
        for share in np.linspace(0.0, 1.0, WAYPOINTS):
            down, pitch = ((1.0 - share) * a + share * b for a, b in zip(begin, end, strict=True))
            joints, _ = self._reach((down, pitch), joints)
            points.append(joints)
        return PostureMotion(np.array(points), RISING)

    def approach(self, angles: FloatArray, posture: tuple[float, float]) -> PostureMotion:
        """Return the motion from (joints,) angles to a posture, each joint on its own."""
        goal, start = self.way(posture, posture).points[-1], np.clip(angles, self._legs.low, self._legs.high)
        duration = max(float(np.abs(goal - start).max()) / FOLDING, 0.2)
        return PostureMotion(np.array([start, goal]), duration)


def posture_gains(
    robot: Robot, dt: float, actuators: Actuators | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the (joints,) stiffness [N m/rad] and damping [N m s/rad] of joints that hold a posture.

    Less in light links, which would shake: a wrist, an ankle in the air.

    Parameters
    ----------
    robot
        With a floating base.
    dt
        Time between commands [s].
    actuators
        Its motors, whose rotors turn with the joints; None for ideal ones.
    """
    inertia = _joint_inertia(robot, actuators)
    stiffness = STIFFNESS * robot.mass * GRAVITY * max(float(robot.nominal[2]), 0.05)
    return (
        np.minimum(stiffness, largest_stiffness(inertia, dt, POSED)),
        np.minimum(DAMPING * stiffness, largest_damping(inertia, dt, POSED)),
    )


def _joint_inertia(robot: Robot, actuators: Actuators | None) -> FloatArray:
    """Return (joints,) what each joint turns where nothing holds the robot: 1 over the diagonal of M^-1."""
    import pinocchio

    mass = np.array(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))
    mass = np.triu(mass) + np.triu(mass, 1).T
    if actuators is not None:
        mass[robot.base_dof :, robot.base_dof :] += np.diag(actuators.armature)
    return 1.0 / np.diag(np.linalg.inv(mass))[robot.base_dof :]
