"""The joint torques that whole-body control may ask for: a box, or what motors give at the joints' speeds.

Motors drive a joint less than they brake it, so the range is not symmetric: middle ± half. Of a motor's
torque, friction takes its part (`Actuators.losses`): the range of what is left for the leg is moved by it.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.actuators import CREEP, Actuators
from surefoot.control.torque_kernels import commanded, torque_range
from surefoot.estimation.live_arrays import Bound

LEAST_SHARE = 0.02
"""Half the range is at least this share of the effort: a motor that spins away still brakes."""


class TorqueRange(Bound):
    """Range of the torques that move a robot's legs, at the joints' speeds of the last `update`.

    Parameters
    ----------
    effort
        (joints,) limits without actuators [N m].
    actuators
        What gives the torques; None for the plain box.

    Attributes
    ----------
    middle, half
        (joints,) of the range [N m].
    scale
        (joints,) effort over half: makes rows of the range rows of the box.
    losses
        (joints,) what is added to the torques for friction [N m].
    """

    def __init__(self, effort: FloatArray, actuators: Actuators | None = None) -> None:
        self.actuators = actuators
        nothing = np.zeros_like(effort)
        self._rows = np.array([nothing, effort, np.ones_like(effort), nothing])
        self._bind()
        if actuators is not None:
            motors = actuators.limits
            self._figures = np.array(
                [actuators.damping, actuators.friction, motors.effort, motors.speed, effort]
            )

    def _bind(self) -> None:
        """Find the parts of the memory."""
        self.middle: FloatArray = self._rows[0]
        self.half: FloatArray = self._rows[1]
        self.scale: FloatArray = self._rows[2]
        self.losses: FloatArray = self._rows[3]

    def update(self, speed: FloatArray) -> None:
        """Bring the range up to the joints' speeds (joints,) [rad/s]; those not finite count as rest."""
        if self.actuators is None:
            return
        motors = self.actuators.limits
        torque_range(speed, self._figures, motors.knee, motors.driving, CREEP, LEAST_SHARE, self._rows)

    def nearest(self, torques: FloatArray) -> FloatArray:
        """Return the bound of the range that (joints,) torques are beyond, or next to [N m]."""
        return np.asarray(self.middle + np.copysign(self.half, torques - self.middle))

    def command(self, torques: FloatArray) -> FloatArray:
        """Return motor torques for (joints,) torques on the legs: clipped, plus what friction takes [N m]."""
        return commanded(torques, self.middle, self.half, self.losses)
