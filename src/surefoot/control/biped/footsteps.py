"""The footsteps ahead of a biped: when each foot stands, where, and where the pressure goes between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.stance.contact_schedule import ContactSchedule

LONGEST = 30.0
"""A stance that ends later than this from now has no end that matters [s]."""


@dataclass(frozen=True)
class Footstep:
    """A stance of one foot.

    Attributes
    ----------
    foot
        Its index.
    begin, end
        When it touches down and lifts off, on the schedule's clock [s]; infinite where it never does.
    place
        (2,) middle of the sole, world axes [m].
    yaw
        Where the toes point [rad].
    """

    foot: int
    begin: float
    end: float
    place: FloatArray
    yaw: float


@dataclass(frozen=True)
class StepGeometry:
    """What steps are like.

    Attributes
    ----------
    width
        Distance of the feet when walking straight on [m].
    narrowest, widest
        Bounds on the distance to the left or right of a foot from the other one [m].
    longest
        Bound on the distance ahead or behind [m].
    """

    width: float
    narrowest: float
    widest: float
    longest: float

    def within_reach(self, place: FloatArray, support: FloatArray, yaw: float, side: float) -> FloatArray:
        """Return the (2,) place [m] moved so that the legs reach it and do not cross.

        Parameters
        ----------
        place, support
            (2,) where the foot should go, and the other foot [m].
        yaw
            Heading [rad].
        side
            1 for a left foot, -1 for a right one.
        """
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = float(place[0] - support[0]), float(place[1] - support[1])
        ahead, left = c * x + s * y, c * y - s * x
        ahead = min(max(ahead, -self.longest), self.longest)
        left = side * min(max(side * left, self.narrowest), self.widest)
        return np.array([support[0] + c * ahead - s * left, support[1] + s * ahead + c * left])


def stances(schedule: ContactSchedule, foot: int, clock: float, ahead: float) -> list[tuple[float, float]]:
    """Return (begin, end) [s] of the stances of a foot that end after `clock` and begin within `ahead` [s].

    Before the schedule's time 0 all feet stand, since ever.
    """
    out, time, until = [], max(clock, 0.0), clock + ahead
    if clock < 0.0:
        on, _, end = schedule.phase(foot, 0.0)
        time = end if on else 0.0
        out.append((-math.inf, time))
        time += 1e-6
    while time < until:
        on, begin, end = schedule.phase(foot, time)
        if on:
            out.append((begin, end))
        if not end < clock + LONGEST:
            break
        time = end + 1e-6
    return out


def pressure_path(steps: list[Footstep], times: FloatArray) -> FloatArray:
    """Return where the centre of pressure should be at (t,) times [s]: (t, 2) [m].

    On the standing foot; on two feet it moves evenly to the one that stays longer; standing still it is
    between them. Where no foot stands it is where it last was.
    """
    share = np.zeros((len(times), len(steps)))
    for i, one in enumerate(steps):
        load = ((times >= one.begin) & (times < one.end)).astype(np.float64)
        for other in steps:
            begin, end = max(one.begin, other.begin), min(one.end, other.end)
            if other.foot == one.foot or begin >= end:
                continue
            both = (times >= begin) & (times < end)
            load[both] = _load(one, other, begin, end, times[both])
        share[:, i] = load
    total = share.sum(axis=1)
    places = np.array([one.place for one in steps])
    path: FloatArray = np.asarray(share @ places / np.maximum(total, 1e-9)[:, None])
    for k in np.flatnonzero(total < 1e-9):
        path[k] = path[k - 1] if k else places[0]
    return path


def _load(one: Footstep, other: Footstep, begin: float, end: float, times: FloatArray) -> FloatArray:
    """Return the share of the load on a foot while both stand."""
    if not math.isfinite(end):
        return np.full(len(times), 0.5)
    if math.isfinite(begin):
        moved = np.clip((times - begin) / (end - begin), 0.0, 1.0)
        first = 0.0 if one.begin > other.begin else 1.0
    else:  # standing, until the first foot lifts
        moved, first = np.zeros(len(times)), 0.5
    last = 1.0 if one.end > other.end else 0.0
    return np.asarray(first + moved * (last - first))


def touching(steps: list[Footstep], times: FloatArray, feet: int) -> tuple[BoolArray, list[list[int]]]:
    """Return which feet stand at (t,) times: (t, feet), and by which footstep: t lists, -1 for none."""
    on = np.zeros((len(times), feet), dtype=bool)
    which = [[-1] * feet for _ in times]
    for i, one in enumerate(steps):
        for t in np.flatnonzero((times >= one.begin) & (times < one.end)):
            on[t, one.foot] = True
            which[int(t)][one.foot] = i
    return on, which
