"""A gait whose timing and pattern follow the speed, changed from cycle to cycle without a stop.

What is fixed is a list of stances for each foot: a stance that has been handed out never changes, and the
cycles after it are made when somebody asks for them, with the timing wanted then. Between two cycles
the times on the ground and in the air and the feet's offsets move by a bounded step: from a walk to a trot
each swing in between is a little shorter or longer than its neighbours, and none is cut short. At rest the
last stances have no end; a walk begins again from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.motion.gaits.contact_schedule import SAME_TIME, ContactSchedule
from surefoot.motion.gaits.gait_settings import GAIT_CHANGE

AHEAD = 0.6
"""Stances are remembered that ended less than this ago [s]."""


@dataclass(frozen=True)
class Pace:
    """Timing and swing of a gait.

    Attributes
    ----------
    period
        Length of a cycle [s].
    duty
        Share of it that a foot carries.
    clearance
        Height of the swing over the ground [m].
    """

    period: float
    duty: float
    clearance: float

    @property
    def stance_time(self) -> float:
        """Time that a foot carries [s]."""
        return self.duty * self.period


@dataclass(frozen=True)
class Stride:
    """What a cycle should be.

    Attributes
    ----------
    name
        Of the gait.
    pace
        Its timing and swing.
    offset
        (n,) when each foot touches down, as shares of the period; not wrapped: -0.1 is just before the cycle.
    moving
        Whether feet are lifted at all.
    in_step
        Whether its period is that of steps on the ground: it is fit for the speed that it is for.
    """

    name: str
    pace: Pace
    offset: FloatArray
    moving: bool = True
    in_step: bool = False


Choose = Callable[[FloatArray, str], Stride]
"""From a (3,) velocity (forward, left [m/s], turn rate [rad/s]) and the gait that is on to its stride."""


class AdaptiveGait(ContactSchedule):
    """A schedule that follows the speed; call `follow` with rising times.

    Parameters
    ----------
    name
        For tables and messages.
    choose
        Gives the wanted stride.
    first
        The stride to begin with.

    Attributes
    ----------
    held
        Whether the feet stay on the ground, see `hold`.
    stride, wanted
        The newest cycle's, and the one that suits the velocity that is `asked` for, (3,) [m/s, m/s, rad/s].
    """

    MEMORY = ("stride", "wanted", "_stances", "asked", "_next", "_resting", "held")

    adapts = True

    def __init__(self, name: str, choose: Choose, first: Stride) -> None:
        self.name, self.feet = name, len(first.offset)
        self._choose, self._first = choose, first
        self.reset()

    def reset(self) -> None:
        """Forget the past: the feet stand, and begin to walk at time 0 if the first stride moves."""
        self._forget_phases()
        self.stride = self.wanted = self._first
        self._stances: list[list[list[float]]] = [[[-math.inf, math.inf]] for _ in range(self.feet)]
        self.asked = np.zeros(3)
        self._next = 0.0
        self._resting, self.held = True, False
        if self._first.moving:
            self._begin(0.0)

    @property
    def pace(self) -> Pace:
        """Timing and swing of the newest cycle."""
        return self.stride.pace

    @property
    def period(self) -> float:  # type: ignore[override]
        """Length of the newest cycle [s]."""
        return self.stride.pace.period

    @property
    def stance_time(self) -> float:  # type: ignore[override]
        """Time that a foot carries in the newest cycle [s]."""
        return self.stride.pace.stance_time

    @property
    def clearance(self) -> float:  # type: ignore[override]
        """Height of the newest cycle's swings [m]."""
        return self.stride.pace.clearance

    @property
    def in_step(self) -> bool:  # type: ignore[override]
        """Whether the stride that is wanted is in step with the ground."""
        return self.wanted.in_step

    @property
    def coming_period(self) -> float:
        """Length of the cycle that is wanted [s]."""
        return self.wanted.pace.period

    def follow(self, time: float, velocity: FloatArray) -> None:
        """Follow a (3,) velocity [m/s, m/s, rad/s] at a time [s]: cycles that are not made yet fit it."""
        self._forget_phases()
        self.wanted, self.asked = self._choose(velocity, self.wanted.name), velocity
        if self._resting and self.wanted.moving and not self.held:
            self._begin(time)
        for stances in self._stances:
            while len(stances) > 1 and stances[0][1] < time - AHEAD:
                del stances[0]

    def hold(self, time: float) -> None:
        """Let no foot lift from a time [s] on, whatever is asked for; until `held` is taken back.

        Stances that have been handed out last on; feet in the air land as they were to.
        """
        if self.held:
            return
        self._make(time + SAME_TIME)
        self._forget_phases()
        self.held = self._resting = True
        for stances in self._stances:
            coming = next(k for k, (_, end) in enumerate(stances) if end > time + SAME_TIME)
            del stances[coming + 1 :]
            stances[coming][1] = math.inf

    def release(self) -> None:
        """Let feet lift again."""
        self.held = False

    @property
    def turning(self) -> bool:  # type: ignore[override]
        """Whether the newest cycle is not yet in step with the ground, and should be."""
        if not self.wanted.in_step or self._resting:
            return False
        turned = float(np.abs(self.stride.offset - self.wanted.offset).max())
        return (
            turned > GAIT_CHANGE.slow_offset_step
            or abs(self.period / self.wanted.pace.period - 1.0) > GAIT_CHANGE.nearly
        )

    def fits(self, velocity: FloatArray) -> bool:
        """Return whether the newest cycle is fit for a (3,) velocity [m/s, m/s, rad/s]."""
        wanted = self._choose(velocity, self.wanted.name)
        if not wanted.moving or self._resting or self.wanted.in_step:
            return True
        # a pattern for more speed, which is asked for, is fit for less as well: it begins from rest
        suits = (wanted.offset, self.wanted.offset)
        turned = min(float(np.abs(self.stride.offset - offset).max()) for offset in suits)
        return (
            turned < GAIT_CHANGE.offset_step
            and self.stance_time < GAIT_CHANGE.unfit * wanted.pace.stance_time
        )

    def contacts(self, times: ArrayLike) -> BoolArray:
        """Return which feet carry at (...) times [s]: (..., feet)."""
        t = np.asarray(times, dtype=np.float64) + SAME_TIME
        self._make(float(t.max(initial=-math.inf)))
        out = np.zeros((*t.shape, self.feet), dtype=bool)
        for k, stances in enumerate(self._stances):
            for begin, end in stances:
                out[..., k] |= (t >= begin) & (t < end)
        return out

    def phase(self, foot: int, time: float) -> tuple[bool, float, float]:
        """Return whether a foot carries at a time, and when that phase began and will end [s]."""
        t = time + SAME_TIME
        self._make(t)
        stances = self._stances[foot]
        before = -math.inf
        for begin, end in stances:
            if t < begin:
                return False, before, begin
            if t < end:
                return True, begin, end
            before = end
        raise AssertionError("the last stance of a foot lies ahead")  # pragma: no cover

    def _make(self, time: float) -> None:
        """Make cycles until the last stance of every foot ends after a time."""
        while not self._resting and min(s[-1][1] for s in self._stances) <= time:
            if not self.wanted.moving:
                self._resting = True
                self._forget_phases()
                for stances in self._stances:
                    stances[-1][1] = math.inf
                return
            self._cycle()

    def _begin(self, time: float) -> None:
        """Walk from rest: end the last stances so that the first swings fit the first cycle."""
        self._resting = False
        self.stride = stride = self.wanted
        pace = stride.pace
        air = pace.period - pace.stance_time
        lifts = [max(time + GAIT_CHANGE.first_lift, s[-1][0] + pace.stance_time) for s in self._stances]
        shares = [float(o) for o in stride.offset]
        others = [o < shares[0] - GAIT_CHANGE.earlier for o in shares]  # lift a cycle later
        shares = [o + other for o, other in zip(shares, others, strict=True)]
        # The cycle begins when the last foot could have lifted and flown: the others stand as much longer as
        # that takes.
        self._next = max(lift + air - o * pace.period for lift, o in zip(lifts, shares, strict=True))
        for stances, o in zip(self._stances, shares, strict=True):
            stances[-1][1] = self._next + o * pace.period - air
        self._cycle(others)

    def _cycle(self, others: list[bool] | None = None) -> None:
        """Add the next cycle's stances; of a first one, but for the `others` that stand through it."""
        first = others is not None
        if not first:
            self.stride = _between(self.stride, self.wanted)
        pace, shares = self.stride.pace, self.stride.offset.tolist()
        air = GAIT_CHANGE.least_air * (pace.period - pace.stance_time)
        lifts = [stances[-1][1] for stances in self._stances]
        # a shorter cycle waits until the feet that lifted last have had their time in the air
        ready = [lift + air - o * pace.period for lift, o in zip(lifts, shares, strict=True)]
        start = self._next if first else max(self._next, *ready)
        for k, (stances, o) in enumerate(zip(self._stances, shares, strict=True)):
            if others is None or not others[k]:
                begin = start + o * pace.period
                stances.append([begin, begin + pace.stance_time])
        self._next = start + pace.period


def _between(now: Stride, wanted: Stride) -> Stride:
    """Return the stride a bounded step from one towards another."""
    a, b = now.pace, wanted.pace
    stance = a.stance_time * _bounded(b.stance_time / a.stance_time, GAIT_CHANGE.stance_step)
    air, wanted_air = a.period - a.stance_time, b.period - b.stance_time
    air *= _bounded(wanted_air / air, GAIT_CHANGE.air_step)
    most = (
        GAIT_CHANGE.offset_step
        if wanted.in_step == now.in_step and not wanted.in_step
        else GAIT_CHANGE.slow_offset_step
    )
    offset = now.offset + np.clip(wanted.offset - now.offset, -most, most)
    return replace(wanted, pace=Pace(stance + air, stance / (stance + air), b.clearance), offset=offset)


def _bounded(factor: float, most: float) -> float:
    """Return a factor that neither lengthens nor shortens by more than `most` times."""
    return min(max(factor, 1.0 / most), most)
