"""What a log tells about the ground's friction under each foot, piece by piece.

A foot uses no more friction than there is: that bounds it below. A foot that goes on sliding uses all of it:
the median of what it uses meanwhile is the friction. A slide of a few milliseconds tells nothing from above:
in a soft world a foot that comes to rest, or has just touched down, slides with less than all of its own.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray
from surefoot.audit.laws import SLIDING_SPEED
from surefoot.audit.report import FrictionInterval
from surefoot.audit.rows import Rows
from surefoot.audit.setting import Setting

ENOUGH = 0.02
"""Share of m g from which a foot's force tells of friction."""
LEAST_SLIDE = 0.02
"""A slide that lasts less tells nothing from above, nor do this time's halves at its ends [s]."""
BINS, TOP = 2000, 4.0
"""Friction is counted in so many bins up to this value."""
SHARE = 0.995
"""Share of the rows that use no more than the lower bound: a single row proves nothing."""


class FrictionCount:
    """Histograms of the friction used, and of that used in the middle of long slides, of every contact."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._counts = np.zeros((2, len(setting.names), BINS), dtype=np.int64)
        self._slid = np.zeros(len(setting.names), dtype=np.int64)
        self._rows = max(2, round(LEAST_SLIDE / setting.dt))

    def add(self, rows: Rows) -> None:
        """Count the rows of a piece."""
        if not rows.has("forces", "contact_velocities"):
            return
        part = rows.core
        normal = rows.normal[part]
        carries = (normal > ENOUGH * self._setting.weight) & ~rows.lost[part, :-1]
        before = np.concatenate([np.zeros((1, rows.points), dtype=bool), carries[:-1]])
        used = rows.tangential[part] / np.maximum(normal, 1e-12)
        bins = np.minimum((used * (BINS / TOP)).astype(np.int64), BINS - 1)
        slides = np.hypot(rows.velocities[part, :, 0], rows.velocities[part, :, 1]) > SLIDING_SPEED
        sliding = carries & before & slides
        self._slid += sliding.sum(axis=0)
        for kind, which in enumerate((carries & before, _steady(sliding, self._rows))):
            for k in range(rows.points):
                self._counts[kind, k] += np.bincount(bins[which[:, k], k], minlength=BINS)

    def intervals(self) -> tuple[FrictionInterval, ...]:
        """Return the interval of every contact that was loaded."""
        out = []
        for k, name in enumerate(self._setting.names):
            used, steady = self._counts[0, k], self._counts[1, k]
            if not used.any():
                continue
            low, time = _quantile(used, SHARE), float(self._slid[k]) * self._setting.dt
            high = _quantile(steady, 0.5) + TOP / BINS if steady.any() else float("inf")
            out.append(FrictionInterval(name, min(low, high), high, time))
        return tuple(out)


def _steady(sliding: BoolArray, rows: int) -> BoolArray:
    """Return which rows (T, p) lie in slides of at least so many rows, half as many from their ends."""
    inside = np.zeros_like(sliding)
    for k in range(sliding.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], sliding[:, k], [False]]).astype(np.int8)))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop - start >= rows:
                inside[start + rows // 2 : stop - rows // 2, k] = True
    return inside


def _quantile(counts: np.ndarray[tuple[int], np.dtype[np.int64]], share: float) -> float:
    """Return the lower edge of the bin in which a share of the counts is reached."""
    at = int(np.searchsorted(np.cumsum(counts), share * counts.sum()))
    return at * TOP / BINS
