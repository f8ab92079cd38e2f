"""States that no command can be computed for, and what is commanded then: torques that slow the joints."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.mechanics import Robot
from surefoot.motion.control.control_settings import BODY_CONTROL

LARGEST = 1e6
"""A state with a larger number is as good as none [m, rad, m/s, rad/s]."""
DAMPING_RATE = BODY_CONTROL.damping_rate
"""A setting, as compiled code folds it."""
FALLEN = 0.5
"""Cosine of the base's tilt below which a robot is not over its feet any more [-]: 60 degrees, as `Fall`."""


@kernel
def computable(q: FloatArray, v: FloatArray) -> bool:
    """Tell whether every number of a state (nq,), (nv,) [m/s, rad/s] is finite and at most `LARGEST`."""
    for x in q:
        if not abs(x) <= LARGEST:
            return False
    for x in v:  # noqa: SIM110  # a loop compiles faster than all()
        if not abs(x) <= LARGEST:
            return False
    return True


@kernel
def computable_pose(q: FloatArray, v: FloatArray) -> bool:
    """Tell whether a state (nq,), (nv,) of a floating base is `computable`, its quaternion one of a rotation.

    Between 0.5 and 2 long it is one that has drifted; zeros are what a sensor says that has no attitude yet.
    """
    if not computable(q, v):
        return False
    square = 0.0
    for i in range(3, 7):
        square += q[i] * q[i]
    return 0.25 < square < 4.0


def damping_torques(robot: Robot, v: FloatArray, limits: FloatArray) -> FloatArray:
    """Return torques within (joints,) limits [N m] that slow the joints of a floating robot: (joints,).

    Joints whose speed in (nv,) `v` is not finite get no torque. The inertia at every joint is that of the
    nominal pose, since the present one may be unknown.
    """
    import pinocchio

    M = pinocchio.crba(robot.model, robot.model.createData(), robot.nominal)
    speed = np.clip(np.where(np.isfinite(v), v, 0.0)[6:], -LARGEST, LARGEST)
    return np.asarray(np.clip(-DAMPING_RATE * np.diag(M)[6:] * speed, -limits, limits))
