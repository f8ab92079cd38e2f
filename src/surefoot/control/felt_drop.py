"""A drop in the ground that a foot has found by touch: what lies before it, and what the robot may do there.

A foot that goes on down where the ground should be, farther than steps that matter, has found a drop. All
that touch tells of it are stands: up to the farthest one before it the ground is level, the least far one
beyond it lies lower, and the edge is somewhere between. So the body stops, feet keep to where feet have
stood, and the only way that is left is back.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.stair_gait import LOW
from surefoot.spatial import GRAVITY

DROP = 0.29
"""A drop of more than this share of the height of the centre of mass is not taken by touch alone; less is a
small step, and the walk goes on."""
BOTTOMLESS = 0.5
"""No ground is found any more that is lower than this share of it."""
SURE_TREAD = 0.75
"""The ground beyond a drop is taken to be level for this share of the height of the centre of mass."""
LIKE = 0.5
"""A stand is one before the drop or beyond it if it is off by no more than this share of its depth."""
LITTLE = 0.5
"""What is left of a command is nothing if it is less than this share of it."""
NEAR, SKEW, QUIET = 0.08, 0.15, 0.08
"""A body that stands may step again once it is so near to the line between the feet that will carry, in
heights of the centre of mass, and no faster [m/s]. It does so, on the spot, where the middles of the feet's
diagonals are that far apart along the way, likewise."""
FAR = 0.35
"""From so far away it goes to the middle of its feet, likewise."""
SHIFT_TIME, FASTEST_SHIFT = 0.3, 0.25
"""Time in which it goes there [s], and how fast at most [m/s]."""
AHEAD = 0.1
"""One that goes back but is so far ahead of the middle of its feet stands again, likewise."""
REACH = 0.1
"""Feet beyond the edge stand no nearer to it [m]: shins lean back over it."""
AWAY = 0.3
"""The drop is left behind once all feet are so far before it, likewise."""


class FeltDrop:
    """An edge behind which the ground is lower, along a direction.

    Parameters
    ----------
    along
        (2,) unit vector towards the drop, across its edge.
    before, beyond
        Where along it feet stand, and where one found nothing [m].
    level, depth
        Height of the ground before the drop, and how much lower a foot has been so far [m].
    height
        Of the centre of mass above the ground [m].
    radius
        Of the feet [m].

    Attributes
    ----------
    along, level
        As given.
    depth
        Of the drop [m].
    found
        Whether a foot has stood on the ground beyond it.
    standing, astride
        Whether the body stands still, and whether feet stand beyond the edge.
    leading
        A foot of the diagonal that should step first then.

    Examples
    --------
    >>> drop = FeltDrop(np.array([1.0, 0.0]), 0.5, 0.6, 0.0, 0.07, 0.3, 0.02)
    >>> drop.stand(0.6, -0.12)
    >>> drop.shallow, drop.height([0.4, 0.7]).tolist()
    (False, [0.0, -0.12])
    """

    def __init__(
        self, along: FloatArray, before: float, beyond: float, level: float, depth: float, height: float,
        radius: float,
    ) -> None:  # fmt: skip
        self.along, self.level, self.depth = np.array(along, dtype=np.float64), level, depth
        self._before, self._beyond, self._farthest = before, max(beyond, before), -math.inf
        self._height, self._radius = height, radius
        self.found = self.standing = self.astride = False
        self.leading, self._halted = 0, False
        self._excess, self._shift, self._stood = np.zeros(2), np.zeros(2), False
        self._stepped: BoolArray = np.zeros(4, dtype=bool)

    @staticmethod
    def begins(depth: float, height: float) -> bool:
        """Return whether a foot that is so deep below the ground it expected [m] may be over a drop."""
        return depth > LOW * height

    @property
    def edge(self) -> float:
        """Place of the edge along the way [m]."""
        return 0.5 * (self._before + self._beyond)

    @property
    def shallow(self) -> bool:
        """Whether the ground beyond has been found, and is no lower than after a small step."""
        return self.found and self.depth < DROP * self._height

    @property
    def told(self) -> bool:
        """Whether it is certain that the drop is not a small step."""
        return self.depth > DROP * self._height and (self.found or self.depth > BOTTOMLESS * self._height)

    def deeper(self, along: float, height: float) -> None:
        """Learn that a foot at a place has gone down to a height without finding ground [m]."""
        if not self.found:
            self.depth = max(self.depth, self.level - height)
            self._beyond = max(min(self._beyond, along), self._before)

    def stand(self, along: float, height: float) -> None:
        """Learn that a foot stands at a place along the way and at a height [m]."""
        below = self.level - height
        if not self.found and below > 0.5 * self.depth:
            self.depth, self.found = below, True
        if abs(below) < LIKE * self.depth:
            self._before = max(self._before, min(along, self._beyond))
        elif self.found and abs(below - self.depth) < LIKE * self.depth:
            self._beyond = max(min(self._beyond, along), self._before)
            self._farthest = max(self._farthest, along)

    def struck(self, along: float) -> None:
        """Learn that a foot on its way back has struck the riser, its sole at a place along the way [m]."""
        edge = along - self._radius
        if self._before <= edge <= self._beyond:
            self._before = self._beyond = edge

    def height(self, along: ArrayLike) -> FloatArray:
        """Return the height of the ground at (...) places along the way [m]: (...)."""
        return np.where(np.asarray(along, dtype=np.float64) < self.edge, self.level, self.level - self.depth)

    def nearest(self, along: float, start: float) -> float:
        """Return the nearest place to one along the way at which a foot that lifted at `start` may stand [m].

        Once the robot has stood still no foot goes beyond the edge any more.
        """
        top = self._before - 0.5 * self._radius
        if along <= top or (self._stood and start < self.edge):
            return min(along, top)
        sure = self._beyond + SURE_TREAD * self._height - 2.0 * self._radius
        low, high = max(self._beyond, self.edge + REACH), max(self._farthest, sure)
        below = min(max(along, low), high)
        return top if along - top < below - along else below

    def rest(
        self, place: FloatArray, flow: FloatArray, feet: FloatArray, carrying: BoolArray, asked: bool
    ) -> None:
        """Decide whether to stand still: once the body can come to rest over the feet as they stand.

        Parameters
        ----------
        place, flow
            (2,) of the body [m], and its velocity [m/s], world axes.
        feet
            (n, 3) where feet stand [m].
        carrying
            (n,) which of them do.
        asked
            Whether what is left of the command leads anywhere.
        """
        if len(feet) != len(self._stepped):
            return  # which feet step together, and which carry then, is known of four
        s, stands = float(place @ self.along), feet[:, :2] @ self.along
        beyond = stands > self.edge
        self.astride, last = bool(beyond.any()), int(beyond.sum()) == 1
        self.leading = int(last and (beyond[1] or beyond[2]))
        skew = self._lines(place, feet)
        speed, ahead = math.hypot(*flow), s - float(stands.mean())
        self._stepped |= ~carrying
        self._halted &= last
        if self.standing:
            ready = math.hypot(*self._excess) < NEAR * self._height and speed < QUIET
            self.standing = not (carrying.all() and ready and (asked or skew > SKEW * self._height))
            self._stepped &= self.standing
        elif self._stood:
            off = bool(self._stepped.all()) and ahead > AHEAD * self._height
            square = bool(carrying.all()) and skew < 0.5 * SKEW * self._height and speed < 2.0 * QUIET
            self.standing = off or (last and not self._halted) or (square and not asked)
            self._halted = last
        elif carrying.all():
            rest = s + float(flow @ self.along) * math.sqrt(self._height / GRAVITY)
            self._stood = self.standing = rest < float(np.sort(stands)[-2:].mean())

    def _lines(self, place: FloatArray, feet: FloatArray) -> float:
        """Find where the body should go when it stands; return how far apart the diagonals are [m]."""
        first, last = feet[[[1, 2], [0, 3]][self.leading], :2]  # of the diagonal that will carry first
        way = last - first
        share = float(np.clip((place - first) @ way / (way @ way), 0.0, 1.0))
        self._excess = first + share * way - place
        middle = feet[:, :2].mean(axis=0) - place
        self._shift = middle if math.hypot(*middle) > FAR * self._height else self._excess
        return abs(float((feet[0] + feet[3] - feet[1] - feet[2])[:2] @ self.along)) / 2.0

    def slowed(self, velocity: FloatArray) -> FloatArray:
        """Return a (2,) velocity along x and y of the world without what leads on towards the drop [m/s]."""
        left = velocity - max(float(velocity @ self.along), 0.0) * self.along
        little = math.hypot(*left) < LITTLE * math.hypot(*velocity)
        return np.zeros(2) if little else np.asarray(left)

    def shift(self) -> FloatArray:
        """Return the (2,) velocity with which a body that stands goes to the middle of its feet [m/s]."""
        speed = math.hypot(*self._shift) / SHIFT_TIME
        return np.asarray(self._shift / SHIFT_TIME * min(1.0, FASTEST_SHIFT / max(speed, 1e-9)))

    def left(self, feet: FloatArray) -> bool:
        """Return whether all feet have gone back from the drop: they stand at (n, 3) `feet` [m]."""
        return bool((feet[:, :2] @ self.along).max() < self.edge - AWAY * self._height)

    def note(self, time: float) -> str:
        """Return what the walk says of it, found at a time [s]."""
        return (
            f"stopped from {time:.2f} s on: a foot found the ground {1e3 * self.depth:.0f} mm lower, and "
            f"drops of more than {1e3 * DROP * self._height:.0f} mm are not taken by touch alone; only "
            f"commands that lead back are followed"
        )
