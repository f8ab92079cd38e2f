"""The last word before the motors: targets within the limits of joints, speeds, gains and torques."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import JointTargets

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
        rows = np.array(targets, dtype=np.float64)
        limit_targets(rows, positions, speeds, self.low, self.high, self.speed, self.effort, *self._gains)
        return JointTargets(*rows)


@kernel
def limit_targets(
    rows: FloatArray, positions: FloatArray, speeds: FloatArray, low: FloatArray, high: FloatArray,
    fastest: FloatArray, effort: FloatArray, stiffest: float, hardest: float,
) -> None:  # fmt: skip
    """Bring (5, joints) targets within the limits of (joints,), see `TargetLimits.hold`."""
    for j in range(rows.shape[1]):
        for k in range(5):
            if not math.isfinite(rows[k, j]):
                rows[:, j] = 0.0
        goal, rate = min(max(rows[0, j], low[j]), high[j]), min(max(rows[1, j], -fastest[j]), fastest[j])
        kp, kd = min(max(rows[2, j], 0.0), stiffest), min(max(rows[3, j], 0.0), hardest)
        torque = min(max(rows[4, j], -effort[j]), effort[j])
        pull = kp * (goal - positions[j]) + kd * (rate - speeds[j])
        left = min(max(torque + pull, -effort[j]), effort[j]) - torque
        share = left / pull if abs(pull) > abs(left) else 1.0
        rows[0, j], rows[1, j] = goal, rate
        rows[2, j], rows[3, j], rows[4, j] = share * kp, share * kd, torque
