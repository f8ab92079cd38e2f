"""The last word before the motors: targets within the limits of joints, speeds, gains and torques."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.controller import JointTargets
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY

STIFFEST, HARDEST_DAMPING = 5.0, 1.0
"""Largest stiffness [1/rad] and damping [s/rad] of a joint over m g h, h the height of the base."""


class TargetLimits:
    """Holds targets to the limits of a robot.

    Parameters
    ----------
    robot
        Limits that its model does not give are infinite.
    """

    def __init__(self, robot: Robot) -> None:
        first = robot.base_dof + 1
        self.low = np.array(robot.model.lowerPositionLimit[first:])
        self.high = np.array(robot.model.upperPositionLimit[first:])
        self.speed, self.effort = robot.speed_limits, robot.effort_limits
        unit = robot.mass * GRAVITY * max(float(robot.nominal[2]), 0.05)
        self._gains = STIFFEST * unit, HARDEST_DAMPING * unit

    def hold(self, targets: JointTargets, positions: FloatArray, speeds: FloatArray) -> JointTargets:
        """Return targets within the limits, whose torques are so at (joints,) angles [rad], speeds [rad/s].

        What is not finite is taken for zero, and its joint gets no stiffness. A torque beyond its limit is
        brought back by lower gains, after the feed-forward torque has been clipped.
        """
        known = np.isfinite(np.array(targets)).all(axis=0)
        rows = np.where(known, np.array(targets), 0.0)
        goal, rate = np.clip(rows[0], self.low, self.high), np.clip(rows[1], -self.speed, self.speed)
        kp, kd = np.clip(rows[2], 0.0, self._gains[0]), np.clip(rows[3], 0.0, self._gains[1])
        torque = np.clip(rows[4], -self.effort, self.effort)
        pull = kp * (goal - positions) + kd * (rate - speeds)
        left = np.clip(torque + pull, -self.effort, self.effort) - torque
        share = np.where(np.abs(pull) > np.abs(left), left / np.where(pull == 0.0, 1.0, pull), 1.0)
        return JointTargets(goal, rate, share * kp, share * kd, torque)
