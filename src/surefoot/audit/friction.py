"""What a log tells about the ground's friction under each foot, over time, piece by piece.

A foot uses no more friction than there is: that bounds it below. A foot that goes on sliding uses all of it:
the median of what it uses meanwhile is the friction. A slide of a few milliseconds tells nothing from above:
in a soft world a foot that comes to rest, or has just touched down, slides with less than all of its own.

Where the ground changes, one interval for all would contradict itself. So the log is cut into windows of
`WINDOW`; a window that uses clearly more than the slides so far had, or slides on clearly less than was used
so
far, starts an interval of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
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
WINDOW = 0.1
"""Time in which the ground is taken to be the same [s]."""
CHANGE = 0.15
"""Share by which a bound must be beyond the other before the ground has changed."""
LEAST_TIME = 0.01
"""What was used contradicts a slide by so much time at least, not by a row [s] ..."""
LEAST_ROWS = 3
"""... and a slide contradicts what was used by so many rows of its middle at least."""
MOST = 50
"""Changes of a contact that are told; what comes after the last is one interval."""


@dataclass
class _Stretch:
    """Rows of one contact on one ground: histograms of the friction used, and of that used in slides."""

    used: IntArray = field(default_factory=lambda: np.zeros(BINS, dtype=np.int64))
    slides: IntArray = field(default_factory=lambda: np.zeros(BINS, dtype=np.int64))
    slid: int = 0
    start: float = np.nan
    end: float = np.nan

    def take(self, other: _Stretch) -> None:
        """Join a later window to it."""
        self.used, self.slides = self.used + other.used, self.slides + other.slides
        self.slid, self.end = self.slid + other.slid, other.end
        self.start = other.start if np.isnan(self.start) else self.start

    def low(self, least: int) -> float:
        """Return a lower bound, zero for fewer rows than `least` above it."""
        count = int(self.used.sum())
        share = min(SHARE, 1.0 - least / count) if count > least else 0.0
        return _quantile(self.used, share) if share > 0.0 else 0.0

    def high(self, least: int = 1) -> float:
        """Return an upper bound, infinite for fewer rows in the middle of slides than `least`."""
        return _quantile(self.slides, 0.5) + TOP / BINS if self.slides.sum() >= least else np.inf

    def interval(self, name: str, dt: float) -> FrictionInterval:
        """Return what it tells."""
        low, high = _quantile(self.used, SHARE), self.high()
        return FrictionInterval(name, min(low, high), high, self.slid * dt, self.start, self.end)


class FrictionCount:
    """The stretches of every contact so far, and the window that is being filled."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        count = len(setting.names)
        self._rows = max(2, round(LEAST_SLIDE / setting.dt)) if setting.dt > 0.0 else 2
        self._least = max(3, round(LEAST_TIME / setting.dt)) if setting.dt > 0.0 else 3
        self._window = max(1, round(WINDOW / setting.dt)) if setting.dt > 0.0 else 1
        self._done: list[list[_Stretch]] = [[] for _ in range(count)]
        self._now = [_Stretch() for _ in range(count)]

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
        speed = np.hypot(rows.velocities[part, :, 0], rows.velocities[part, :, 1])
        sliding = carries & before & (speed > SLIDING_SPEED + self._setting.creep)
        steady, time = _steady(sliding, self._rows), rows.time[part]
        for start in range(0, len(bins), self._window):
            at = slice(start, start + self._window)
            for k in np.flatnonzero((carries & before)[at].any(axis=0)).tolist():
                self._take(
                    k,
                    _Stretch(
                        np.bincount(bins[at, k][(carries & before)[at, k]], minlength=BINS),
                        np.bincount(bins[at, k][steady[at, k]], minlength=BINS),
                        int(sliding[at, k].sum()), float(time[at][0]), float(time[at][-1]),
                    ),
                )  # fmt: skip

    def _take(self, k: int, window: _Stretch) -> None:
        """Add a window to the contact's stretch, or begin another with it."""
        now, least = self._now[k], self._least
        if len(self._done[k]) >= MOST:
            now.take(window)
            return
        low, high = window.low(least), window.high(LEAST_ROWS)
        if low > (1.0 + CHANGE) * high:  # the ground changed within it: it belongs to neither side
            return
        if low > (1.0 + CHANGE) * now.high(LEAST_ROWS) or (1.0 + CHANGE) * high < now.low(least):
            self._done[k].append(now)
            self._now[k] = now = _Stretch()
        now.take(window)

    def intervals(self) -> tuple[FrictionInterval, ...]:
        """Return the intervals of every contact that was loaded, of each by time."""
        dt, names = self._setting.dt, self._setting.names
        return tuple(
            stretch.interval(name, dt)
            for name, done, now in zip(names, self._done, self._now, strict=True)
            for stretch in (*done, now) if stretch.used.any()
        )  # fmt: skip


def _steady(sliding: BoolArray, rows: int) -> BoolArray:
    """Return which rows (T, p) lie in slides of at least so many rows, half as many from their ends."""
    inside = np.zeros_like(sliding)
    for k in range(sliding.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], sliding[:, k], [False]]).astype(np.int8)))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop - start >= rows:
                inside[start + rows // 2 : stop - rows // 2, k] = True
    return inside


def _quantile(counts: IntArray | FloatArray, share: float) -> float:
    """Return the lower edge of the bin in which a share of the counts is reached."""
    at = int(np.searchsorted(np.cumsum(counts), share * counts.sum()))
    return at * TOP / BINS
