"""What a film writes over its pictures: speed, contacts of the last seconds, whether laws held so far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray
from surefoot.base.errors import SurefootError
from surefoot.base.loaded import loaded_feet
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.records import Log, audit_log
from surefoot.records.log.snapshot import contact_names

MOST_ROWS = 8
"""Contacts beyond these have no row of the gait's bars."""
SPEED_TIME = 0.2
"""Over which a speed is a mean [s]."""


@dataclass(frozen=True)
class FilmFacts:
    """What there is to write at each row of a log.

    Attributes
    ----------
    names
        Of the contacts that have a row of bars.
    loaded
        (T, n) whether each of them bears weight, as `loaded_feet` tells it.
    speed
        (T,) of the base over the ground [m/s]; None for a robot that is bolted down.
    broken
        Laws that were broken and when that began [s], by time; None where no law could be judged.
    dt
        Time step [s].
    """

    names: tuple[str, ...]
    loaded: BoolArray
    speed: np.ndarray | None
    broken: tuple[tuple[float, str], ...] | None
    dt: float

    def badge(self, time: float) -> tuple[str, bool] | None:
        """Return whether the laws held up to a time [s], in words and as a truth value; None if unknown."""
        if self.broken is None:
            return None
        past = [law for start, law in self.broken if start <= time]
        return (f"{past[0]}: broken", False) if past else ("the laws of contact hold", True)

    def spans(self, step: int, seconds: float) -> list[list[tuple[float, float]]]:
        """Return for each contact the (begin, end) of its loads in the last `seconds`, as shares of them."""
        count = max(round(seconds / self.dt), 1)
        first = step - count + 1
        window = self.loaded[max(first, 0) : step + 1]
        missing = max(-first, 0)
        spans = []
        for column in window.T:
            edges = np.flatnonzero(np.diff(np.r_[False, column, False].astype(np.int8)))
            pairs = (edges + missing).reshape(-1, 2) / count
            spans.append([(float(begin), float(end)) for begin, end in pairs])
        return spans


def film_facts(log: Log, robot: Robot) -> FilmFacts:
    """Return what a film of a log says beside its pictures."""
    dt = float(log.facts["dt"])
    loaded = loaded_feet(log["forces"][:, :MOST_ROWS, 2], robot.mass * GRAVITY)
    speed = None
    if robot.floating:
        rows = max(round(SPEED_TIME / dt), 1)
        places, k = log["q"][:, :2], np.arange(len(log))
        before = np.maximum(k - rows, 0)
        way = np.linalg.norm(places - places[before], axis=1)
        speed = way / (np.maximum(k - before, 1) * dt)
    return FilmFacts(tuple(contact_names(log)[:MOST_ROWS]), loaded, speed, _broken_laws(log, robot), dt)


def _broken_laws(log: Log, robot: Robot) -> tuple[tuple[float, str], ...] | None:
    """Return the laws that a log broke, by time; None where that cannot be told."""
    try:
        report = audit_log(log, robot=robot)
    except SurefootError:
        return None
    found = tuple(sorted((float(one.start), one.law) for one in report.violations))
    return None if report.verdict == "cannot tell" and not found else found
