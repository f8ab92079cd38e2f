"""Named gaits: of two and four feet from a table, of any other number from one rule, phase by place.

On each side feet touch down one after the other from the rear to the front, a wave that runs forward, as
insects and spiders walk; the sides are half a period apart [1]_. How much of the period a foot is in the air
makes the gait: `wave`, one foot of all at a time; `ripple`, one of each side; `tripod`, every other one of
each side, both halves in turn.

References
----------
.. [1] D. M. Wilson, "Insect walking", Annual Review of Entomology 11, 1966.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.gaits.gait_settings import GAITS


@dataclass(frozen=True)
class GaitPattern:
    """A gait as data, in shares of a period that scales with the square root of the leg's length.

    Attributes
    ----------
    period
        Length of a cycle for a leg of 0.3 m [s].
    duty
        Share of the period that each foot carries.
    offset
        When each foot touches down, as a share of the period; feet front to back, left before right.
    """

    period: float
    duty: float
    offset: tuple[float, ...]


PATTERNS: dict[int, dict[str, GaitPattern]] = {
    4: {
        "stand": GaitPattern(0.5, 1.0, (0.0, 0.0, 0.0, 0.0)),
        "trot": GaitPattern(GAITS.trot_period, GAITS.trot_duty, (0.0, 0.5, 0.5, 0.0)),
        "walk": GaitPattern(GAITS.walk_period, GAITS.walk_duty, (0.25, 0.75, 0.0, 0.5)),
        "pace": GaitPattern(GAITS.pace_period, GAITS.pace_duty, (0.0, 0.5, 0.0, 0.5)),
        "bound": GaitPattern(GAITS.bound_period, GAITS.bound_duty, (0.0, 0.0, 0.5, 0.5)),
        "flying_trot": GaitPattern(GAITS.flying_trot_period, GAITS.flying_trot_duty, (0.0, 0.5, 0.5, 0.0)),
    },
    2: {
        "stand": GaitPattern(0.5, 1.0, (0.0, 0.0)),
        "walk": GaitPattern(GAITS.two_feet_period, GAITS.two_feet_duty, (0.0, 0.5)),
    },
}
REFERENCE_LEG = 0.3
"""Leg length that the patterns' periods are given for [m]."""


def gait_names(feet: int = 4) -> tuple[str, ...]:
    """Return the names of the gaits for a number of feet."""
    return tuple(patterns_of(feet))


def patterns_of(feet: int, places: ArrayLike | None = None) -> Mapping[str, GaitPattern]:
    """Return the gaits of a number of feet by name: of `PATTERNS`, else by place; none for fewer than three.

    Parameters
    ----------
    feet
        Their number.
    places
        (feet, 2) forward and left [m], from where the rule takes its order; None for pairs from front to
        back, left before right, an odd one last.

    Examples
    --------
    >>> {name: pattern.offset for name, pattern in patterns_of(6).items()}["tripod"]
    (0.5, 0.0, 0.0, 0.5, 0.5, 0.0)
    """
    if feet in PATTERNS or feet < 3:
        return PATTERNS.get(feet, {})
    rows = np.arange(feet) // 2
    side = np.where(np.arange(feet) % 2 == 0, 1.0, -1.0)
    if feet % 2:
        side[-1] = 0.0
    xy = np.column_stack([-rows, side]) if places is None else finite_array("places", places, (feet, 2))
    return _by_place(xy[:, 0], xy[:, 1] - xy[:, 1].mean())


def _by_place(x: FloatArray, y: FloatArray) -> dict[str, GaitPattern]:
    """Return the gaits of feet at places along the robot and to its left, (n,) each [m]."""
    n, reach = len(x), GAITS.beside * float(np.abs(y).max())
    sides = [[k for k in np.argsort(x) if y[k] > reach], [k for k in np.argsort(x) if y[k] < -reach]]
    for k in np.flatnonzero(np.abs(y) <= reach):  # one in the middle joins the side of fewer feet
        shorter = min(sides, key=len)
        shorter.append(int(k))
        shorter.sort(key=lambda j: float(x[j]))
    longest = max(len(one) for one in sides)
    wave, ripple, tripod = np.zeros(n), np.zeros(n), np.zeros(n)
    for s, one in enumerate(sides):
        for rank, k in enumerate(one):
            wave[k] = (rank + s * len(sides[0])) / n
            ripple[k] = (rank / longest + 0.5 * s) % 1.0
            tripod[k] = 0.5 * ((rank + s + longest) % 2)
    share = min(1.0 / n, 0.2)
    found = {"stand": GaitPattern(0.5, 1.0, (0.0,) * n)}
    if n >= 5:
        found["tripod"] = GaitPattern(GAITS.tripod_period, GAITS.tripod_duty, tuple(tripod.tolist()))
        found["ripple"] = GaitPattern(GAITS.swing_time * longest, 1.0 - 1.0 / longest, tuple(ripple.tolist()))
    found["wave"] = GaitPattern(GAITS.swing_time / share, 1.0 - share, tuple(wave.tolist()))
    return found


def named_gait(
    name: str,
    feet: int = 4,
    leg: float = REFERENCE_LEG,
    period: float | None = None,
    places: ArrayLike | None = None,
) -> Gait:
    """Return a gait of the library, its period matched to the robot's size.

    Parameters
    ----------
    name
        See `gait_names`.
    feet
        Number of feet.
    leg
        Height of the hips above the ground [m]; by Froude's rule the period grows with its root.
    period
        Length of a cycle [s]; None for the pattern's own.
    places
        (feet, 2) where the feet are, forward and left [m]; see `patterns_of`.

    Raises
    ------
    ProblemError
        If there is no such gait for that many feet.

    Examples
    --------
    >>> named_gait("trot").modes.tolist()
    [15, 9, 15, 6]
    """
    patterns = patterns_of(whole_number("feet", feet), places)
    if not patterns:
        raise ProblemError(f"there are gaits for two feet or more, not for {feet}")
    check_name(f"gait for {feet} feet", name, patterns)
    pattern = patterns[name]
    length = pattern.period * (leg / REFERENCE_LEG) ** 0.5 if period is None else period
    return Gait.from_phases(name, length, pattern.duty, pattern.offset)
