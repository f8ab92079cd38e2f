"""The joint torques that whole-body control may ask for: a box, or what motors give at the joints' speeds.

Motors drive a joint less than they brake it, so the range is not symmetric: middle ± half. Of a motor's
torque, friction takes its part (`Actuators.losses`): the range of what is left for the leg is moved by it.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.actuators import Actuators
from surefoot.control.torque_kernels import usable_range

LEAST_SHARE = 0.02
"""Half the range is at least this share of the effort: a motor that spins away still brakes."""


class TorqueRange:
    """Range of the torques that move a robot's legs, at the joints' speeds of the last `update`.

    Parameters
    ----------
    effort
        (joints,) limits without actuators [N m].
    actuators
        What gives the torques; None for the plain box.
    compensation
        Share of the friction that the command makes up for.

    Attributes
    ----------
    middle, half
        (joints,) of the range [N m].
    scale
        (joints,) effort over half: makes rows of the range rows of the box.
    losses
        (joints,) what is added to the torques for friction [N m].
    """

    def __init__(
        self, effort: FloatArray, actuators: Actuators | None = None, compensation: float = 1.0
    ) -> None:
        self.effort, self.actuators, self.compensation = effort, actuators, compensation
        self.middle, self.losses = np.zeros_like(effort), np.zeros_like(effort)
        self.half, self.scale = effort.copy(), np.ones_like(effort)

    def update(self, speed: FloatArray) -> None:
        """Bring the range up to the joints' speeds (joints,) [rad/s]; those not finite count as rest."""
        if self.actuators is None:
            return
        if not np.isfinite(speed).all():
            speed = np.where(np.isfinite(speed), speed, 0.0)
        self.losses = self.compensation * self.actuators.losses(speed)
        low, high = self.actuators.bounds(speed)
        usable_range(low, high, self.losses, self.effort, LEAST_SHARE, self.middle, self.half, self.scale)

    def excess(self, torques: FloatArray) -> FloatArray:
        """Return by how much (joints,) torques are beyond the range, negative inside [N m]."""
        return np.asarray(np.abs(torques - self.middle) - self.half)

    def nearest(self, torques: FloatArray) -> FloatArray:
        """Return the bound of the range that (joints,) torques are beyond, or next to [N m]."""
        return np.asarray(self.middle + np.copysign(self.half, torques - self.middle))

    def command(self, torques: FloatArray) -> FloatArray:
        """Return motor torques for (joints,) torques on the legs: clipped, plus what friction takes [N m]."""
        inside = np.minimum(np.maximum(torques, self.middle - self.half), self.middle + self.half)
        return np.asarray(inside + self.losses)
