"""The largest disturbance in one direction that a stance withstands."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import finite_array
from surefoot.equilibrium.limits import Question, equations
from surefoot.equilibrium.margin import BAND, ENDLESS, FEASIBLE, most_margin
from surefoot.errors import ProblemError

_MOST = 1e6
"""Disturbances of more loads than this count as any."""


def largest_disturbance(question: Question, direction: ArrayLike) -> float:
    """Return how far a wrench in `direction` on the robot may grow: see `Verdict.largest_disturbance`.

    It is enclosed by verdicts that the stance can and cannot, to a billionth of itself.

    Parameters
    ----------
    question
        Whether it has forces for an answer without the disturbance.
    direction
        (6,) [force; moment about the centre of mass], world axes.

    Raises
    ------
    ProblemError
        If the direction is not (6,), finite and nonzero.
    """
    push = finite_array("direction", direction, (6,))
    if not np.any(push):
        raise ProblemError("direction must not be zero")
    if not len(question.stance):
        return 0.0
    eq = equations(question)
    d = np.zeros(len(eq.w))
    d[:3], d[3:6] = -push[:3], -push[3:] / eq.length
    size = float(np.linalg.norm(d))
    d /= size

    def margin(s: float) -> float:
        # forces and bounds in units of the load with the disturbance: of size one however large that is
        outcome, most, *_ = most_margin(eq.A, eq.e, (eq.w + s * d) / (1.0 + s), eq.lorentz, eq.blocks)
        return most if outcome in (FEASIBLE, ENDLESS) else -math.inf

    if margin(0.0) <= BAND:
        return 0.0
    low, high = 0.0, 1.0
    while margin(high) > -math.inf:
        if high > _MOST:
            return math.inf
        low, high = high, 2.0 * high
    while high - low > BAND * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if margin(middle) > -math.inf else (low, middle)
    return low * eq.scale / size
