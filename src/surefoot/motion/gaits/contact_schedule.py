"""What a walk asks of any gait: when each foot is on the ground, and how a gait goes with the walk."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.drawn import Drawn
from surefoot.base.memory import Remembering

SAME_TIME = 1e-9
"""Events closer than this are one event [s]."""


class ContactSchedule(Drawn, Remembering, ABC):
    """When each foot carries: what a walk asks of any gait.

    A schedule that changes calls `_forget_phases`. One that follows the speed writes `follow`, `hold`,
    `release` and `fits`; any other goes on as it is.

    Attributes
    ----------
    name
        For tables and messages.
    feet
        Number of feet.
    period, stance_time
        Length of a cycle, and of the stance in it; 0 for a schedule without one [s].
    clearance
        Height of its swings over the ground [m]; None for the walk's own.
    adapts
        Whether it follows the speed.
    held, turning
        Whether all feet stay on the ground; whether it is not yet in step with the ground, and should be.
    in_step
        Whether its cycle should be that of steps on the ground.
    asked
        (3,) velocity that it follows: forward, left [m/s], turn [rad/s].
    """

    MEMORY: ClassVar[tuple[str, ...]] = ("_rows", "_since", "_until")

    name: str = "schedule"
    feet: int
    period: float = 0.0
    stance_time: float = 0.0
    clearance: float | None = None
    adapts: ClassVar[bool] = False
    held: bool = False
    turning: bool = False
    in_step: bool = False
    asked: FloatArray = np.zeros(3)
    _rows: FloatArray
    _since, _until = math.inf, -math.inf  # `_rows` are of the times between: of none yet

    @abstractmethod
    def contacts(self, times: ArrayLike) -> BoolArray:
        """Return which feet carry at (...) times [s]: (..., feet)."""

    @abstractmethod
    def phase(self, foot: int, time: float) -> tuple[bool, float, float]:
        """Return whether a foot carries at a time, and when that phase began and will end [s].

        The ends are infinite for a foot that never changes.
        """

    @property
    def duty(self) -> FloatArray:
        """(feet,) share of a cycle that each foot carries."""
        return np.ones(self.feet)

    @property
    def coming_period(self) -> float:
        """Length of the cycle that suits the velocity that is followed [s]."""
        return self.period

    def reset(self) -> None:
        """Forget the past."""
        return

    def follow(self, time: float, velocity: FloatArray) -> None:
        """Follow a (3,) velocity [m/s, m/s, rad/s] from a time [s] on."""
        return

    def fits(self, velocity: FloatArray) -> bool:
        """Return whether the gait of now is fit for a (3,) velocity [m/s, m/s, rad/s]."""
        return True

    def hold(self, time: float) -> None:
        """Let no foot lift from a time [s] on, until `release`."""
        return

    def release(self) -> None:
        """Let feet lift again."""
        return

    def phases(self, time: float) -> FloatArray:
        """Return `phase` of every foot: (feet, 3), the first 1 for a foot that carries and else 0.

        What was said is remembered until a foot lifts or lands; it is not to be written to.
        """
        if not self._since <= time < self._until:
            self._rows = np.array([self.phase(k, time) for k in range(self.feet)], dtype=np.float64)
            self._since = float(self._rows[:, 1].max()) - SAME_TIME
            self._until = float(self._rows[:, 2].min()) - SAME_TIME
        return self._rows

    def _forget_phases(self) -> None:
        """Forget what `phases` has said."""
        self._since, self._until = math.inf, -math.inf

    def horizon(self, start: float, step: float, count: int) -> BoolArray:
        """Return which feet carry in the middle of `count` steps of `step` [s]: (count, feet)."""
        return self.contacts(start + step * (np.arange(count) + 0.5))
