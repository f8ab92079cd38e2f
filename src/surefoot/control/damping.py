"""What a controller commands when nothing can be computed: torques that slow the joints."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.robot import Robot

DAMPING_RATE = 10.0
"""Rate at which joints are slowed when nothing else can be done [1/s]."""


def damping_torques(robot: Robot, v: FloatArray, limits: FloatArray) -> FloatArray:
    """Return torques within (joints,) limits [N m] that slow the joints of a floating robot: (joints,).

    Joints whose speed in (nv,) `v` is not finite get no torque. The inertia at every joint is that of the
    nominal pose, since the present one may be unknown.
    """
    import pinocchio

    M = pinocchio.crba(robot.model, robot.model.createData(), robot.nominal)
    speed = np.where(np.isfinite(v), v, 0.0)[6:]
    return np.asarray(np.clip(-DAMPING_RATE * np.diag(M)[6:] * speed, -limits, limits))
