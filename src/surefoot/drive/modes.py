"""What a robot's loop can be doing, and what may follow what."""

from __future__ import annotations

from enum import StrEnum


class Mode(StrEnum):
    """What the loop does."""

    PASSIVE = "passive"
    """Motors are off."""
    DAMP = "damp"
    """Joints are damped: the emergency stop."""
    STAND_UP = "stand up"
    """On the way from wherever the robot lies to standing."""
    STAND = "stand"
    """Balances on its feet."""
    WALK = "walk"
    """Follows the velocity."""
    SIT = "sit"
    """Sits, or is on the way to."""
    LIE = "lie"
    """Lies folded, or is on the way to."""


FOLLOWS: dict[Mode, tuple[str, ...]] = {
    Mode.PASSIVE: ("damp", "stand"),
    Mode.DAMP: ("damp", "passive", "stand"),
    Mode.STAND_UP: ("damp", "lie"),
    Mode.STAND: ("damp", "walk", "sit", "lie"),
    Mode.WALK: ("damp", "stand"),
    Mode.SIT: ("damp", "stand", "lie"),
    Mode.LIE: ("damp", "passive", "stand"),
}
"""What may follow each mode; the way to `stand` leads through `stand up`."""
CONTROLLED = (Mode.STAND, Mode.WALK)
"""Modes that need to know the state of the body."""
POWERLESS = (Mode.PASSIVE, Mode.DAMP)
"""Modes that need to know nothing."""
