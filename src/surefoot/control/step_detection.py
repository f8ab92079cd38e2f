"""Stairs in a height map: how high their steps are, and how deep their treads, along a robot's way.

The heights along the way jump at edges. Edges that follow each other at one distance and by one height, two
at least, are stairs; what a map has not seen it guesses, and guesses jump once, or by another height.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.terrain import Terrain

FINE, ACROSS = 0.01, 4
"""Samples along the way [m], and over how many of them a jump is looked for: edges in a map are blurred."""
BEHIND, AHEAD = 1.0, 1.1
"""From where to where along the way stairs are looked for, from the robot's place [m]."""
LEAST_JUMP = 0.04
"""A jump over `ACROSS` samples from which there is an edge [m]."""
TREADS = 0.15, 0.6
"""The depths of treads that are believed [m]."""
EVEN_TREADS, EVEN_RISES = 0.15, 0.3
"""By how much the treads and the rises of stairs may differ, as shares of their medians."""
LOOKS, OTHER = 5, 0.03
"""Stairs are the medians of so many looks, and keep their tread until these differ by this share of it."""
PATIENCE = 0.6
"""Time without any edge after which stairs are over [s]."""


class Steps(NamedTuple):
    """Stairs along a way.

    Attributes
    ----------
    rise
        Height of a step, negative where the way goes down [m].
    tread
        Depth of a step along the way [m].
    """

    rise: float
    tread: float


def find_edges(heights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places [samples] and jumps [m] of the edges in (m,) heights along a line: (k,), (k,).

    Examples
    --------
    >>> places, jumps = find_edges(np.repeat([0.0, 0.12, 0.24], 30))
    >>> places.round(2).tolist(), jumps.round(2).tolist()
    ([29.5, 59.5], [0.12, 0.12])
    """
    change = heights[ACROSS:] - heights[:-ACROSS]
    at = np.flatnonzero(np.abs(change) > LEAST_JUMP)
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


def find_steps(heights: FloatArray) -> Steps | None:
    """Return the stairs in (m,) heights every `FINE` along a way [m]; None where there are none.

    Examples
    --------
    >>> find_steps(np.repeat([0.0, 0.0, -0.1, -0.2, -0.3], 28))
    Steps(rise=-0.1, tread=0.28)
    """
    places, jumps = find_edges(heights)
    best: Steps | None = None
    longest = 1
    for first in range(len(places) - 1):
        for last in range(first + 1, len(places)):
            treads, rises = FINE * np.diff(places[first : last + 1]), jumps[first : last + 1]
            tread, rise = float(np.median(treads)), float(np.median(rises))
            even = np.abs(treads - tread).max() <= EVEN_TREADS * tread
            even &= np.abs(rises - rise).max() <= EVEN_RISES * abs(rise)
            if even and TREADS[0] <= tread <= TREADS[1] and last - first > longest - 1:
                fitted = FINE * float(np.polyfit(np.arange(last - first + 1), places[first : last + 1], 1)[0])
                best, longest = Steps(round(rise, 6), round(fitted, 6)), last - first + 1
    return best


class StepWatch:
    """Remembers the stairs that a robot is on, or is about to step on.

    Attributes
    ----------
    steps
        None where there are none.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget them."""
        self.steps: Steps | None = None
        self._seen = -math.inf
        self._looks: deque[Steps] = deque(maxlen=LOOKS)

    def look(self, terrain: Terrain, place: FloatArray, yaw: float, time: float) -> None:
        """Look along the way of a robot at a (2,) place [m] with a heading [rad], at a time [s]."""
        ways = np.arange(-BEHIND, AHEAD, FINE)
        heights = terrain.height(place + ways[:, None] * [math.cos(yaw), math.sin(yaw)])
        if (np.abs(heights[ACROSS:] - heights[:-ACROSS]) > LEAST_JUMP).any():
            self._seen = time
        elif time - self._seen > PATIENCE:
            self.reset()
        found = find_steps(heights)
        if found is None:
            return
        self._looks.append(found)
        if len(self._looks) < LOOKS:
            return
        rise, tread = (float(np.median(a)) for a in zip(*self._looks, strict=True))
        known = self.steps
        if (
            known is None
            or abs(rise - known.rise) > EVEN_RISES * abs(known.rise)
            or abs(tread / known.tread - 1.0) > OTHER
        ):
            self.steps = Steps(rise, tread)
