"""Where feet are for joint angles, and joint angles for where feet should be, in the base's axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics.robot.robot import Robot

DAMPING = 1e-3
"""Of the inverse kinematics, in units of a leg's length."""
ITERATIONS, PRECISION = 30, 1e-6
"""Most iterations, and the distance that is good enough [m]."""
LARGEST_TURN = 0.3
"""Of a joint in one iteration [rad]."""
STEP = 1e-6
"""Of differences [rad]."""
INSIDE = 0.02
"""By how much solutions stay within the joints' limits [rad]."""


class Legs:
    """Kinematics of a floating robot's legs, seen from its base; keeps its own work space.

    Parameters
    ----------
    robot
        Whose legs.
    """

    def __init__(self, robot: Robot) -> None:
        import pinocchio

        self.robot, self._pin = robot, pinocchio
        self._model: Any = robot.model
        self._data: Any = robot.model.createData()
        self._points = robot.contact_points
        self._q = np.array(robot.nominal)
        self._q[:7] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        self.low = np.array(robot.model.lowerPositionLimit[7:])
        self.high = np.array(robot.model.upperPositionLimit[7:])
        with np.errstate(invalid="ignore"):
            self._inside = np.minimum(INSIDE, 0.25 * (self.high - self.low))
        self._legs = [np.flatnonzero(row[6:]) for row in self._points.foot_support]

    def slopes(self, joints: FloatArray) -> FloatArray:
        """Return how feet move with (joints,) angles (n, 3, joints), by central differences [m/rad]."""
        step = STEP * np.eye(len(joints))
        return np.stack(
            [(self.feet(joints + s) - self.feet(joints - s)) / (2.0 * STEP) for s in step], axis=2
        )

    def feet(self, joints: FloatArray) -> FloatArray:
        """Return the centres of the feet (n, 3) for (joints,) angles [m]."""
        self._q[7:] = joints
        self._pin.computeJointJacobians(self._model, self._data, self._q)
        places = []
        for frame, middle in zip(self._points.frames, self._points.middles, strict=True):
            pose = self._pin.updateFramePlacement(self._model, self._data, frame)
            places.append(pose.translation + pose.rotation @ middle)
        return np.array(places)

    def reach(self, feet: FloatArray, joints: FloatArray, iterations: int = ITERATIONS) -> FloatArray:
        """Return angles (joints,) that bring the feet to (n, 3) places, as far as the limits allow.

        Damped Gauss-Newton from the given angles, leg by leg, inside the joints' limits.
        """
        out = np.clip(joints, self.low + self._inside, self.high - self._inside)
        for _ in range(iterations):
            miss = feet - self.feet(out)
            if np.abs(miss).max() < PRECISION:
                break
            J = np.asarray(self._data.J)
            for foot, leg in enumerate(self._legs):
                columns = J[:, 6 + leg]  # twists at the base's origin, moved to the foot
                place = feet[foot] - miss[foot]
                rows = columns[:3] + np.cross(columns[3:], place, axis=0)
                out[leg] += self._step(rows, miss[foot], out[leg], leg)
            out = np.clip(out, self.low + self._inside, self.high - self._inside)
        return out

    def _step(self, rows: FloatArray, miss: FloatArray, angles: FloatArray, leg: IntArray) -> FloatArray:
        """Return the turn of a leg's joints; those at a limit that would go beyond it stay."""
        low, high = (self.low + self._inside)[leg], (self.high - self._inside)[leg]
        free = np.ones(len(leg), dtype=bool)
        step = np.zeros(len(leg))
        for _ in range(len(leg)):
            # An active set: a joint at its stop is taken out, and the others find the step without it.
            J = rows * free
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(3), miss)
            beyond = free & (((angles <= low) & (step < 0.0)) | ((angles >= high) & (step > 0.0)))
            if not beyond.any():
                break
            free &= ~beyond
        return step * min(1.0, LARGEST_TURN / max(float(np.abs(step).max()), 1e-12))
