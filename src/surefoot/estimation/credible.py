"""Whether the numbers of a state estimate can be those of a robot at all."""

from __future__ import annotations

import math

from surefoot.arrays import FloatArray
from surefoot.kernels import kernel


@kernel
def known(q: FloatArray, v: FloatArray) -> bool:
    """Tell whether all numbers of a state (nq,) [m, -, rad] and (nv,) [m/s, rad/s] are finite."""
    total = 0.0
    for x in q:
        total += 0.0 * x
    for x in v:
        total += 0.0 * x
    return total == 0.0  # NaN and infinity times zero are NaN


@kernel
def credible(X: FloatArray, bias: FloatArray, fastest: float, largest: FloatArray) -> bool:
    """Tell whether a filter's state is one that a robot with working sensors has; never for NaN.

    Parameters
    ----------
    X, bias
        (3, 5 + n) and (6,) state of the filter; its fourth column is the velocity [m/s].
    fastest
        Largest speed [m/s].
    largest
        (2,) largest biases of gyro [rad/s] and accelerometer [m/s²], each of its axes.
    """
    speed = math.sqrt(X[0, 3] ** 2 + X[1, 3] ** 2 + X[2, 3] ** 2)
    if not speed <= fastest:
        return False
    for i in range(6):  # noqa: SIM110  # a loop compiles faster than all()
        if not abs(bias[i]) <= largest[i // 3]:
            return False
    return True
