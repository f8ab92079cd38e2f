"""The units that logs come in, and their factors to Surefoot's own."""

from __future__ import annotations

from surefoot.errors import ProblemError, check_name
from surefoot.log.channels import Channel

_DEGREE = 0.017453292519943295
UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "rad": ("rad", 1.0),
    "deg": ("rad", _DEGREE),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", _DEGREE),
    "m/s^2": ("m/s^2", 1.0),
    "g": ("m/s^2", 9.80665),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "kgf": ("N", 9.80665),
    "N m": ("N m", 1.0),
    "1": ("1", 1.0),
    "raw": ("raw", 1.0),
}
"""Unit to the one that Surefoot keeps it in, and the factor to that."""


def factor(unit: str, channel: Channel) -> float:
    """Return the factor from a unit to a channel's own; no unit is the channel's own.

    Raises
    ------
    ProblemError
        For a unit that is not known, or is one of something else.
    """
    if not unit:
        return 1.0
    check_name("unit", unit, UNITS)
    own, by = UNITS[unit]
    wanted = channel.unit.split(", ")
    if own not in wanted:
        raise ProblemError(
            f"channel {channel.name} is in {channel.unit or 'no unit'}, {unit!r} is none of that"
        )
    if len(wanted) > 1 and by != 1.0 and channel.shape != ("joints",):
        raise ProblemError(
            f"channel {channel.name} mixes {channel.unit}: give its parts with units of their own"
        )
    return by
