"""A run that is watched and steered while it goes: paced to real time, commanded by keys.

Who shows it is a `LiveView`; `surefoot.app.viz.window` has one. What is steered is a controller with a method
`steer`, which limits and ramps the velocity as any other (`WalkingController.steer`).
"""

from __future__ import annotations

import math
import time as clock
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records import Log
from surefoot.worlds.running.observers import Moment, Observer

STEPS = (0.1, 0.1, 0.2)
"""What a key changes: forward, left [m/s], yaw rate [rad/s]."""
STOP_KEY = 32
"""The space bar."""
KEYS: dict[int, tuple[int, int]] = {
    265: (0, 1), ord("W"): (0, 1), 264: (0, -1), ord("S"): (0, -1),
    263: (2, 1), ord("A"): (2, 1), 262: (2, -1), ord("D"): (2, -1), ord("Q"): (1, 1), ord("E"): (1, -1),
}  # fmt: skip
"""Key in GLFW's numbers (up, down, left, right are 265, 264, 263, 262) -> (component, direction)."""
LATE = 0.25
"""A run that is later than this does not catch up: what was lost is lost [s]."""
RATE = 60.0
"""Pictures, and looks at keys, per second."""


class Steering:
    """The velocity that keys ask for.

    Parameters
    ----------
    steer
        Takes a velocity (3,) and returns what is left of it within the limits.
    start
        (3,) velocity at first: forward, left [m/s], yaw rate [rad/s].
    """

    def __init__(self, steer: Callable[[FloatArray], FloatArray], start: Sequence[float]) -> None:
        self._steer = steer
        self.velocity = np.array(start, dtype=np.float64)

    def press(self, key: int) -> bool:
        """Take a key in GLFW's numbers; return whether it means something."""
        if key == STOP_KEY:
            self._ask(slice(None), 0.0)
            return True
        if key not in KEYS:
            return False
        component, direction = KEYS[key]
        self._ask(component, round(self.velocity[component] + direction * STEPS[component], 6))
        return True

    def _ask(self, component: int | slice, speed: float) -> None:
        """Ask for another speed in a component, or in several, and go on from what is granted."""
        wanted = self.velocity.copy()
        wanted[component] = speed
        self.velocity = np.array(self._steer(wanted))


class Pacer:
    """Lets simulated time pass no faster than real time.

    Parameters
    ----------
    now, sleep
        The clock, and what waits [s].
    """

    def __init__(
        self,
        now: Callable[[], float] = clock.perf_counter,
        sleep: Callable[[float], None] = clock.sleep,
    ) -> None:
        self._now, self._sleep = now, sleep
        self._start = math.nan

    def wait(self, time: float) -> float:
        """Wait until a simulated time is due and return how late it is [s], 0 if it was waited for."""
        if math.isnan(self._start):
            self._start = self._now() - time
        ahead = self._start + time - self._now()
        if ahead > 0.0:
            self._sleep(ahead)
            return 0.0
        if -ahead > LATE:
            self._start -= ahead  # behind: go on from here
        return -ahead


class LiveView(Protocol):
    """Shows a run."""

    def open(self, press: Callable[[int], object]) -> None:
        """Begin to show; `press` is called with every key in GLFW's numbers, from any thread."""

    def show(self, q: FloatArray, velocity: FloatArray) -> bool:
        """Show (nq,) q [m, -, rad] and the velocity that is asked for; return False once it was closed."""
        ...

    def close(self) -> None:
        """Stop showing."""


class Live(Observer):
    """Shows a run while it goes, and lets it be steered; closing the view ends the run as Ctrl-C does.

    Parameters
    ----------
    view
        What shows it; opened here.
    steering
        What keys do.
    pacer
        Keeps the time.
    """

    def __init__(self, view: LiveView, steering: Steering, pacer: Pacer | None = None) -> None:
        self._view, self._steering = view, steering
        self._pacer = pacer or Pacer()
        self._keys: deque[int] = deque()
        self._next = -math.inf
        view.open(self._keys.append)

    def step(self, moment: Moment) -> None:
        """Wait for the time of a step; now and then show it and look at what is asked for.

        Raises
        ------
        KeyboardInterrupt
            Once the view was closed.
        """
        if moment.time < self._next:
            return
        self._next = moment.time + 1.0 / RATE - 1e-9
        while self._keys:
            self._steering.press(self._keys.popleft())
        if not self._view.show(moment.q, self._steering.velocity):
            raise KeyboardInterrupt
        self._pacer.wait(moment.time)

    def end(self, log: Log) -> None:
        """Close the view."""
        self._view.close()
