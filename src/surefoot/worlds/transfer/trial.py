"""One run in one world, as it is compared with its like: configurations, and what pressed when."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray

APART = 1e-2
"""Difference of a coordinate from which two runs are apart [m, rad, -]. A judgement: more than soft ground
lets feet sink, far less than a fall takes."""


@dataclass(frozen=True)
class TrialRun:
    """A run in one world.

    Attributes
    ----------
    succeeded
        Whether it did.
    time
        (T,) of the control steps [s].
    q
        (T, nq) [m, rad, -], each at the start of its step.
    forces
        Name of each contact that pressed to (T, 3) its mean force in a step, world axes or the contact's [N].
    unsolved
        Steps that were to be exact and were not.
    """

    succeeded: bool
    time: FloatArray
    q: FloatArray
    forces: dict[str, FloatArray]
    unsolved: int = 0


class Departure(NamedTuple):
    """Where a run leaves another one.

    Attributes
    ----------
    time
        First instant at which they are apart [s]; NaN if they never are.
    contact
        The contact whose impulse until then differs most; empty for none.
    """

    time: float
    contact: str


def departure(run: TrialRun, reference: TrialRun) -> Departure:
    """Return where a run leaves another one that began in the same state.

    The contact is the one with the largest integral of the difference of forces up to there: what moved
    the two apart, if it was a contact at all.
    """
    rows = min(len(run.q), len(reference.q))
    # what is not finite is apart: no comparison with it is true
    near = np.abs(run.q[:rows] - reference.q[:rows]) <= APART
    apart = ~near.all(axis=1)
    if not apart.any():
        return Departure(float("nan"), "")
    first = int(apart.argmax())
    most, who = 0.0, ""
    for name in sorted({*run.forces, *reference.forces}):
        none = np.zeros((rows, 3))
        one, two = run.forces.get(name, none)[:first], reference.forces.get(name, none)[:first]
        size = float(np.nansum(np.linalg.norm(one - two, axis=1)))
        if size > most:
            most, who = size, name
    return Departure(float(reference.time[first]), who)
