"""What a log tells about the ground's friction under each foot, piece by piece.

A foot that sticks uses no more friction than there is: that bounds it below. A foot that slides uses all of
it: the median of what it uses while it slides is the friction.
"""

from __future__ import annotations

import numpy as np

from surefoot.audit.laws import SLIDING_SPEED
from surefoot.audit.report import FrictionInterval
from surefoot.audit.rows import Rows
from surefoot.audit.setting import Setting

ENOUGH = 0.02
"""Share of m g from which a foot's force tells of friction."""
LEAST_SLIDE = 0.01
"""Sliding for less time tells nothing [s]."""
BINS, TOP = 2000, 4.0
"""Friction is counted in so many bins up to this value."""
SHARE = 0.995
"""Share of the sticking rows that use no more than the lower bound: a single row proves nothing."""


class FrictionCount:
    """Histograms of the friction used while sticking and while sliding, of every contact."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._counts = np.zeros((2, len(setting.names), BINS), dtype=np.int64)

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
        for kind, which in enumerate((carries & before & ~slides, carries & before & slides)):
            for k in range(rows.points):
                self._counts[kind, k] += np.bincount(bins[which[:, k], k], minlength=BINS)

    def intervals(self) -> tuple[FrictionInterval, ...]:
        """Return the interval of every contact that was loaded."""
        out = []
        for k, name in enumerate(self._setting.names):
            stuck, slid = self._counts[0, k], self._counts[1, k]
            if not stuck.any() and not slid.any():
                continue
            low = _quantile(stuck, SHARE) if stuck.any() else 0.0
            time = float(slid.sum()) * self._setting.dt
            high = _quantile(slid, 0.5) + TOP / BINS if time >= LEAST_SLIDE else float("inf")
            out.append(FrictionInterval(name, min(low, high), high, time))
        return tuple(out)


def _quantile(counts: np.ndarray[tuple[int], np.dtype[np.int64]], share: float) -> float:
    """Return the lower edge of the bin in which a share of the counts is reached."""
    at = int(np.searchsorted(np.cumsum(counts), share * counts.sum()))
    return at * TOP / BINS
