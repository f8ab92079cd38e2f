"""A flight of stairs fitted to what a range sensor sees: one tread, one rise, one direction, to millimetres.

The cells of a height map tell an edge to their own size, and edges that hide the ground behind them too far.
The points of a scan tell more. Whether a ray passes an edge is decided in the plane of the tread above it: of
the rays through this plane, those that end on it and those that go on below are parted by the edge, however
noisy their lengths are and whatever the edge hides. Where risers face the sensor, the points on them tell the
edge directly. Each edge seen corrects a Kalman filter of where the flight begins, how deep its treads are and
how it is turned; treads seen, and feet that stand on them, correct one of its heights and of the sensor's
pitch. What differs from the flight by more than it can is left out [1]_.

References
----------
.. [1] R. E. Kalman, "A new approach to linear filtering and prediction problems", Journal of Basic
   Engineering 1960; scalar updates with gating as in Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation
   with applications to tracking and navigation", Wiley, 2001.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.ground.ground_settings import STAIR_FIT


class StairSteps(NamedTuple):
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


class StairFit:
    """Follows a flight of stairs from scan to scan.

    Parameters
    ----------
    along
        (2,) unit vector across the edges, roughly.
    edge
        Place of an edge along it [m].
    level
        Height of the ground before that edge [m].
    steps
        Roughly.
    place
        (2,) place beside which its direction is that of `along` turned [m].

    Attributes
    ----------
    along, across
        (2,) unit vectors.
    first, last
        Numbers of the edges that have been seen, from the one given, 0.
    """

    def __init__(
        self, along: FloatArray, edge: float, level: float, steps: StairSteps, place: FloatArray
    ) -> None:
        self.along, self.across = along, np.array([-along[1], along[0]])
        self.aside = float(place @ self.across)
        # Two Kalman filters. Edge k lies at x0 + k x1 + x2 w along the line, w aside of it (x2: the turn of
        # the edges); the tread after it at z0 + (k + 1) z1, as a sensor sees it whose pitch is off by z2.
        self._x = np.array([edge, steps.tread, 0.0])
        self._P = np.diag([0.1 * steps.tread, 0.06 * steps.tread, 0.06]) ** 2
        self._z = np.array([level, steps.rise, 0.0])
        self._Q = np.diag([0.1 * steps.rise, 0.1 * steps.rise, STAIR_FIT.angle]) ** 2
        self._times: dict[int, int] = {}
        self._missed = 0

    @property
    def tread(self) -> float:
        """Depth of a tread [m]."""
        return float(self._x[1])

    @property
    def rise(self) -> float:
        """Height of a step, negative where they go down [m]."""
        return float(self._z[1])

    def edge(self, number: int) -> float:
        """Return the place of an edge along the line [m]."""
        return float(self._x[0] + number * self._x[1])

    @property
    def first(self) -> int:
        """Number of the first edge that is there."""
        return min((k for k, times in self._times.items() if times >= STAIR_FIT.measurements), default=0)

    @property
    def last(self) -> int:
        """Number of the last edge that is there."""
        return max((k for k, times in self._times.items() if times >= STAIR_FIT.measurements), default=0)

    @property
    def lost(self) -> bool:
        """Whether what is seen has contradicted it for long."""
        return self._missed > STAIR_FIT.patience

    def deviation(self, number: int) -> float:
        """Return the standard deviation of an edge's place [m]."""
        row = np.array([1.0, float(number), 0.0])
        return math.sqrt(float(row @ self._P @ row))

    @property
    def known(self) -> bool:
        """Whether two edges or more are there, and known well."""
        first = self.first
        return self.last > first and max(self.deviation(first), self.deviation(first + 1)) < STAIR_FIT.sure

    def parameters(self) -> FloatArray:
        """Return what `stair_heights` takes: (10,)."""
        (edge, tread, turn), (level, rise) = self._x, self._z[:2]
        return np.array(
            [*self.along, self.aside, edge, tread, turn, level, rise, float(self.first), float(self.last)]
        )

    def pass_time(self, elapsed: float) -> None:
        """Let the flight wander for a time [s]."""
        self._P += np.diag([STAIR_FIT.drift, STAIR_FIT.stretch, STAIR_FIT.turning]) ** 2 * elapsed
        self._Q += np.diag([STAIR_FIT.rising, STAIR_FIT.stretch, 0.0]) ** 2 * elapsed

    def see(self, origin: FloatArray, points: FloatArray) -> None:
        """Learn from a scan.

        Parameters
        ----------
        origin
            (3,) where its rays begin [m].
        points
            (k, 3) where they ended [m].
        """
        # s along the line, w aside of it, z up
        s, w, z = points[:, :2] @ self.along, points[:, :2] @ self.across - self.aside, points[:, 2]
        begin = np.array([origin[:2] @ self.along, origin[:2] @ self.across - self.aside, origin[2]])
        low = math.floor((float(s.min(initial=begin[0])) - self._x[0]) / self.tread)
        high = math.ceil((float(s.max(initial=begin[0])) - self._x[0]) / self.tread)
        low, high = max(low, self.first - 1), min(high, self.last + 1)
        # Nearest edges first: they are measured best, and those farther away are looked for where the
        # corrected state has them. Both sides apart, or a turned edge would be averaged away.
        for number in sorted(range(low, high + 1), key=lambda k: abs(self.edge(k) - begin[0])):
            for side in (-1.0, 1.0):
                seen = self._find_edge(number, begin, s, w, z, side)
                if seen is None:
                    continue
                row = np.array([1.0, float(number), seen[1]])
                if correct(self._x, self._P, row, seen[0], seen[2]):
                    self._times[number] = self._times.get(number, 0) + 1
        self._see_levels(begin, s, w, z)

    def touch(self, point: FloatArray) -> None:
        """Learn that a foot stands at a (3,) point [m]."""
        number = self._number(point)
        if number is not None:
            correct(self._z, self._Q, np.array([1.0, number, 0.0]), float(point[2]), STAIR_FIT.touch**2)

    def distance_outside(self, place: FloatArray) -> float:
        """Return the distance of a (2,) place before the first or beyond the last edge [m]."""
        s = float(place @ self.along)
        return max(s - self.edge(self.last), self.edge(self.first) - s)

    def _number(self, point: FloatArray) -> float | None:
        """Return the number of the tread on which a point is; None near an edge and off the flight."""
        s = float(point[:2] @ self.along) - float(self._x[2]) * (float(point[:2] @ self.across) - self.aside)
        share = (s - float(self._x[0])) / self.tread
        number = math.floor(share) + 1
        inside = 0.1 < share - math.floor(share) < 0.9  # nearer to an edge it may be on either side
        if not inside or not self.first - STAIR_FIT.beside <= number <= self.last + 1 + STAIR_FIT.beside:
            return None
        return float(min(max(number, self.first), self.last + 1))

    def _find_edge(
        self, number: int, begin: FloatArray, s: FloatArray, w: FloatArray, z: FloatArray, side: float
    ) -> tuple[float, float, float] | None:
        """Return an edge that a scan measures on one side [m], its offset aside and its variance."""
        level, rise, tilt = self._z
        before, after = level + number * rise, level + (number + 1) * rise
        top, high = max(before, after), abs(rise)
        place = self.edge(number)
        drop = begin[2] - top
        ahead = place - begin[0]
        if (ahead > 0.0) == (rise > 0.0):  # its riser faces the sensor
            on = (np.abs(z - 0.5 * (before + after)) < 0.2 * high) & (side * (w - begin[1]) > 0.0)
            on &= np.abs(s - place - self._x[2] * w) < STAIR_FIT.near * self.tread
            if int(on.sum()) < STAIR_FIT.few:
                return None
            aside = float(w[on].mean())
            return float(np.median(s[on])), aside, STAIR_FIT.repeated * STAIR_FIT.place**2
        if drop < 0.1:
            return None
        # Where each ray passes the plane of the upper tread; one that goes on below it has passed the edge.
        share = drop / np.maximum(begin[2] - z, 0.5 * drop)
        through, beside = begin[0] + share * (s - begin[0]), begin[1] + share * (w - begin[1])
        on = (np.abs(through - place - self._x[2] * beside) < STAIR_FIT.near * self.tread) & (
            side * (beside - begin[1]) > 0.0
        )
        stays = on & (np.abs(z - top) < 0.4 * high)
        goes = on & (z < top - 0.6 * high)
        if min(int(stays.sum()), int(goes.sum())) < STAIR_FIT.few:
            return None
        aside = float(beside[on].mean())
        turned = self._x[2] * (beside - aside)
        way = 1.0 if ahead > 0.0 else -1.0
        found = parting(way * (through - turned)[stays], way * (through - turned)[goes])
        # d/dα of drop cot α is (drop² + ahead²) / drop: what an error of the sensor's pitch moves the place
        # by.
        slope = (drop * drop + ahead * ahead) / drop
        variance = STAIR_FIT.place**2 + float(self._Q[2, 2]) * slope * slope
        return way * (found - tilt * slope), aside, STAIR_FIT.repeated * variance

    def _see_levels(self, begin: FloatArray, s: FloatArray, w: FloatArray, z: FloatArray) -> None:
        """Correct the heights, and what the sensor's pitch is wrong by, by the treads that a scan shows."""
        share = (s - self._x[2] * w - self._x[0]) / self.tread
        number = np.floor(share) + 1.0
        low, high = self.first, self.last + 1
        inner = np.abs(share - np.floor(share) - 0.5) < 0.3  # rays near an edge see two levels
        inner &= (number >= low - STAIR_FIT.beside) & (number <= high + STAIR_FIT.beside)
        there = int((inner & (number >= low) & (number <= high)).sum())
        level = self._z[0] + np.clip(number, low, high) * self._z[1]
        inner &= np.abs(z - level) < 0.4 * abs(self.rise)
        # A scan that finds too few of its points at the heights of the treads contradicts the stairs.
        here = int((inner & (number >= low) & (number <= high)).sum())
        if here < STAIR_FIT.agreeing * there:
            self._missed += 1
            return
        self._missed = 0
        for k in range(low - STAIR_FIT.beside, high + STAIR_FIT.beside + 1):
            on = inner & (number == k)
            if int(on.sum()) < STAIR_FIT.few:
                continue
            far = float(np.abs(s[on] - begin[0]).mean())
            row = np.array([1.0, float(min(max(k, low), high)), far])
            correct(self._z, self._Q, row, float(np.median(z[on])), STAIR_FIT.repeated * STAIR_FIT.level**2)


def parting(before: FloatArray, after: FloatArray) -> float:
    """Return the number that parts (k,) numbers before it from (m,) ones after it with the fewest wrong.

    Examples
    --------
    >>> parting(np.array([0.0, 0.1, 0.2, 0.7]), np.array([0.3, 0.4, 0.5]))
    0.25
    """
    values = np.concatenate([before, after])
    order = np.argsort(values)
    # wrong for a parting after the first i values: those after among these, those before among the others
    after_below = np.concatenate([[0], np.cumsum(order >= len(before))])
    before_above = len(before) - np.concatenate([[0], np.cumsum(order < len(before))])
    wrong = after_below + before_above
    best = np.flatnonzero(wrong == wrong.min())
    ranked = values[order]
    bounds = np.concatenate([[ranked[0]], 0.5 * (ranked[1:] + ranked[:-1]), [ranked[-1]]])
    return float(bounds[best].mean())


def correct(x: FloatArray, P: FloatArray, row: FloatArray, measured: float, variance: float) -> bool:
    """Correct a state (n,) and its covariance (n, n) in place by a number that a row (n,) of it should be.

    Return False, and leave both, for a number that is off by more standard deviations than `STAIR_FIT.gate`.
    """
    miss, spread = measured - float(row @ x), float(row @ P @ row) + variance
    if miss * miss > STAIR_FIT.gate**2 * spread:
        return False
    gain = P @ row / spread
    x += gain * miss
    P -= np.outer(gain, row @ P)
    P[:] = 0.5 * (P + P.T)
    return True
