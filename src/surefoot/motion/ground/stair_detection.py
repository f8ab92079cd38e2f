"""Stairs in a height map: how high their steps are, and how deep their treads, along a robot's way.

The heights along the way jump at edges. Edges that follow each other at one distance and by one height, two
at least, are stairs; what a map has not seen it guesses, and guesses jump once, or by another height.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Terrain
from surefoot.motion.ground.ground_settings import STAIR_DETECTION
from surefoot.motion.ground.stair_fit import StairFit, StairSteps

FINE, ACROSS = 0.01, 4
"""Samples along the way [m], and over how many of them a jump is looked for: edges in a map are blurred."""


class StairFlight(NamedTuple):
    """Stairs along a way, and where they begin on it.

    Attributes
    ----------
    steps
        Their rise and tread.
    begin
        Of their first edge that is seen [m].
    """

    steps: StairSteps
    begin: float


def find_edges(heights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places [samples] and jumps [m] of the edges in (m,) heights along a line: (k,), (k,).

    Examples
    --------
    >>> places, jumps = find_edges(np.repeat([0.0, 0.12, 0.24], 30))
    >>> places.round(2).tolist(), jumps.round(2).tolist()
    ([29.5, 59.5], [0.12, 0.12])
    """
    change = heights[ACROSS:] - heights[:-ACROSS]
    at = np.flatnonzero(np.abs(change) > STAIR_DETECTION.least_jump)
    if not len(at):
        return np.empty(0), np.empty(0)
    apart = (np.diff(at) > 1) | (np.diff(np.sign(change[at])) != 0.0)
    places, jumps = [], []
    for run in np.split(at, np.flatnonzero(apart) + 1):
        weights = np.abs(change[run])
        places.append(float(weights @ run / weights.sum()) + 0.5 * ACROSS)
        before, after = max(run[0] - 1, 0), min(run[-1] + ACROSS + 1, len(heights) - 1)
        jumps.append(float(heights[after] - heights[before]))
    return np.array(places), np.array(jumps)


def find_stairs(heights: FloatArray) -> StairFlight | None:
    """Return the longest flight of stairs in (m,) heights every `FINE` along a way [m]; None without any.

    Examples
    --------
    >>> find_stairs(np.repeat([0.0, 0.0, -0.1, -0.2, -0.3], 28))
    StairFlight(steps=StairSteps(rise=-0.1, tread=0.28), begin=0.555)
    """
    places, jumps = find_edges(heights)
    best: StairFlight | None = None
    longest = 1
    for first in range(len(places) - 1):
        for last in range(first + 1, len(places)):
            treads, rises = FINE * np.diff(places[first : last + 1]), jumps[first : last + 1]
            tread, rise = float(np.median(treads)), float(np.median(rises))
            even = np.abs(treads - tread).max() <= STAIR_DETECTION.even_treads * tread
            even &= np.abs(rises - rise).max() <= STAIR_DETECTION.even_rises * abs(rise)
            if (
                even
                and STAIR_DETECTION.treads[0] <= tread <= STAIR_DETECTION.treads[1]
                and last - first > longest - 1
            ):
                fitted, begin = np.polyfit(np.arange(last - first + 1), FINE * places[first : last + 1], 1)
                best = StairFlight(
                    StairSteps(round(rise, 6), round(float(fitted), 6)), round(float(begin), 6)
                )
                longest = last - first + 1
    return best


class StairWatch(Remembering):
    """Remembers the stairs that a robot is on, or is about to step on.

    Attributes
    ----------
    steps
        None where there are none.
    flight
        Where exactly they are, as `StairFit.parameters` has it, (10,); None as long as that is not known.
    """

    MEMORY = ("steps", "flight", "_fit", "_seen", "_time", "_begun", "_looks")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget them."""
        self.steps: StairSteps | None = None
        self.flight: FloatArray | None = None
        self._fit: StairFit | None = None
        self._seen = self._time = self._begun = -math.inf
        self._looks: deque[StairSteps] = deque(maxlen=STAIR_DETECTION.looks)

    def look(self, terrain: Terrain, place: FloatArray, yaw: float, time: float) -> None:
        """Look along the way of a robot at a (2,) place [m] with a heading [rad], at a time [s]."""
        if self._fit is not None and (
            self._fit.lost or self._fit.distance_outside(place) > STAIR_DETECTION.behind
        ):
            self.reset()
        if self.flight is not None:
            return
        along = np.array([math.cos(yaw), math.sin(yaw)])
        heights = terrain.height(
            place + np.arange(-STAIR_DETECTION.behind, STAIR_DETECTION.ahead, FINE)[:, None] * along
        )
        if (np.abs(heights[ACROSS:] - heights[:-ACROSS]) > STAIR_DETECTION.least_jump).any():
            self._seen = time
        elif time - self._seen > STAIR_DETECTION.patience:
            self.reset()
        found = find_stairs(heights)
        if found is None:
            return
        if self._fit is None or time - self._begun > STAIR_DETECTION.doubtful:
            self._begin(found, heights, along, place, time)
        self._looks.append(found.steps)
        if len(self._looks) == STAIR_DETECTION.looks:
            rise, tread = (float(np.median(a)) for a in zip(*self._looks, strict=True))
            self._adopt(StairSteps(rise, tread), STAIR_DETECTION.other)

    def _begin(
        self, found: StairFlight, heights: FloatArray, along: FloatArray, place: FloatArray, time: float
    ) -> None:
        """Begin to fit a flight that has been found in (m,) heights along a way, see `look`."""
        ground = [round((found.begin - share * found.steps.tread) / FINE) for share in (0.7, 0.2)]
        level = float(np.median(heights[max(ground[0], 0) : max(ground[1], 1)]))
        begin = float(place @ along) + found.begin - STAIR_DETECTION.behind
        self._fit = StairFit(along, begin, level, found.steps, place)
        self._begun = self._time = time

    def see(self, origin: FloatArray, points: FloatArray, time: float) -> None:
        """Learn from the (k, 3) points of a scan from a (3,) origin [m] at a time [s]."""
        if self._fit is None:
            return
        self._fit.pass_time(max(time - self._time, 0.0))
        self._time = max(time, self._time)
        self._fit.see(origin, points)
        if self.flight is not None or self._fit.known:
            self._use(self._fit)

    def touch(self, point: FloatArray) -> None:
        """Learn that a foot stands at a (3,) point [m]."""
        if self._fit is not None and self.flight is not None:
            self._fit.touch(point)
            self._use(self._fit)

    def _use(self, fit: StairFit) -> None:
        """Take a fit as the estimated flight of stairs."""
        self.flight = fit.parameters()
        self._adopt(StairSteps(fit.rise, fit.tread), STAIR_DETECTION.fitted)

    def _adopt(self, steps: StairSteps, other: float) -> None:
        """Replace the estimated steps, if the treads differ by a share of at least `other`."""
        known = self.steps
        if (
            known is None
            or abs(steps.rise - known.rise) > STAIR_DETECTION.even_rises * abs(known.rise)
            or abs(steps.tread / known.tread - 1.0) > other
        ):
            self.steps = steps
