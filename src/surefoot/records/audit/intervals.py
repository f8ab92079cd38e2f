"""From rows where something is wrong to intervals: joined where close, capped in number and counted."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray

MOST = 100
"""Intervals of one law and contact that are kept; further ones are counted."""


@dataclass
class Interval:
    """Rows `first` to `last` (included) of a contact in which a check failed.

    `value` is the worst measure against `limit`; `rows` counts those that failed.
    """

    check: str
    column: int
    first: int
    last: int
    value: float
    limit: float
    rows: int


@dataclass
class Track:
    """The intervals of one check; rows come piece by piece.

    Attributes
    ----------
    kept
        Intervals so far.
    dropped
        Number of those beyond `MOST` per contact.
    """

    check: str
    join: int
    kept: list[Interval] = field(default_factory=list)
    dropped: int = 0
    _latest: dict[int, Interval] = field(default_factory=dict)
    _counts: dict[int, int] = field(default_factory=dict)

    def add(self, bad: BoolArray, value: FloatArray, limit: FloatArray, first: int, column: int = -1) -> None:
        """Take rows from number `first` on: (T, c) of columns 0 to c - 1, or of (T, 1) `column`."""
        for c in np.flatnonzero(bad.any(axis=0)).tolist():
            rows = np.flatnonzero(bad[:, c])
            for part in np.split(rows, np.flatnonzero(np.diff(rows) > self.join) + 1):
                size = value[part, c]
                worst = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
                self._take(
                    Interval(
                        self.check,
                        c if column < 0 else column,
                        first + int(part[0]),
                        first + int(part[-1]),
                        float(size[worst]),
                        float(limit[part[worst], c]),
                        len(part),
                    )
                )

    def _take(self, new: Interval) -> None:
        old = self._latest.get(new.column)
        if old is not None and new.first - old.last <= self.join:
            old.last, old.rows = new.last, old.rows + new.rows
            if not new.value <= old.value:
                old.value, old.limit = new.value, new.limit
            return
        self._latest[new.column] = new
        count = self._counts[new.column] = self._counts.get(new.column, 0) + 1
        if count <= MOST:
            self.kept.append(new)
        else:
            self.dropped += 1
