"""The phases of all feet of a schedule at once: asked for at every step, and changed at a few."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from surefoot.arrays import FloatArray


class _Schedule(Protocol):
    feet: int

    def phase(self, foot: int, time: float) -> tuple[bool, float, float]: ...


class PhaseTable:
    """Remembers what a schedule has said of its feet until one of them lifts or lands.

    Parameters
    ----------
    margin
        A phase is over this much before its end [s].
    """

    def __init__(self, margin: float) -> None:
        self._margin = margin
        self._rows: FloatArray = np.zeros((0, 3))
        self.forget()

    def forget(self) -> None:
        """Forget what was said: the schedule has changed."""
        self._since, self._until = math.inf, -math.inf

    def at(self, schedule: _Schedule, time: float) -> FloatArray:
        """Return the (feet, 3) rows of `ContactSchedule.phases` at a time [s]; not to be written to."""
        if self._since <= time < self._until:
            return self._rows
        rows = np.array([schedule.phase(k, time) for k in range(schedule.feet)], dtype=np.float64)
        self._since = float(rows[:, 1].max()) - self._margin
        self._until = float(rows[:, 2].min()) - self._margin
        self._rows = rows
        return rows
