"""The joint torques that whole-body control may ask for: a box, or what motors give at the joints' speeds.

Motors drive a joint less than they brake it, so the range is not symmetric: middle ± half. Of a motor's
torque, friction takes its part (`Actuators.losses`): the range of what is left for the leg is moved by it.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.actuators import Actuators

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
        self.half, self.scale = effort, np.ones_like(effort)

    def update(self, speed: FloatArray) -> None:
        """Bring the range up to the joints' speeds (joints,) [rad/s]; those not finite count as rest."""
        if self.actuators is None:
            return
        speed = np.nan_to_num(speed, nan=0.0, posinf=0.0, neginf=0.0)
        self.losses = self.compensation * self.actuators.losses(speed)
        low, high = self.actuators.bounds(speed)
        low, high = np.maximum(low, -self.effort), np.minimum(high, self.effort)
        bounded = np.isfinite(low) & np.isfinite(high)
        with np.errstate(invalid="ignore"):
            self.middle = np.where(bounded, 0.5 * (high + low) - self.losses, 0.0)
            half = np.where(bounded, 0.5 * (high - low), np.inf)
            self.half = np.maximum(half, LEAST_SHARE * self.effort)
            self.scale = np.where(np.isfinite(self.half), self.effort / self.half, 1.0)

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
