"""The state of a run as a value: all that lasts from step to step in the world, controller and between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Arrays, Memory, alike, read_state, write_down
from surefoot.motion import STATE_KINDS, Command, Controller, state_of
from surefoot.worlds.interface.world import ContactReading, World, kind_of
from surefoot.worlds.interface.world_state import WorldState, world_state
from surefoot.worlds.running.scenario import Ice, Scenario


@dataclass(frozen=True, eq=False)
class RunState:
    """All that lasts from one step of a run to the next; see `run`.

    Attributes
    ----------
    step, time
        Number of the step that comes next, and its time [s].
    height
        Of the base over the ground at the start of the run [m].
    stopped
        Time at which the state estimate was lost [s]; infinite while it is not.
    setting
        What the run was made with, in words by name: a run goes on in the same setting alone.
    world, controller
        States of the world, and of the controller with what is around it.
    parts
        Memories of what is between them by name: sensors and estimate, faults, friction, observers.
    command
        The last one; None before the first.

    Examples
    --------
    A push of 80 N at 0.6 s, and what would have been without it:

    >>> import surefoot as sf
    >>> from surefoot.worlds.running.run_state import StateKeeper
    >>> robot = sf.load_robot("go2")
    >>> walker = lambda: sf.WalkingController(robot, sf.VelocityCommand.constant(0.4))
    >>> kept = []
    >>> pushed = sf.Scenario(0.7, pushes=[sf.Push(0.6, (0.0, 80.0, 0.0), 0.05)])
    >>> whole = sf.run(sf.MujocoWorld(robot), walker(), pushed, keep=StateKeeper(0.5, kept.append))
    >>> [state.time for state in kept]
    [0.0, 0.5]
    >>> again = sf.run(sf.MujocoWorld(robot), walker(), pushed, resume=kept[1])
    >>> len(again), again["q"].tobytes() == whole["q"][500:].tobytes()
    (200, True)
    >>> calm = sf.run(sf.MujocoWorld(robot), walker(), sf.Scenario(0.7), resume=kept[1])
    >>> bool(abs(whole["v"][-1, 1]) > abs(calm["v"][-1, 1]))
    True
    """

    step: int
    time: float
    height: float
    stopped: float
    setting: dict[str, str]
    world: WorldState
    controller: Any
    parts: dict[str, Memory]
    command: Command | None = None

    def __eq__(self, other: object) -> bool:
        """Return whether another state is the same to the last bit."""
        return isinstance(other, RunState) and alike(self, other)

    __hash__ = None  # type: ignore[assignment]

    def to_arrays(self) -> tuple[Arrays, Any]:
        """Return the state as plain arrays by path, and facts that JSON can hold.

        Raises
        ------
        ProblemError
            For what a controller keeps that is neither.
        """
        try:
            return write_down(self, KINDS)
        except TypeError as error:
            raise ProblemError(f"the state of this run cannot be written down: {error}") from error

    @staticmethod
    def from_arrays(arrays: Arrays, facts: Any) -> RunState:
        """Return the state that `to_arrays` has written down.

        Raises
        ------
        ProblemError
            For arrays and facts that are no such state.
        """
        state = read_state(RunState, "a run", arrays, facts, KINDS)
        if not isinstance(state.world, WorldState):
            raise ProblemError("this is no state of a run")
        return state

    def check(self, setting: Mapping[str, str], steps: int) -> None:
        """Refuse to go on in another setting, or to a run's end that lies before.

        Raises
        ------
        ProblemError
            Naming what differs.
        """
        for name, words in setting.items():
            if self.setting.get(name) != words:
                was = self.setting.get(name, "unknown")
                raise ProblemError(
                    f"the state is of a run with another {name}: {was:.80}, now it is {words:.80}"
                )
        if self.step >= steps:
            raise ProblemError(f"the state is of {self.time:.3f} s, the run ends before that")


KINDS: dict[str, type] = STATE_KINDS | {
    kind.__name__: kind for kind in (RunState, WorldState, ContactReading, Ice)
}
"""Classes of what the state of a run consists of, by name."""


@dataclass(frozen=True)
class StateKeeper:
    """Keeps states of a run as it goes.

    Attributes
    ----------
    every
        Time between two of them [s]; the first is that of the start.
    take
        Called with each `RunState`.
    """

    every: float
    take: Callable[[RunState], object]

    def steps(self, dt: float) -> int:
        """Return the number of steps of `dt` [s] between two states.

        Raises
        ------
        ProblemError
            For a time that is no positive number, or shorter than a step.
        """
        every = real_number("time between kept states", self.every, low=dt, high=1e6)
        return max(1, round(every / dt))


def check_resumable(world: World, controller: Controller, asked: bool) -> None:
    """Refuse, where it is asked for, a world or a controller that does not tell its whole state.

    Raises
    ------
    ProblemError
        Naming which.
    """
    if asked:
        world_state(world), state_of(controller)


def setting_of(world: World, controller: Controller, scenario: Scenario) -> dict[str, str]:
    """Return what a run is made with, in words by name; pushes, patches, falls and the end may change."""
    inner: Any = controller
    chain = list[str]()
    while inner is not None:
        chain.append(type(inner).__name__)
        inner = getattr(inner, "controller", None)  # what a wrapper is around
    said = {name: value for name, value in controller.facts.items() if name not in ("notes", "ahead")}
    faults = scenario.faults
    levels = None if faults is None else [(n, v) for n, v in vars(faults).items() if n != "dropouts"]
    return {
        "robot": world.robot.name, "world": kind_of(world), "controller": " around ".join(chain),
        "facts of the controller": repr(sorted((n, np.asarray(v).tolist()) for n, v in said.items())),
        "friction": repr(scenario.mu), "ice": repr(list(scenario.ice)), "faults": repr(levels),
        "sensors": repr(scenario.sensors), "range sensor": repr(scenario.scanner),
    }  # fmt: skip
