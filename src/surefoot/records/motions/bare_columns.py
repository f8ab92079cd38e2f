"""Where place, quaternion and joints stand in a table whose columns have no names."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.motions.fields import MotionFields

ROOT = 7
"""Columns of the root in whole configurations: place and quaternion."""
UNIT = 0.02
"""Deviation of a quaternion's length from one by which its columns are known [-]."""
EVEN = 1e-3
"""Deviation of steps, over the step, up to which a column counts frames or has their times [-]."""


def fields_of_rows(rows: FloatArray, turn: str) -> MotionFields:
    """Return the fields of whole configurations (T, 7 + n): the root first, after a counter, or last.

    The root stands first unless only another place has numbers that a unit quaternion can be.
    """
    if _are_unit(rows[:, 3:ROOT]):
        return MotionFields("", rows[:, ROOT:], rows[:, :3], rows[:, 3:ROOT], turn)
    step = _even_step(rows[:, 0])
    if step > 0.0 and rows.shape[1] > ROOT + 1 and _are_unit(rows[:, 4 : ROOT + 1]):
        out = MotionFields("", rows[:, ROOT + 1 :], rows[:, 1:4], rows[:, 4 : ROOT + 1], turn)
        counts = abs(step - 1.0) < EVEN
        out.times = None if counts else rows[:, 0].copy()
        out.notes.append(f"its first column {'counts frames' if counts else 'is read as times [s]'}")
        return out
    if _are_unit(rows[:, -4:]):
        out = MotionFields("", rows[:, :-ROOT], rows[:, -ROOT:-4], rows[:, -4:], turn)
        out.notes.append(
            "doubt: columns: read as joints, place, quaternion: only the last four are of length 1"
        )
        return out
    return MotionFields("", rows[:, ROOT:], rows[:, :3], rows[:, 3:ROOT], turn)


def _are_unit(numbers: FloatArray) -> bool:
    """Tell whether (T, 4) numbers are unit quaternions."""
    return bool(np.abs(np.linalg.norm(numbers, axis=1) - 1.0).max() <= UNIT)


def _even_step(column: FloatArray) -> float:
    """Return the step of (T,) evenly rising numbers, 0 for others."""
    steps = np.diff(column)
    step = float(steps.mean())
    return step if step > 0.0 and np.abs(steps - step).max() <= EVEN * step else 0.0
