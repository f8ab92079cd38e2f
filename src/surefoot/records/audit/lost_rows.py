"""Rows that a log lacks: its clock goes on by several steps at once, again and again."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.limits import RecordLimits
from surefoot.records.log import Log


def find_lost_rows(log: Log, steps: FloatArray, limits: RecordLimits) -> str:
    """Return which rows a log lacks, in words; "" where it lacks none.

    Parameters
    ----------
    log
        Whose recorder may say it itself, by the fact ``unseen_steps``.
    steps
        (k,) the positive steps of its clock [s]. Rows are lost where most are whole numbers of a usual step,
        and too many of them two or more; a clock that jitters says nothing.
    limits
        `lost_share` and `even`.
    """
    unseen = int(np.max(log.facts.get("unseen_steps", 0)))
    if unseen:
        return f"rows are missing in {unseen} places: steps were made that the recorder did not see"
    if steps.size < 2:
        return ""
    usual = float(np.quantile(steps, 0.25, method="lower"))
    ratio = steps / usual
    whole = np.rint(ratio)
    regular = np.abs(ratio - whole) <= limits.even
    several = regular & (whole >= 2.0)
    if several.mean() < limits.lost_share or regular.mean() < 1.0 - limits.lost_share:
        return ""
    return (
        f"rows are uneven: {int(several.sum())} of {steps.size} are {usual:g} s times 2 or more apart, the others "
        f"{usual:g} s; those between are missing"
    )
