"""The clock of a gait: it starts with the gait, may be held up by feet, and hurried by a recovery."""

from __future__ import annotations

from typing import NamedTuple


class GaitClock(NamedTuple):
    """Time on a walk's schedule.

    Attributes
    ----------
    time
        On the schedule at this step, negative before the gait begins [s].
    behind
        Time by which the schedule is behind the time since the gait's start [s], which is `time + behind`.
    rate
        How many times as fast as time the schedule goes [-]; feet that wait hold it up beside that.
    """

    time: float
    behind: float = 0.0
    rate: float = 1.0

    def at(self, since_start: float) -> GaitClock:
        """Return the clock at a time since the gait's start [s]."""
        return GaitClock(since_start - self.behind, self.behind, self.rate)

    def advanced(self, dt: float, rate: float, held: bool = False) -> GaitClock:
        """Return the clock that a step of dt [s] leaves, at a rate, and held up for the step or not.

        `time` stays that of the step. This is the one place that changes `behind` and `rate`.

        Examples
        --------
        >>> GaitClock(0.5).advanced(0.01, 1.0, held=True)
        GaitClock(time=0.5, behind=0.01, rate=1.0)
        >>> GaitClock(0.5).advanced(0.01, 1.5).at(0.51).time
        0.515
        """
        if not held and rate == self.rate == 1.0:
            return self
        behind = self.behind + dt if held else self.behind
        return GaitClock(self.time, behind - (rate - 1.0) * dt, rate)
