"""Readings of one time from sensors that are late by different times, and the state from then to now.

The filter needs an IMU and encoders that tell of the same moment: what is fresher waits. What the robot does
in the meantime follows from the readings that wait, from the last of them held, and from joints that go on at
their acceleration so far.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, real_number
from surefoot.base.memory import Remembering
from surefoot.motion.estimation.estimator_kernels import QUEUED

if TYPE_CHECKING:
    from surefoot.motion.estimation.inekf_robot import InvariantEkf

WINDOW = 0.005
"""Time over which a joint's acceleration is taken [s]: shorter is noisier."""
FURTHEST = 0.005
"""Longest time for which joints are taken to keep their acceleration [s]: more does harm."""
LATEST = 0.1
"""Largest latency [s]."""


class Latency(Remembering):
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
    ahead
        How far joints go on with their acceleration [s].
    memory, counts
        The readings that wait, see `waiting_arrays`; the kernels of a step put them there and take them.

    Raises
    ------
    ProblemError
        For a latency that is negative or longer than `LATEST`.
    """

    MEMORY = ("memory", "counts", "_torques")

    def __init__(self, ekf: InvariantEkf, imu: float, encoders: float) -> None:
        dt = ekf.dt
        late = [
            round(real_number(f"latency of the {name}", value, low=0.0, high=LATEST) / dt)
            for name, value in (("IMU", imu), ("encoders", encoders))
        ]
        self.steps = max(late)
        self.ahead = min(self.steps * dt, FURTHEST)
        joints = ekf.robot.joints
        imu, legs, speeds = self.steps - late[0] + 1, self.steps - late[1] + 1, 1 + max(round(WINDOW / dt), 1)
        self.counts: IntArray = np.array([self.steps, late[0], imu, legs, speeds, 0, 0, 0])
        self.memory: FloatArray = np.zeros(6 * (imu + self.steps) + joints * (2 * legs + speeds))
        self._torques: deque[FloatArray] = deque(maxlen=self.steps + 1)

    def reset(self) -> None:
        """Forget all readings."""
        self.counts[QUEUED:] = 0
        self._torques.clear()

    def torques(self, now: FloatArray) -> FloatArray:
        """Return the (joints,) torques [N m] at the filter's time, from those of now on."""
        self._torques.append(now)
        return self._torques[0]
