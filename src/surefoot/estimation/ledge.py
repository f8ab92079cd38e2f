"""A drop in the ground that a foot has found by touch: where its edge may be, and how deep it is.

A foot that goes on down where the ground should be, farther than steps that matter, has found a drop. All
that touch shows of it are stands: up to the farthest one before it the ground is level, the least far one
beyond it lies lower, and the edge is somewhere between.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.estimation.ground_belief import LOW

DROP = 0.29
"""A drop of more than this share of the height of the centre of mass is not taken by touch alone; less is a
small step, and the walk goes on."""
BOTTOMLESS = 0.5
"""No ground is found any more that is lower than this share of it."""
SURE_TREAD = 0.75
"""The ground beyond a drop is taken to be level for this share of the height of the centre of mass."""
LIKE = 0.5
"""A stand is one before the drop or beyond it if it is off by no more than this share of its depth."""
REACH = 0.1
"""Feet beyond the edge stand no nearer to it [m]: shins lean back over it."""


class Ledge:
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

    Examples
    --------
    >>> ledge = Ledge(np.array([1.0, 0.0]), 0.5, 0.6, 0.0, 0.07, 0.3, 0.02)
    >>> ledge.stand(0.6, -0.12)
    >>> ledge.shallow, ledge.height([0.4, 0.7]).tolist()
    (False, [0.0, -0.12])
    """

    def __init__(
        self, along: FloatArray, before: float, beyond: float, level: float, depth: float, height: float,
        radius: float,
    ) -> None:  # fmt: skip
        self.along, self.level, self.depth = np.array(along, dtype=np.float64), level, depth
        self._before, self._beyond, self._farthest = before, max(beyond, before), -math.inf
        self._height, self._radius = height, radius
        self.found = False

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
    def certain(self) -> bool:
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

    def height(self, along: ArrayLike) -> FloatArray:
        """Return the height of the ground at (...) places along the way [m]: (...)."""
        return np.where(np.asarray(along, dtype=np.float64) < self.edge, self.level, self.level - self.depth)

    def nearest(self, place: FloatArray) -> FloatArray:
        """Return the (2,) place nearest to one at which a foot may stand: where feet have stood [m]."""
        along = float(place @ self.along)
        top = self._before - 0.5 * self._radius
        sure = self._beyond + SURE_TREAD * self._height - 2.0 * self._radius
        below = min(max(along, self._beyond, self.edge + REACH), max(self._farthest, sure))
        goal = along if along <= top else top if along - top < below - along else below
        return place + (goal - along) * self.along
