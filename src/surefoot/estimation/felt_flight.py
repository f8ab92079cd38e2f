"""A flight of steps that feet have felt: edges where they struck risers, heights where they stood.

A foot that strikes a riser in the air tells where it is, to the foot's radius; one that stands tells a
height. Two numbers say where the edges are, the place of the first one and the depth of a tread, and two how
high the treads are, the level before them and the rise of a step. Each pair is the state of a Kalman filter
[1]_. Until a second riser has been felt the depth of the treads is not known, and the ground behind the first
is one tread without end.

References
----------
.. [1] R. E. Kalman, "A new approach to linear filtering and prediction problems", Journal of Basic
   Engineering 1960.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.estimation.flight_fit import StepLine, correct

STRIKE, STAND = 0.006, 0.003
"""Standard deviations of an edge that a foot has struck, and of a height that one stands on [m]."""
WANDER, RISING = 4e-3, 6e-3
"""By how much edges and heights wander in the estimated frame in a second, likewise [m]."""
LIKELY_TREAD, LIKELY_RISE = 0.06, 0.05
"""Standard deviations of a tread and a rise that are only guessed [m]."""
TREADS = 0.15, 0.6
"""The depths of treads that are believed [m]."""
NEAR = 0.06
"""A strike that is farther from an edge is none of its riser [m]."""
LIKE = 0.3
"""Heights count as those of a tread if they are off by no more than this share of a step."""
ONWARD = 4
"""So many edges are believed in beyond the last tread that a foot has stood on."""


class FeltFlight(StepLine):
    """Steps up along a direction, from a riser that a foot has struck.

    Parameters
    ----------
    along
        (2,) unit vector across the edges.
    edge, level
        Place of the struck riser along it, and height of the ground before it [m].
    rise, tread
        Guesses of a step's height and of a tread's depth [m].

    Attributes
    ----------
    along
        As given.
    rise_known, tread_known
        Whether they have been felt.
    last
        Number of the last edge that is believed in, from 0.
    ended
        Whether feet have found the level ground behind that.
    misses
        How many stands in turn fitted nothing.

    Examples
    --------
    >>> flight = FeltFlight(np.array([1.0, 0.0]), 0.5, 0.0, 0.15, 0.25)
    >>> flight.stand(0.6, 0.1)
    >>> flight.strike(0.78)
    True
    >>> round(flight.rise, 3), round(flight.tread, 3), flight.height([0.4, 0.7, 0.8, 1.1]).round(3).tolist()
    (0.1, 0.28, [0.0, 0.1, 0.2, 0.3])
    """

    def __init__(self, along: FloatArray, edge: float, level: float, rise: float, tread: float) -> None:
        self.along = np.array(along, dtype=np.float64)
        self._x, self._z = np.array([edge, tread]), np.array([level, rise])
        self._P, self._Q = np.diag([STRIKE, LIKELY_TREAD]) ** 2, np.diag([STAND, LIKELY_RISE]) ** 2
        self.rise_known = self.tread_known = self.ended = self._confirmed = False
        self.last = self.misses = 0

    def number(self, along: ArrayLike) -> FloatArray:
        """Return how many edges lie before (...) places along the flight [m]: (...)."""
        s = np.asarray(along, dtype=np.float64)
        return np.asarray(np.clip(np.floor((s - self._x[0]) / self._x[1]) + 1.0, 0.0, self.last + 1.0))

    def height(self, along: ArrayLike) -> FloatArray:
        """Return the height of the ground at (...) places along the flight [m]: (...)."""
        return np.asarray(self._z[0] + self._z[1] * self.number(along))

    def pass_time(self, elapsed: float) -> None:
        """Let the flight wander for a time [s]."""
        self._P[0, 0] += WANDER**2 * elapsed
        self._Q[0, 0] += RISING**2 * elapsed

    def strike(self, along: float) -> bool:
        """Learn of a riser at a place along the flight [m]; return whether it is one of the flight's."""
        way = along - self.edge(0)
        if self.tread_known:
            number = min(max(round(way / self.tread), 0), self.last)
        elif TREADS[0] <= way <= TREADS[1]:
            self._x[1] = way
            self._P = np.array([[1.0, -1.0], [-1.0, 2.0]]) * STRIKE**2
            self.tread_known = True
            self._reach(1)
            return True
        else:
            number = 0
        if abs(along - self.edge(number)) > NEAR:
            return False
        correct(self._x, self._P, np.array([1.0, float(number)]), along, STRIKE**2, math.inf)
        return True

    def stand(self, along: float, height: float) -> None:
        """Learn that a foot stands at a place along the flight and at a height [m]."""
        number = float(self.number(along))
        if number > 0.0 and not self.rise_known:
            self._z[1] = height - self._z[0]
            self._Q[1, 1], self.rise_known = 2.0 * STAND**2, True
            return
        steps = (height - float(self.height(along))) / self.rise
        if abs(steps) < LIKE:
            self.misses, self._confirmed = 0, self._confirmed or number == 1.0
            correct(self._z, self._Q, np.array([1.0, number]), height, STAND**2, math.inf)
            self._reach(int(number))
        elif abs(steps - 1.0) < LIKE and number == 1.0 and not self.tread_known:
            self.strike(along)  # the foot came down behind a riser that it passed above
        elif number == 1.0 and not self._confirmed:  # what told the rise was no stand
            self._z[1], self._Q[1, 1] = height - self._z[0], 2.0 * STAND**2
        elif abs(steps + 1.0) < LIKE and number > 1.0 and not self.ended:
            self.last, self.ended = int(number) - 2, True
        else:
            self.misses += 1

    def _reach(self, number: int) -> None:
        """Believe that the flight goes on beyond a tread that has been reached."""
        if self.tread_known and not self.ended:
            self.last = max(self.last, number + ONWARD - 1)
