"""Units of a motion: radians, metres and unit quaternions out of what a file has, with notes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.records.motions.fields import MotionFields

if TYPE_CHECKING:
    from surefoot.mechanics import Robot

UNIT_LENGTH = 0.05
"""Deviation of a quaternion's length from one from which it is refused; single precision leaves 1e-3."""
ROUNDED = 1e-3
"""Deviation from which it is noted."""
TURN = 7.0
"""Angle that no joint of a robot reaches in radians: more than a turn."""
MOST_DEGREES = 720.0
"""Angle that no joint reaches in degrees."""
UNITS = {100.0: "cm", 1000.0: "mm"}
"""Lengths in a metre, and the unit."""
HIGH = 20.0
"""Height of the root over its nominal height from which lengths are no metres."""


def put_units_right(robot: Robot, fields: MotionFields) -> list[str]:
    """Turn angles into radians, places into metres and quaternions into unit ones; return notes.

    Raises
    ------
    ProblemError
        For angles that are neither radians nor degrees, and quaternions that are none.
    """
    notes = _radians(fields)
    return notes + _metres(robot, fields) + _unit_quaternions(fields) if robot.floating else notes


def _radians(fields: MotionFields) -> list[str]:
    """Turn degrees into radians, known by many joints that turn by more than `TURN`."""
    reach = np.abs(fields.joints).max(axis=0)
    if np.median(reach) <= TURN and (reach > TURN).sum() < max(3, 0.25 * len(reach)):
        return []
    if reach.max() > MOST_DEGREES:
        raise ProblemError(f"its joint angles reach {reach.max():.4g}: neither radians nor degrees")
    fields.joints = np.radians(fields.joints)
    return [f"doubt: units: joint angles reach {reach.max():.4g}, so they are read as degrees"]


def _metres(robot: Robot, fields: MotionFields) -> list[str]:
    """Turn other lengths into metres, known by the height of the root."""
    assert fields.place is not None
    height, usual = float(np.median(fields.place[:, 2])), float(robot.nominal[2])
    for factor, unit in UNITS.items():
        if usual > 0.0 and height > HIGH * usual and 0.3 < height / factor / usual < 2.0:
            fields.place = fields.place / factor
            return [f"doubt: units: the root is at a height of {height:.4g}, so places are read as {unit}"]
    return []


def _unit_quaternions(fields: MotionFields) -> list[str]:
    """Make quaternions of length one, or refuse what is none."""
    assert fields.quaternion is not None
    length = np.linalg.norm(fields.quaternion, axis=1)
    at = int(np.argmax(np.abs(length - 1.0)))
    off = float(abs(length[at] - 1.0))
    if off > UNIT_LENGTH:
        numbers = ", ".join(f"{number:.3g}" for number in fields.quaternion[at])
        raise ProblemError(
            f"its quaternions must have a length of 1, that of frame {at} has {length[at]:.4g}: ({numbers})"
        )
    fields.quaternion = fields.quaternion / length[:, None]
    if off <= ROUNDED:
        return []
    return [f"doubt: quaternion: lengths are up to {off:.3f} from 1; they were normalised"]
