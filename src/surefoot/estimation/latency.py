"""Readings of one time from sensors that are late by different times, and the state from then to now.

The filter needs an IMU and encoders that tell of the same moment: what is fresher waits. What the robot does
in the meantime is told by the readings that wait, by the last of them held, and by joints that go on at their
acceleration so far.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from surefoot.arrays import FloatArray, real_number
from surefoot.estimation.foot_kinematics import state_ahead

if TYPE_CHECKING:
    from surefoot.estimation.inekf_robot import InvariantEkf
    from surefoot.estimation.state_estimator import Reading

WINDOW = 0.005
"""Time over which a joint's acceleration is taken [s]: shorter is noisier."""
FURTHEST = 0.005
"""Longest time for which joints are taken to keep their acceleration [s]: more does harm."""
LATEST = 0.1
"""Largest latency [s]."""


class Latency:
    """Lets the fresher readings wait, and goes on to now.

    Parameters
    ----------
    ekf
        The filter.
    imu, encoders
        How late they tell what they measure [s].

    Attributes
    ----------
    steps
        How many steps the filter is behind.

    Raises
    ------
    ProblemError
        For a latency that is negative or longer than `LATEST`.
    """

    def __init__(self, ekf: InvariantEkf, imu: float, encoders: float) -> None:
        self._ekf, dt = ekf, ekf.dt
        late = [
            round(real_number(f"latency of the {name}", value, low=0.0, high=LATEST) / dt)
            for name, value in (("IMU", imu), ("encoders", encoders))
        ]
        self.steps = max(late)
        self._held, self._ahead = late[0], min(self.steps * dt, FURTHEST)
        self._imu: deque[tuple[FloatArray, FloatArray]] = deque(maxlen=self.steps - late[0] + 1)
        self._legs: deque[tuple[FloatArray, FloatArray]] = deque(maxlen=self.steps - late[1] + 1)
        self._gyros, self._forces = np.zeros((2, self.steps + late[0] + 1, 3))
        self._speeds: deque[FloatArray] = deque(maxlen=1 + max(round(WINDOW / dt), 1))
        self._torques: deque[FloatArray] = deque(maxlen=self.steps + 1)

    def reset(self) -> None:
        """Forget all readings."""
        for one in (self._imu, self._legs, self._speeds, self._torques):
            one.clear()

    def align(self, reading: Reading) -> Reading:
        """Return the readings of the filter's next time."""
        self._imu.append((reading.gyro, reading.accelerometer))
        self._legs.append((reading.positions, reading.speeds))
        (gyro, accelerometer), (positions, speeds) = self._imu[0], self._legs[0]
        self._speeds.append(speeds)
        return type(reading)(gyro, accelerometer, positions, speeds)

    def torques(self, now: FloatArray) -> FloatArray:
        """Return the (joints,) torques [N m] at the filter's time, from those of now on."""
        self._torques.append(now)
        return self._torques[0]

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, rad] and v (nv,) [m/s, rad/s] of now, Pinocchio's order."""
        ekf = self._ekf
        if self.steps == 0 or not self._imu:
            return ekf.state()
        last = len(self._imu) - 1
        for i in range(last + self._held):  # the last reading is held
            self._gyros[i], self._forces[i] = self._imu[min(i + 1, last)]
        count = last + self._held
        span = max(len(self._speeds) - 1, 1) * ekf.dt
        return state_ahead(
            ekf.filter.X, ekf.filter.bias, self._gyros[:count], self._forces[:count], ekf.dt,
            ekf.imu_position, *ekf.legs, self._speeds[0], self._speeds[-1], span, self._ahead,
        )  # fmt: skip
