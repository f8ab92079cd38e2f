"""What is different where a simulator speaks for the robot: time, patience, and copies that do not fit."""

from __future__ import annotations

from surefoot.motion.drive.readings import ReadingLimits

SOONEST = 0.75
"""A message that comes sooner after the last than this many of the loop's steps is passed over."""
OVERDUE = 0.1
"""A reading is missing after such a time since the last [s]. A simulator that says nothing has most likely
been held up by its computer, and its robot with it: steps that are made meanwhile would run ahead of it."""
STOPPED = 5.0
"""Time after which a reading is missing in slow motion, where a busy computer stops a simulator [s]."""
FASTEST, TURNING = 20.0, 5.0
"""Speeds of a joint and of the base [rad/s] at which a copy that mixes two steps is still believed: what
Unitree's motors can do, and a base that tumbles."""


def simulator_limits(dt: float) -> ReadingLimits:
    """Return limits for readings of a simulator, a step of the loop being dt [s].

    Angles and speeds are copied beside the thread that steps them, so that they may be two steps apart, and
    a busy computer keeps a simulated robot waiting, which hurts nobody: its motors hold their torques.
    """
    usual = ReadingLimits()
    return ReadingLimits(
        patience=max(usual.patience, 10.0 * dt), outage=1.0, latest=1.0,
        mismatch=usual.mismatch + 2.0 * dt * FASTEST, turned=usual.turned + 2.0 * dt * TURNING, uneven=True,
    )  # fmt: skip


class SimulatorClock:
    """Times of a simulator's readings: by its ticks where they move, by arrival where they do not.

    Parameters
    ----------
    dt
        The loop's step [s].
    ticking
        Whether the ticks move.
    """

    def __init__(self, dt: float, ticking: bool) -> None:
        self.dt, self.ticking = dt, ticking
        self._last = float("-inf")

    def stamp(self, told: float, now: float) -> float | None:
        """Return the time of a reading [s], None for one that is no new one or comes too soon.

        Parameters
        ----------
        told
            By the simulator's ticks [s].
        now
            By the clock of this side [s].
        """
        time = told if self.ticking else now
        if 0.0 <= time - self._last < SOONEST * self.dt:
            return None
        self._last = time
        return time
