"""What feet that stand say: points of one rigid floor, whose velocities are those of one body.

Of such feet -(ω × p + ṗ) is the velocity of the same body. Swapped sides, columns in another order and turn
rates in another unit break that at once.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.mechanics import Robot

LOOKED = 200
"""Moments at which feet are compared."""


class Misfit:
    """Disagreement of standing feet about the body's velocity, for an order of joints and feet.

    Parameters
    ----------
    robot
        Whose feet they are.
    time
        (T,) [s].
    gyro, joints
        (T, 3) [rad/s] and (T, joints) [rad], as the log has them.
    contact
        (T, n) which feet touch; None for the two that reach lowest below the base, of four or more.
    """

    def __init__(
        self, robot: Robot, time: FloatArray, gyro: FloatArray, joints: FloatArray,
        contact: BoolArray | None,
    ) -> None:  # fmt: skip
        step, half = float(np.median(np.diff(time))), max(1, round(0.005 / float(np.median(np.diff(time)))))
        two = True if contact is None else contact.sum(axis=1) >= 2
        moving = np.flatnonzero(two & (np.abs(gyro).max(axis=1) > 0.1))
        moving = moving[(moving >= half) & (moving < len(time) - half)]
        if len(moving) == 0:
            moving = np.arange(half, len(time) - half)
        rows = moving[np.linspace(0, len(moving) - 1, min(LOOKED, len(moving))).astype(int)]
        self._robot, self._rows, self._half, self._span = robot, rows, half, 2.0 * half * step
        self._gyro, self._joints = gyro[rows], joints
        self._contact = None if contact is None else contact[rows]

    @property
    def moments(self) -> int:
        """How many moments are compared."""
        return len(self._rows)

    def __call__(self, order: IntArray, feet: IntArray, share: float = 1.0) -> float:
        """Return the root mean square over feet and moments [m/s], with a share of the turn rates."""
        ends = (self._joints[self._rows + s][:, order] for s in (-self._half, self._half))
        places = [_below_base(self._robot, joints) for joints in ends]
        middle = 0.5 * (places[0] + places[1])
        velocity = np.cross(share * self._gyro[:, None], middle) + (places[1] - places[0]) / self._span
        on = self._standing(middle, feet)[:, :, None]
        count = np.maximum(on.sum(axis=1, keepdims=True), 1)
        mean = (velocity * on).sum(axis=1, keepdims=True) / count
        return float(np.sqrt(np.median((((velocity - mean) ** 2) * on).sum(axis=(1, 2)) / count[:, 0, 0])))

    def _standing(self, places: FloatArray, feet: IntArray) -> BoolArray:
        """Return (rows, n) which feet stand; below the base and not along gravity, for slopes."""
        if self._contact is not None:
            return np.asarray(self._contact[:, feet])
        heights = places[..., 2]
        return np.asarray(heights <= np.sort(heights, axis=1)[:, 1:2])


def _below_base(robot: Robot, joints: FloatArray) -> FloatArray:
    """Return where the feet are in base axes (T, n, 3) at joints (T, joints)."""
    q, out = robot.nominal.copy(), np.empty((len(joints), len(robot.feet), 3))
    q[:3], q[3:7] = 0.0, [0.0, 0.0, 0.0, 1.0]
    for k, row in enumerate(joints):
        q[7:] = row
        out[k] = robot.foot_positions(q)
    return out


def lowest_feet(robot: Robot, time: FloatArray, force: FloatArray, joints: FloatArray) -> BoolArray:
    """Return which feet (T, n) are within 1 cm of the lowest, along the mean specific force of a second."""
    width = min(len(time), max(1, round(1.0 / float(np.median(np.diff(time))))))
    kernel = np.ones(width) / width
    up = np.stack([np.convolve(force[:, k], kernel, mode="same") for k in range(3)], axis=1)
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    heights = (_below_base(robot, joints) @ up[:, :, None])[:, :, 0]
    return np.asarray(heights < heights.min(axis=1, keepdims=True) + 0.01)
