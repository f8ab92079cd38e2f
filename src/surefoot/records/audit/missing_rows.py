"""Rows that a log lacks: its clock goes on by several steps at once, again and again."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.log import Log

MISSING_SHARE = 0.05
"""Share of a log's steps that are several of its usual ones, from which rows count as missing [-].

A judgement: real recorders drop single rows, a loop that misses every n-th loses 1 / n.
"""
EVEN = 0.1
"""Share of a usual step by which a step may differ from a whole number of them [-]; a judgement."""


def find_missing_rows(log: Log, steps: FloatArray) -> str:
    """Return which rows a log lacks, in words; "" where it lacks none.

    Parameters
    ----------
    log
        Whose recorder may say it itself, by the fact ``unseen_steps``.
    steps
        (k,) the positive steps of its clock [s]. Rows are lost where most are whole numbers of a usual step,
        and too many of them two or more; a clock that jitters says nothing.
    """
    unseen = int(np.max(log.facts.get("unseen_steps", 0)))
    if unseen:
        return f"rows are missing in {unseen} places: steps were made that the recorder did not see"
    if steps.size < 2 or steps.max() < 1.5 * steps.min():  # no step is two of another
        return ""
    usual = float(np.quantile(steps, 0.25, method="lower"))
    ratio = steps / usual
    whole = np.rint(ratio)
    regular = np.abs(ratio - whole) <= EVEN
    several = regular & (whole >= 2.0)
    if several.mean() < MISSING_SHARE or regular.mean() < 1.0 - MISSING_SHARE:
        return ""
    return (
        f"rows are uneven: most are {usual:g} s apart, {int(several.sum())} of {steps.size} two or more "
        "times that; those between are missing"
    )
