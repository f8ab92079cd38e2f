"""The largest disturbance in one direction that a stance withstands."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array
from surefoot.equilibrium.cone_program import OPTIMAL, STALLED, UNBOUNDED, minimise
from surefoot.equilibrium.limits import Equations, Question, equations
from surefoot.equilibrium.margin import BAND, ENDLESS, FEASIBLE, GAP, most_margin
from surefoot.errors import ProblemError
from surefoot.numerics.orthogonal import coordinates, orthonormal_rows, turn_first_row

_MOST = 1e6
"""Disturbances of more loads than this count as any."""


def farthest(
    A: FloatArray, w: FloatArray, d: FloatArray, lorentz: int, start: FloatArray
) -> tuple[int, float]:
    """Maximise s with A x = w + s d, x (m,) in the cone, from a strictly feasible x at s = 0.

    A is (p, m), w and d are (p,).

    Returns a status and s; s is 0 where d lies outside the rows' range. STALLED stands for an x that does not
    meet the equations: rounding ended the search, s means nothing. (Plain Python around the compiled steps:
    compiling them once more would take longer than it saves.)
    """
    p, m = A.shape
    Q, T, pivots = np.empty((p, m)), np.empty((p, p)), np.empty(p, dtype=np.int64)
    b, a, h = np.zeros(p), np.zeros(p), np.zeros(p)
    rank = orthonormal_rows(A, Q, T, pivots)
    if coordinates(T, pivots, rank, d, a) > BAND:
        return OPTIMAL, 0.0
    coordinates(T, pivots, rank, w, b)
    alpha = turn_first_row(Q, rank, a, h, b)
    x, y, z = start.copy(), np.empty(rank - 1), np.empty(m)
    status, _ = minimise(Q[1:rank], b[1:rank], -Q[0], lorentz, x, y, z, GAP, -1e6, -b[0])
    s = float(Q[0] @ x - b[0]) / alpha
    if status == UNBOUNDED:
        return UNBOUNDED, s
    return (OPTIMAL if float(np.abs(A @ x - w - s * d).max()) <= BAND else STALLED), s


def _by_verdicts(eq: Equations, d: FloatArray) -> float:
    """Return the largest s with forces that give w + s d, between verdicts that it can and cannot."""

    def held(s: float) -> bool:
        return most_margin(eq.A, eq.e, eq.w + s * d, eq.lorentz, eq.blocks)[0] in (FEASIBLE, ENDLESS)

    low, high = 0.0, 1.0
    while held(high):
        if high > _MOST:
            return math.inf
        low, high = high, 2.0 * high
    while high - low > BAND * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if held(middle) else (low, middle)
    return low


def largest_disturbance(question: Question, direction: ArrayLike) -> float:
    """Return how far a wrench in `direction` on the robot may grow: see `Verdict.largest_disturbance`.

    Parameters
    ----------
    question
        One that has forces for an answer.
    direction
        (6,) [force; moment about the centre of mass], world axes.

    Raises
    ------
    ProblemError
        If the direction is not (6,), finite and nonzero.
    """
    push = nonzero(direction)
    eq = equations(question)
    outcome, margin, x, _, _ = most_margin(eq.A, eq.e, eq.w, eq.lorentz, eq.blocks)
    if outcome not in (FEASIBLE, ENDLESS) or margin <= BAND:
        return 0.0
    d = np.zeros(len(eq.w))
    d[:3], d[3:6] = -push[:3], -push[3:] / eq.length
    size = float(np.linalg.norm(d))
    status, reach = farthest(eq.A, eq.w, d / size, eq.lorentz, x)
    if status == STALLED:
        reach = _by_verdicts(eq, d / size)
    return math.inf if status == UNBOUNDED else max(0.0, reach) * eq.scale / size


def nonzero(direction: ArrayLike) -> FloatArray:
    """Return a direction as (6,) numbers [N, N m].

    Raises
    ------
    ProblemError
        If it is not (6,), finite and nonzero.
    """
    push = finite_array("direction", direction, (6,))
    if not np.any(push):
        raise ProblemError("direction must not be zero")
    return push
