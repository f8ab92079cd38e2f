"""One run of one mass on one contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class SlideDrop:
    """What an engine is asked to run.

    Attributes
    ----------
    settings
        The engine's contact parameters.
    mass
        [kg].
    gravity
        [m/s²].
    gap, speed
        Where the mass starts above the ground, and its upward velocity [m], [m/s].
    dt
        The engine's step [s].
    steps
        How many.
    until
        "apart" ends the run when the mass has left the ground.
    """

    settings: dict[str, Any]
    mass: float
    gravity: float
    gap: float
    speed: float
    dt: float
    steps: int
    until: str = ""
