"""How much a frame of a toss counts in the loss: the less, the farther off the median toss is at its time.

Errors grow from impact to impact: at the end of a toss they are a hundred times what they are right after the
first touch, and squares of them would leave nothing to the frames that tell an impact best. So a frame's
deviation is divided by the square root of what the median toss is off at its time, half the way from
deviations as they are to deviations in units of that. Places and turns have weights of their own, their
geometric mean over all frames is 1, so that a loss is in widths still.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.identification.toss_errors import clip_deviations
from surefoot.records.identification.toss_loss import FLOOR, KINDS, spread_kinds

POWER = 0.5
"""Of what the median toss is off, by which a deviation is divided."""
FEWEST = 8
"""Tosses that tell how far off the median one is; later than they last it counts as no nearer."""


def frames_since(frames: IntArray, before: IntArray) -> IntArray:
    """Return (N,) how many frames after its toss's first touch each is, of (B,) frames, (B,) before it.

    >>> frames_since(np.array([3, 2]), np.array([1, 0]))
    array([-1,  0,  1,  0,  1])
    """
    first = np.cumsum(frames) - frames + before
    return np.asarray(np.arange(int(frames.sum())) - np.repeat(first, frames))


def error_growth(rows: FloatArray, since: IntArray) -> FloatArray:
    """Return (T, 2) how far off the median toss is so many frames after its first touch [widths].

    Of places and of turns, from deviations (N, m) and what `frames_since` says of them; it never falls.
    """
    rows = clip_deviations(rows)
    sizes = np.stack([np.linalg.norm(rows[:, part], axis=1) for part in KINDS], axis=1)
    growth = np.full((max(int(since.max()), 0) + 1, 2), FLOOR)
    for time in range(len(growth)):
        here = sizes[since == time]
        if len(here) >= FEWEST:
            growth[time] = np.median(here, axis=0)
    return np.asarray(np.maximum.accumulate(np.maximum(growth, FLOOR), axis=0))


def frame_weights(growth: FloatArray, since: IntArray, columns: int) -> FloatArray:
    """Return the weights (N, m) of deviations with so many columns; `since` as in `error_growth`."""
    size = growth[np.clip(since, 0, len(growth) - 1)]
    weights = (np.exp(np.log(size).mean(axis=0)) / size) ** POWER
    return spread_kinds(weights, columns)
