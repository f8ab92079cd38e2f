"""How a log is spoilt: a copy to write to, places where a foot stands or flies, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from surefoot.arrays import BoolArray
from surefoot.log import Log
from surefoot.spatial import GRAVITY

LENGTH = 0.12
"""Usual length of a fault [s]."""
Numbers: TypeAlias = np.random.Generator


@dataclass(frozen=True)
class FaultyLog:
    """A log with a fault in it.

    Attributes
    ----------
    log
        The spoilt log; the clean one is untouched.
    contact
        Name of the foot, "all" or "body".
    start, end
        Of the fault [s].
    fault, symptom
        Its kind, and what an audit should report of it first.
    """

    log: Log
    contact: str
    start: float
    end: float
    fault: str = ""
    symptom: str = ""


class LogCopy:
    """A log's arrays to write to, and where its feet stand and fly."""

    def __init__(self, log: Log, rng: Numbers) -> None:
        self.arrays: dict[str, Any] = {name: np.array(array) for name, array in log.arrays.items()}
        self.facts, self.channels, self.rng = dict(log.facts), log.channels, rng
        self.dt, self.weight = float(log.fact("dt")), float(log.fact("mass")) * GRAVITY
        self.feet = list(log.fact("feet"))
        self.normal = self.arrays["forces"][..., 2].copy()
        self.rows = len(log)

    def span(self, on: BoolArray, seconds: float = LENGTH) -> tuple[int, slice] | None:
        """Return a foot and rows, so long at least, where (T, n) flags are on; away from the log's ends."""
        need, found = max(3, round(seconds / self.dt)), []
        for foot in range(on.shape[1]):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], on[:, foot].astype(int), [0]])))
            for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
                low, high = max(a, 50), min(b, self.rows - 50)
                if high - low >= need:
                    found.append((foot, low, high - need))
        if not found:
            return None
        foot, low, high = found[int(self.rng.integers(len(found)))]
        start = int(self.rng.integers(low, high + 1))
        return foot, slice(start, start + need)

    def stance(self, share: float = 0.1, seconds: float = LENGTH) -> tuple[int, slice] | None:
        """Return a foot and rows where it bears more than a share of m g."""
        return self.span(self.normal > share * self.weight, seconds)

    def flight(self, seconds: float = 0.06) -> tuple[int, slice] | None:
        """Return a foot and rows where it is 5 mm off the ground at least."""
        return self.span((self.arrays["gaps"] > 5e-3) & (self.normal == 0.0), seconds)

    def done(self, contact: str, part: slice) -> FaultyLog:
        """Return the spoilt log."""
        time = self.arrays["time"]
        log = Log(self.arrays, self.facts, channels=self.channels)
        return FaultyLog(log, contact, float(time[part.start]), float(time[part.stop - 1]) + self.dt)

    def whole(self, contact: str = "all") -> FaultyLog:
        """Return the spoilt log of a fault that lasts from end to end."""
        return self.done(contact, slice(0, self.rows))


Change: TypeAlias = Callable[[LogCopy, int, slice, float], None]
"""Spoils some rows of one foot by an amplitude."""
Spoil: TypeAlias = Callable[[LogCopy, float], FaultyLog | None]
"""Spoils a copy of a log by an amplitude; None where the run does not suit it."""


def on_stance(change: Change, share: float = 0.1) -> Spoil:
    """Return a fault that changes the readings of a stance foot."""
    return _on_rows(change, lambda copy: copy.stance(share))


def on_flight(change: Change) -> Spoil:
    """Return a fault that changes the readings of a swing foot."""
    return _on_rows(change, LogCopy.flight)


def _on_rows(change: Change, find: Callable[[LogCopy], tuple[int, slice] | None]) -> Spoil:
    """Return a fault that changes the rows that `find` finds; None where it finds none."""

    def spoil(copy: LogCopy, amplitude: float) -> FaultyLog | None:
        at = find(copy)
        if at is None:
            return None
        change(copy, *at, amplitude)
        return copy.done(copy.feet[at[0]], at[1])

    return spoil


def everywhere(change: Callable[[LogCopy, float], None], contact: str = "all") -> Spoil:
    """Return a fault that changes a log from end to end."""

    def spoil(copy: LogCopy, amplitude: float) -> FaultyLog:
        change(copy, amplitude)
        return copy.whole(contact)

    return spoil
