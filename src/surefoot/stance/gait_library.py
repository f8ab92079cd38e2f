"""Named gaits of two and four feet, from a table."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.arrays import whole_number
from surefoot.errors import ProblemError, check_name
from surefoot.stance.gait import Gait


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
        "trot": GaitPattern(0.40, 0.55, (0.0, 0.5, 0.5, 0.0)),
        "walk": GaitPattern(0.80, 0.78, (0.25, 0.75, 0.0, 0.5)),
        "pace": GaitPattern(0.36, 0.60, (0.0, 0.5, 0.0, 0.5)),
        "bound": GaitPattern(0.34, 0.55, (0.0, 0.0, 0.5, 0.5)),
        "flying_trot": GaitPattern(0.34, 0.44, (0.0, 0.5, 0.5, 0.0)),
    },
    2: {
        "stand": GaitPattern(0.5, 1.0, (0.0, 0.0)),
        "walk": GaitPattern(0.70, 0.60, (0.0, 0.5)),
    },
}
REFERENCE_LEG = 0.3
"""Leg length that the patterns' periods are given for [m]."""


def gait_names(feet: int = 4) -> tuple[str, ...]:
    """Return the names of the gaits for a number of feet."""
    return tuple(PATTERNS.get(feet, {}))


def named_gait(name: str, feet: int = 4, leg: float = REFERENCE_LEG, period: float | None = None) -> Gait:
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

    Raises
    ------
    ProblemError
        If there is no such gait for that many feet.

    Examples
    --------
    >>> named_gait("trot").modes.tolist()
    [15, 9, 15, 6]
    """
    patterns = PATTERNS.get(whole_number("feet", feet))
    if patterns is None:
        known = " and ".join(str(count) for count in sorted(PATTERNS))
        raise ProblemError(
            f"there are named gaits for {known} feet, not for {feet}: sf.Gait.from_phases makes others"
        )
    check_name(f"gait for {feet} feet", name, patterns)
    pattern = patterns[name]
    length = pattern.period * (leg / REFERENCE_LEG) ** 0.5 if period is None else period
    return Gait.from_phases(name, length, pattern.duty, pattern.offset)
