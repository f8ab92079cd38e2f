"""What a log tells about the ground's friction under each foot, over time, piece by piece.

A foot uses no more friction than there is: that bounds it below. A foot that goes on sliding uses all of it:
the median of what it uses meanwhile is the friction. A slide of a few milliseconds tells nothing from above:
in a soft world a foot that comes to rest, or has just touched down, slides with less than all of its own.

Where the ground changes, one interval for all would contradict itself. So the log is cut into windows of
`FrictionLimits.window`; a window that uses clearly more than the slides so far had, or slides on clearly less
than was used so far, starts an interval of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import BoolArray, IntArray
from surefoot.base.numerics.phases import runs_of
from surefoot.records.audit.check_limits import FrictionLimits
from surefoot.records.audit.cones import used as friction_used
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.report import FrictionInterval
from surefoot.records.audit.rows import Rows

MOST = 50
"""Changes of a contact that are reported; what comes after the last is one interval."""


@dataclass
class _Window:
    """One window of one contact: bins of the friction used, and of that used in the middle of slides."""

    used: IntArray
    slides: IntArray
    slid: int
    start: float
    end: float

    def low(self, least: int) -> int:
        """Return the bin that more than `least` rows reach, zero for fewer."""
        return int(np.partition(self.used, -least - 1)[-least - 1]) if len(self.used) > least else 0

    def high(self) -> float:
        """Return the bin of the middle of the slides, infinite without any."""
        return float(np.median(self.slides)) + 1.0 if len(self.slides) else np.inf


@dataclass
class _Stretch:
    """Rows of one contact on one ground: histograms of the friction used, and of that used in slides."""

    limits: FrictionLimits
    used: IntArray = field(init=False)
    slides: IntArray = field(init=False)
    rows: int = 0
    steady: int = 0
    slid: int = 0
    start: float = np.nan
    end: float = np.nan

    def __post_init__(self) -> None:
        self.used = np.zeros(self.limits.bins, dtype=np.int64)
        self.slides = np.zeros(self.limits.bins, dtype=np.int64)

    def take(self, window: _Window) -> None:
        """Join a later window to it."""
        self.start = self.start if self.rows else window.start
        self.used += np.bincount(window.used, minlength=self.limits.bins)
        if len(window.slides):
            self.slides += np.bincount(window.slides, minlength=self.limits.bins)
        self.rows, self.steady = self.rows + len(window.used), self.steady + len(window.slides)
        self.slid, self.end = self.slid + window.slid, window.end

    def contradicted(self, low: float, high: float, least: int) -> bool:
        """Return whether a window's bins tell of another ground."""
        limits = self.limits
        if self.steady and low > (1.0 + limits.change) * (_bin(self.slides, 0.5) + 1):
            return True
        if high == np.inf or self.rows <= least:
            return False
        return (1.0 + limits.change) * high < _bin(self.used, min(limits.share, 1.0 - least / self.rows))

    def interval(self, name: str, dt: float) -> FrictionInterval:
        """Return what it tells."""
        bins, top = self.limits.bins, self.limits.top
        low, high = _bin(self.used, self.limits.share) * top / bins, np.inf
        if self.steady:
            high = (_bin(self.slides, 0.5) + 1) * top / bins
        return FrictionInterval(name, min(low, high), high, self.slid * dt, self.start, self.end)


class FrictionCount:
    """The stretches of every contact so far, and the window that is being filled."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._limits = limits = setting.limits.friction
        count = len(setting.names)
        self._rows = max(2, round(limits.least_slide / setting.dt)) if setting.dt > 0.0 else 2
        self._least = max(3, round(limits.least_time / setting.dt)) if setting.dt > 0.0 else 3
        self._window = max(1, round(limits.window / setting.dt)) if setting.dt > 0.0 else 1
        self._done: list[list[_Stretch]] = [[] for _ in range(count)]
        self._now = [_Stretch(limits) for _ in range(count)]

    def add(self, rows: Rows) -> None:
        """Count the rows of a piece."""
        if not rows.has("forces", "contact_velocities"):
            return
        part, limits = rows.core, self._limits
        normal = rows.normal[part]
        carries = (normal > limits.enough * self._setting.weight) & ~rows.not_finite[part, :-1]
        before = np.concatenate([np.zeros((1, rows.points), dtype=bool), carries[:-1]])
        used = friction_used(rows)[part]
        bins = np.minimum((used * (limits.bins / limits.top)).astype(np.int64), limits.bins - 1)
        speed = np.hypot(rows.velocities[part, :, 0], rows.velocities[part, :, 1])
        creep = np.broadcast_to(rows.creep, rows.normal.shape)[part]
        sliding = carries & before & (speed > self._setting.limits.laws.sliding_speed + creep)
        steady, time, loaded = _steady(sliding, self._rows), rows.time[part], carries & before
        for start in range(0, len(bins), self._window):
            at = slice(start, start + self._window)
            first, last = float(time[at][0]), float(time[at][-1])
            for k in np.flatnonzero(loaded[at].any(axis=0)).tolist():
                mine, slid = bins[at, k], int(sliding[at, k].sum())
                self._take(k, _Window(mine[loaded[at, k]], mine[steady[at, k]], slid, first, last))

    def _take(self, k: int, window: _Window) -> None:
        """Add a window to the contact's stretch, or begin another with it."""
        if len(self._done[k]) < MOST:
            low, high = window.low(self._least), window.high()
            if (
                low > (1.0 + self._limits.change) * high
            ):  # the ground changed within it: it belongs to neither side
                return
            if self._now[k].contradicted(low, high, self._least):
                self._done[k].append(self._now[k])
                self._now[k] = _Stretch(self._limits)
        self._now[k].take(window)

    def intervals(self) -> tuple[FrictionInterval, ...]:
        """Return the intervals of every contact that was loaded, of each by time."""
        dt, names = self._setting.dt, self._setting.names
        return tuple(
            stretch.interval(name, dt)
            for name, done, now in zip(names, self._done, self._now, strict=True)
            for stretch in (*done, now) if stretch.rows
        )  # fmt: skip


def _steady(sliding: BoolArray, rows: int) -> BoolArray:
    """Return which rows (T, p) lie in slides of at least so many rows, half as many from their ends."""
    inside = np.zeros_like(sliding)
    for k in range(sliding.shape[1]):
        for start, stop in runs_of(sliding[:, k]):
            if stop - start >= rows:
                inside[start + rows // 2 : stop - rows // 2, k] = True
    return inside


def _bin(counts: IntArray, share: float) -> int:
    """Return the bin in which a share of the counts is reached."""
    return int(np.searchsorted(np.cumsum(counts), share * counts.sum()))
