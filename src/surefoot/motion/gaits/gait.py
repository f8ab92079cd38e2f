"""Which feet are on the ground when: periodic gaits, finite mode schedules, and their checks.

A schedule is a table: intervals of time and, for each, which feet carry. Feet are addressed by their
index; the order is the robot's (`Robot.foot_names`). A mode number writes one row of the table as
bits, the first foot being the most significant one, as in OCS2's switched models: with the feet LF,
RF, LH, RH a trot alternates between 9 (LF, RH) and 6 (RF, LH); 15 is standing, 0 is flying.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    array_of,
    finite_array,
    real_number,
    whole_number,
)
from surefoot.base.errors import ProblemError, shown
from surefoot.motion.gaits.contact_schedule import SAME_TIME, ContactSchedule

MAX_FLIGHT = 0.35
"""Longest time without any foot on the ground that a schedule may ask for [s]."""
SHARE_DIGITS = 6
"""Phases of a gait are shares of its period, rounded to this many digits."""


def mode_number(carrying: ArrayLike) -> int:
    """Return the mode number of (n,) feet that carry; the first foot is the most significant bit.

    >>> mode_number([True, False, False, True])
    9
    """
    number = 0
    for bit in np.asarray(carrying, dtype=bool).tolist():
        number = 2 * number + bit
    return number


def mode_feet(number: int, feet: int) -> BoolArray:
    """Return which of `feet` feet carry in a mode: (feet,).

    Raises
    ------
    ProblemError
        If the number is not a mode of that many feet.

    Examples
    --------
    >>> mode_feet(9, 4)
    array([ True, False, False,  True])
    """
    if not 0 <= int(number) < 2**feet:
        raise ProblemError(f"mode number must be between 0 and {2**feet - 1} for {feet} feet, got {number}")
    return np.array([bool(int(number) >> (feet - 1 - k) & 1) for k in range(feet)])


class _ModeTable(ContactSchedule):
    """A schedule that is a table of modes, one row per interval of time; see the module."""

    table: BoolArray

    @property
    def modes(self) -> IntArray:
        """(m,) mode numbers of the intervals."""
        return np.array([mode_number(row) for row in self.table], dtype=np.int64)

    def _refuse_flight(self, name: str, lengths: FloatArray, table: BoolArray, most: float) -> None:
        """Refuse a run of intervals without any carrying foot that is longer than `most` [s]."""
        longest = run = 0.0
        for length, row in zip(lengths.tolist(), table, strict=True):
            run = 0.0 if row.any() else run + length
            longest = max(longest, run)
        if longest > most + SAME_TIME:
            raise ProblemError(
                f"{name} has no foot on the ground for {longest:.3g} s; at most {most:g} s is accepted"
            )


class Gait(_ModeTable):
    """A contact schedule that repeats.

    Parameters
    ----------
    name
        For tables and messages.
    switching
        (m + 1,) rising times at which the mode changes [s]; the first is 0, the last the period.
    modes
        (m, feet) mask of the feet that carry in each interval, or (m,) mode numbers with `feet` given.
    feet
        Number of feet; needed for mode numbers.
    max_flight
        Longest time without any carrying foot that is accepted [s].

    Raises
    ------
    ProblemError
        If times do not rise, lengths do not match, a foot never touches the ground or no foot is on
        the ground for longer than `max_flight`.

    Examples
    --------
    >>> trot = Gait.from_phases("trot", period=0.5, duty=0.5, offset=[0.0, 0.5, 0.5, 0.0])
    >>> trot.modes.tolist(), trot.switching.tolist()
    ([9, 6], [0.0, 0.25, 0.5])
    """

    MEMORY: ClassVar[tuple[str, ...]] = ("_last",)

    def __init__(
        self,
        name: str,
        switching: ArrayLike,
        modes: ArrayLike,
        feet: int | None = None,
        max_flight: float = MAX_FLIGHT,
    ) -> None:
        self.name = str(name)
        times = finite_array(f"switching times of gait {name}", switching, (None,))
        if len(times) < 2 or abs(times[0]) > SAME_TIME:
            raise ProblemError(
                f"gait {name} needs switching times from 0 to its period, got {times.tolist()}"
            )
        _check_rising(f"gait {name}", times)
        table = _mode_table(f"gait {name}", modes, feet, len(times) - 1)
        keep = [0] + [k for k in range(1, len(table)) if (table[k] != table[k - 1]).any()]
        self._starts = times[keep]
        self.table = table[keep]
        self.period = float(times[-1])
        self.feet = table.shape[1]
        for foot in range(self.feet):
            if not self.table[:, foot].any():
                raise ProblemError(f"gait {name}: foot {foot} is never on the ground")
        twice = np.tile(np.diff(self.switching), 2), np.tile(self.table, (2, 1))  # a flight may span the end
        self._refuse_flight(f"gait {name}", *twice, max_flight)
        self._intervals = [self._foot_intervals(foot) for foot in range(self.feet)]
        self._last = [(True, math.inf, math.inf)] * self.feet

    @classmethod
    def from_phases(
        cls,
        name: str,
        period: float,
        duty: float | Sequence[float],
        offset: Sequence[float],
        max_flight: float = MAX_FLIGHT,
    ) -> Gait:
        """Return the gait in which foot k carries from offset[k] on for duty[k], as shares of the period.

        Parameters
        ----------
        name
            For tables and messages.
        period
            Length of a cycle [s].
        duty
            Share of the period that a foot carries, one for all or one per foot, above 0 and up to 1.
        offset
            When each foot touches down, as a share of the period.
        max_flight
            Longest time without any carrying foot that is accepted [s].
        """
        length = real_number("period", period, low=1e-3, high=60.0)
        begin = np.mod(finite_array("offset", offset, (None,)), 1.0)
        share = np.broadcast_to(finite_array("duty", duty), begin.shape)
        if (share <= 0.0).any() or (share > 1.0).any():
            raise ProblemError(f"duty of gait {name} must be above 0 and at most 1, got {share.tolist()}")
        moving = share < 1.0 - SAME_TIME
        events = np.concatenate([[0.0], begin[moving], np.mod(begin + share, 1.0)[moving]])
        cuts = np.unique(np.round(events, SHARE_DIGITS))
        cuts = np.append(cuts[cuts < 1.0], 1.0)
        # At the middles, where no event is: rounding of a cut cannot put a foot on the wrong side.
        middle = 0.5 * (cuts[1:] + cuts[:-1])
        table = np.mod(middle[:, None] - begin, 1.0) < share
        return cls(name, cuts * length, table | ~moving, max_flight=max_flight)

    def __repr__(self) -> str:
        return f"Gait({self.name!r}, period={self.period:g}, modes={self.modes.tolist()})"

    def __str__(self) -> str:
        shares = ", ".join(f"{100.0 * share:.0f}" for share in self.duty)
        return f"{self.name}: {self.feet} feet, period {self.period:.3g} s, on the ground {shares} % of it."

    @property
    def switching(self) -> FloatArray:
        """(m + 1,) times at which the mode changes, from 0 to the period [s]."""
        return np.append(self._starts, self.period)

    @property
    def duty(self) -> FloatArray:
        """(feet,) share of the period that each foot carries."""
        return np.asarray(np.diff(self.switching) @ self.table / self.period)

    @property
    def offset(self) -> FloatArray:
        """(feet,) share of the period at which each foot touches down first; 0 for one that never lifts."""
        firsts = [[s for s, end, on in spans if on and end > s] for spans in self._intervals]
        return np.array([min((np.mod(s, self.period) for s in f), default=0.0) for f in firsts]) / self.period

    @property
    def swing_time(self) -> float:
        """The longest time that a foot is in the air [s]; 0 when standing."""
        spans = [end - start for foot in self._intervals for start, end, on in foot if not on]
        return max(spans, default=0.0)

    @property
    def stance_time(self) -> float:  # type: ignore[override]
        """The longest time that a moving foot carries [s]; the period when standing."""
        spans = [end - start for foot in self._intervals if len(foot) > 1 for start, end, on in foot if on]
        return max(spans, default=self.period)

    def contacts(self, times: ArrayLike) -> BoolArray:
        """Return which feet carry at (...) times [s]: (..., feet)."""
        t = np.mod(np.asarray(times, dtype=np.float64) + SAME_TIME, self.period)
        return np.asarray(self.table[self._starts.searchsorted(t, side="right") - 1])

    def phase(self, foot: int, time: float) -> tuple[bool, float, float]:
        """Return whether a foot carries at a time, and when that phase began and will end [s]."""
        last = self._last[foot]
        if last[1] <= time + SAME_TIME < last[2]:  # most questions are about the same phase
            return last
        spans = self._intervals[foot]
        if len(spans) == 1:
            return True, -math.inf, math.inf
        turn = math.floor((time + SAME_TIME) / self.period)
        local = time - turn * self.period
        for start, end, on in spans:
            for shift in (0.0, self.period):
                if start - shift - SAME_TIME <= local < end - shift - SAME_TIME:
                    base = turn * self.period - shift
                    self._last[foot] = found = on, base + start, base + end
                    return found
        raise AssertionError("the intervals of a foot cover its period")  # pragma: no cover

    def _foot_intervals(self, foot: int) -> list[tuple[float, float, bool]]:
        """Return (start, end, carries) of a foot's phases over one period, the last may end after it."""
        column = self.table[:, foot]
        changes = [k for k in range(len(column)) if column[k] != column[k - 1]]
        if not changes:
            return [(0.0, self.period, True)]
        spans = []
        for a, b in pairwise([*changes, changes[0]]):
            end = float(self._starts[b]) + (self.period if b == changes[0] else 0.0)
            spans.append((float(self._starts[a]), end, bool(column[a])))
        return spans


class ModeSchedule(_ModeTable):
    """A finite list of modes: before the first event, between events, and after the last (OCS2's form).

    Parameters
    ----------
    event_times
        (m - 1,) rising times at which the mode changes [s].
    modes
        (m, feet) mask of the feet that carry, or (m,) mode numbers with `feet` given.
    feet
        Number of feet; needed for mode numbers.
    max_flight
        Longest time without any carrying foot that is accepted [s].

    Raises
    ------
    ProblemError
        If events overlap (times do not rise), lengths do not match, or no foot is on the ground for
        longer than `max_flight`, at either end included.

    Examples
    --------
    >>> ModeSchedule([0.5, 0.7], [15, 9, 15], feet=4).contacts(0.6)
    array([ True, False, False,  True])
    """

    def __init__(
        self,
        event_times: ArrayLike,
        modes: ArrayLike,
        feet: int | None = None,
        max_flight: float = MAX_FLIGHT,
    ) -> None:
        self.event_times = finite_array("event times", event_times, (None,))
        _check_rising("mode schedule", self.event_times)
        self.table = _mode_table("mode schedule", modes, feet, len(self.event_times) + 1)
        self.feet = self.table.shape[1]
        lengths = np.concatenate([[math.inf], np.diff(self.event_times), [math.inf]])
        self._refuse_flight("the mode schedule", lengths[: len(self.table)], self.table, max_flight)
        self._times: list[float] = self.event_times.tolist()

    def __repr__(self) -> str:
        return f"ModeSchedule(event_times={self.event_times.tolist()}, modes={self.modes.tolist()})"

    def contacts(self, times: ArrayLike) -> BoolArray:
        """Return which feet carry at (...) times [s]: (..., feet)."""
        t = np.asarray(times, dtype=np.float64)
        return np.asarray(self.table[np.searchsorted(self.event_times, t + SAME_TIME, side="right")])

    def phase(self, foot: int, time: float) -> tuple[bool, float, float]:
        """Return whether a foot carries at a time, and when that phase began and will end [s]."""
        column = self.table[:, foot]
        at = bisect_right(self._times, time + SAME_TIME)
        first = last = at
        while first > 0 and column[first - 1] == column[at]:
            first -= 1
        while last < len(self._times) and column[last + 1] == column[at]:
            last += 1
        start = self._times[first - 1] if first > 0 else -math.inf
        end = self._times[last] if last < len(self._times) else math.inf
        return bool(column[at]), start, end


def _check_rising(name: str, times: FloatArray) -> None:
    """Refuse events that do not come one after the other."""
    for k in range(len(times) - 1):
        if times[k + 1] - times[k] <= SAME_TIME:
            raise ProblemError(
                f"{name}: events overlap, time {k + 1} ({times[k + 1]:g} s) must be after "
                f"time {k} ({times[k]:g} s)"
            )


def _mode_table(name: str, modes: ArrayLike, feet: int | None, count: int) -> BoolArray:
    """Return modes as a (count, feet) table of carrying feet."""
    table = array_of(f"the modes of {name}", modes, "biufO", "whole numbers or feet that carry", np.float64)
    if table.ndim == 1:
        if feet is None:
            raise ProblemError(f"{name}: give the number of feet with mode numbers")
        feet = whole_number("feet", feet, low=1)
        if not np.all(table == np.round(table)):
            raise ProblemError(f"the modes of {name} must be whole numbers, got {shown(modes)}")
        table = np.array([mode_feet(int(m), feet) for m in table]).reshape(-1, feet)
    if table.ndim == 0:
        raise ProblemError(f"the modes of {name} must be a list of {count}, got {shown(modes)}")
    if table.ndim != 2 or len(table) != count or table.shape[1] < 1:
        raise ProblemError(f"{name} needs {count} modes between its events, got {len(table)}")
    if feet is not None and table.shape[1] != feet:
        raise ProblemError(f"{name} must have {feet} feet, got {table.shape[1]}")
    return table.astype(bool)
