"""How far detected contacts are from true ones: late, missed, false, wrong rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray, real_number
from surefoot.errors import ProblemError
from surefoot.numerics.phases import debounced

BOUNCE = 0.02
"""Contacts and flights that are shorter are taken for bounces where detected contacts are judged [s]."""


@dataclass(frozen=True)
class DetectionErrors:
    """How well contacts were detected.

    Attributes
    ----------
    touchdown_delays, lift_off_delays
        (k,), (m,) of every event that was found; negative if it was told early [s].
    missed, false
        Contacts that were never told, and told ones that were none.
    contacts
        How many there were.
    wrong_share
        Share of the rows in which a foot's answer is wrong.
    """

    touchdown_delays: FloatArray
    lift_off_delays: FloatArray
    missed: int
    false: int
    contacts: int
    wrong_share: float


def detection_errors(detected: BoolArray, truth: BoolArray, dt: float) -> DetectionErrors:
    """Compare detected contacts with true ones, (T, n) each.

    Parameters
    ----------
    detected, truth
        (T, n) which feet touch.
    dt
        Time between rows [s]; true phases shorter than `BOUNCE` are closed.

    Raises
    ------
    ProblemError
        If their shapes differ or there are fewer than two rows.
    """
    if detected.shape != truth.shape or truth.ndim != 2 or len(truth) < 2:
        raise ProblemError(f"two (T, n) arrays of one shape are needed, got {detected.shape}, {truth.shape}")
    step = real_number("dt", dt, low=1e-9)
    time = step * np.arange(len(truth), dtype=np.float64)
    downs, ups, missed, false, contacts, wrong = [], [], 0, 0, 0, 0
    for k in range(truth.shape[1]):
        real = debounced(time, truth[:, k], BOUNCE)
        told = detected[:, k]
        wrong += int(np.count_nonzero(real != told))
        phases, guesses = _phases(real), _phases(told)
        contacts += len(phases)
        overlap = (phases[:, None, 0] < guesses[None, :, 1]) & (guesses[None, :, 0] < phases[:, None, 1])
        missed += int(np.count_nonzero(~overlap.any(axis=1)))
        false += int(np.count_nonzero(~overlap.any(axis=0)))
        for (start, stop), over in zip(phases, overlap, strict=True):
            if over.any():
                mine = guesses[over]
                # what the recording cuts off at its ends is no event
                downs += [mine[0, 0] - start] if start > 0 else []
                ups += [mine[-1, 1] - stop] if stop < len(truth) else []
    return DetectionErrors(
        step * np.array(downs), step * np.array(ups), missed, false, contacts, wrong / truth.size
    )


def _phases(touch: BoolArray) -> IntArray:
    """Return (k, 2) first row of each contact, and the row after its last."""
    padded = np.concatenate([[False], touch, [False]]).astype(np.int8)
    return np.flatnonzero(np.diff(padded)).reshape(-1, 2)
