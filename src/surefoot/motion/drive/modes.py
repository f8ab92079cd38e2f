"""What a robot's loop can be doing, and what may follow what."""

from __future__ import annotations

from enum import StrEnum


class LoopMode(StrEnum):
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


FOLLOWS: dict[LoopMode, tuple[str, ...]] = {
    LoopMode.PASSIVE: ("damp", "stand"),
    LoopMode.DAMP: ("damp", "passive", "stand"),
    LoopMode.STAND_UP: ("damp", "lie"),
    LoopMode.STAND: ("damp", "walk", "sit", "lie"),
    LoopMode.WALK: ("damp", "stand"),
    LoopMode.SIT: ("damp", "stand", "lie"),
    LoopMode.LIE: ("damp", "passive", "stand"),
}
"""What may follow each mode; the way to `stand` leads through `stand up`."""
CONTROLLED = (LoopMode.STAND, LoopMode.WALK)
"""Modes that need to know the state of the body."""
POWERLESS = (LoopMode.PASSIVE, LoopMode.DAMP)
"""Modes that need to know nothing."""
