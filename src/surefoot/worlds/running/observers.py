"""Who watches a run: called after every step, and with the log at its end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.motion import Command
from surefoot.records import Log
from surefoot.worlds.interface.world import ContactReading


class Moment(NamedTuple):
    """One step of a run.

    Attributes
    ----------
    time
        At its start [s].
    q, v
        (nq,), (nv,) state at its start, Pinocchio's order.
    torques
        (joints,) that the motors gave [N m]; with faults, not those that were asked for.
    push
        (3,) external force on the base, world axes [N], or None.
    mu
        Friction of the ground.
    controller_time
        Wall time of the controller's step [s].
    command
        What the controller asked for.
    reading
        What the ground did.
    """

    time: float
    q: FloatArray
    v: FloatArray
    torques: FloatArray
    push: FloatArray | None
    mu: float
    controller_time: float
    command: Command
    reading: ContactReading


class Observer(Protocol):
    """Watches a run; subclass it to leave out what is not needed. What it raises ends the run."""

    def step(self, moment: Moment) -> None:
        """See a step that was made and logged."""
        return

    def end(self, log: Log) -> None:
        """See the log of the run, however that ended."""
        return


EVERY = 0.02
"""Simulated time between calls of `RunProgress` [s]."""


class RunProgress(Observer):
    """Tells how far a run is.

    Parameters
    ----------
    tell
        Called with the simulated time [s].
    """

    def __init__(self, tell: Callable[[float], None]) -> None:
        self._tell, self._next = tell, 0.0

    def step(self, moment: Moment) -> None:
        """Tell the time, if it is due."""
        if moment.time >= self._next:
            self._tell(moment.time)
            self._next = moment.time + EVERY


class LinkContactObserver(Observer, Remembering):
    """Counts the steps in which pairs that are no foot on the ground touched.

    Parameters
    ----------
    world
        Its method ``touching()`` gives pairs of names, if it has one.

    Attributes
    ----------
    found
        Pair of names to when it first touched [s], and in how many steps.
    """

    MEMORY = ("found",)

    def __init__(self, world: Any) -> None:
        self._touching: Callable[[], list[tuple[str, str]]] | None = getattr(world, "touching", None)
        self.found: dict[tuple[str, str], tuple[float, int]] = {}

    def step(self, moment: Moment) -> None:
        """Note what touched in a step."""
        others = moment.reading.others
        if self._touching is None or others is None or not any(others.tolist()):
            return
        for a, b in {(min(pair), max(pair)) for pair in self._touching()}:
            first, steps = self.found.get((a, b), (moment.time, 0))
            self.found[a, b] = first, steps + 1

    def lines(self, dt: float) -> list[str]:
        """Return a line for every pair that touched, the first one first; steps are of length `dt` [s]."""
        pairs = sorted(self.found.items(), key=lambda item: item[1][0])
        return [
            f"{a} and {b} from {first:.3f} s on, for {1e3 * dt * steps:.0f} ms"
            for (a, b), (first, steps) in pairs
        ]
