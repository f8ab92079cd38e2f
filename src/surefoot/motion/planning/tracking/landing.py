"""From the first touch on: brake the body over the feet that stand, then hold it there."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import rotation_about, rotation_log
from surefoot.mechanics import Robot
from surefoot.motion.control.whole_body import Kinematics, Tasks
from surefoot.motion.planning.tracking.reference import Reference

HEIGHT, TURN, SWAY = 14.0, 14.0, 7.0
"""Natural frequencies of the height, the attitude and the place along the ground, of Go2's size [rad/s]."""
DESCENT = 0.6
"""Speed with which feet that have not found the ground yet are sent down [m/s]."""
DEPTH = 3e-4
"""How deep in the ground stance feet are wanted [m]."""
NEAR, SLOW, BRAKE = 0.05, 0.7, 80.0
"""Swinging feet that come so near the ground [m] slow down to this speed [m/s], at this rate [1/s]."""
STEP = 0.01
"""How much higher or lower than where they stood feet land on another level [m]."""
SWING = 30.0
"""Rate at which they take it [1/s]."""


class Landing:
    """Tasks of a whole body that has touched the ground.

    The body is pulled to where the plan ends it over its feet: the place along the ground from the middle
    of the feet that stand now, the height from theirs, upright at the heading of the touchdown.

    Parameters
    ----------
    robot, reference
        Who lands, and the plan.
    quick
        How much quicker than one of Go2's size it is.

    Attributes
    ----------
    stand
        (n,) heights of the feet's centres where the plan ends [m].
    """

    def __init__(self, robot: Robot, reference: Reference, quick: float = 1.0) -> None:
        self.robot = robot
        self._omega = quick * np.array([SWAY, SWAY, HEIGHT])
        self._turn = quick * TURN
        feet, com = reference.feet[-1], reference.com[-1]
        rotation = reference.rotation[-1]
        back = _heading(rotation).T
        self._lean = back @ rotation
        self._feet = (feet - com) @ back.T
        self._still = np.zeros(robot.joints)
        self._frames = np.tile(np.eye(3), (len(robot.feet), 1, 1))
        points = robot.contact_points
        self._owner, first = points.foot, reference.feet[0, :, 2]
        climbed, stood = feet[:, 2] - first, np.abs(first - points.foot_radii) < STEP
        self.stand = points.foot_radii + np.where(stood & (np.abs(climbed) > STEP), climbed, 0.0)

    def begin(self, now: Kinematics) -> None:
        """Take the heading of this moment for the one to keep."""
        self._heading = _heading(now.rotation)

    def tasks(self, now: Kinematics, stance: BoolArray) -> Tasks:
        """Return the tasks for a stance (n,) of one foot or more."""
        around = self._feet @ self._heading.T
        # where the weight belongs as seen from every foot that stands
        wanted = (now.centres[stance] - around[stance]).mean(axis=0)
        w = self._omega
        com = w * w * (wanted - now.com) - 2.0 * w * now.com_velocity
        upright = rotation_log(self._heading @ self._lean @ now.rotation.T)
        turn = self._turn**2 * upright - 2.0 * self._turn * now.angular_velocity
        feet = np.zeros((len(stance), 6))
        if not stance.all():
            feet[:, :3] = lowering_accelerations(now)
        gaps = gaps_to_close(now, self.stand)
        return Tasks(
            stance, com, turn, feet, self._still, np.zeros((len(self._owner), 3)), self._frames, gaps
        )


def _heading(rotation: FloatArray) -> FloatArray:
    """Return the turn (3, 3) about the vertical that a body's x axis has."""
    return rotation_about([0.0, 0.0, 1.0], math.atan2(rotation[1, 0], rotation[0, 0]))


def lowering_accelerations(now: Kinematics) -> FloatArray:
    """Return the accelerations (n, 3) that send feet down to the ground, moving on with the body [m/s²]."""
    speed = now.com_velocity * np.array([1.0, 1.0, 0.0]) - [0.0, 0.0, DESCENT]
    return np.asarray(SWING * (speed - now.twists[:, :3]))


def gently(now: Kinematics, stand: FloatArray) -> FloatArray:
    """Return the least accelerations upwards (n,) with which feet near where they stand meet it slowly."""
    near = now.centres[:, 2] - stand < NEAR
    return np.where(near, BRAKE * (-SLOW - now.twists[:, 2]), -np.inf)


def gaps_to_close(now: Kinematics, stand: FloatArray) -> FloatArray:
    """Return the gaps (n,) to close under feet whose centres stand at (n,) heights [m].

    Down to a little inside the ground.

    A foot that just touches creeps out of soft ground as the leg extends, and then leaves it for an instant.
    """
    return np.asarray(now.centres[:, 2] - stand + DEPTH)
