"""The loop: measure, control, step, look whether it failed; recorded as a user would."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import mujoco
import numpy as np

import surefoot as sf
from benchmarks.foreign.fault import Draw, Fault, Run
from surefoot.records import Log

AFTER = 0.4
"""Time that a run goes on after its failure [s]."""
MOST_ATTEMPTS = 100
"""Largest number of draws of a seed until one fails."""


class Settings(Protocol):
    """What all loops' settings have: length and time step of a run, and the age of measurements [s]."""

    @property
    def duration(self) -> float:
        """Length [s]."""

    @property
    def timestep(self) -> float:
        """Time step [s]."""

    @property
    def delay(self) -> float:
        """Age of measurements [s]."""


class Control(Protocol):
    """A stranger's controller and what it knows of its task."""

    def start(self, data: Any) -> None:
        """Set the initial state."""

    def step(self, time: float, q: Any, v: Any) -> Any:
        """Return the controls, from measured positions and velocities in MuJoCo's order."""

    def fallen(self, data: Any) -> str:
        """Return how the run has failed for good, else an empty string."""

    def missed(self, data: Any) -> str:
        """Return at the end in which way the task was not attained, else an empty string."""

    def facts(self) -> dict[str, Any]:
        """Return what the user writes into the log by hand: the mass that the controller believes."""

    def command(self) -> Any:
        """Return the velocity that is commanded: (3,) forward, left [m/s], yaw rate [rad/s]; or None."""


@dataclass(frozen=True)
class Loop:
    """A loop of a stranger's: model, controller, lawful variations, and the failures that it can have.

    Attributes
    ----------
    name
        Of the loop.
    mjcf
        Model of settings, as text.
    control
        Controller of a model and settings.
    vary
        Draws settings of a lawful run.
    faults
        Cause to what draws a failure of it.
    robot
        The `robot=` of `sf.record`, of settings.
    """

    name: str
    mjcf: Callable[[Any], str]
    control: Callable[[Any, Any], Control]
    vary: Callable[[np.random.Generator], Any]
    faults: Mapping[str, Draw]
    robot: Callable[[Any], str | None] = lambda settings: None

    def lawful(self, seed: int) -> Run:
        """Return a run without a fault."""
        return self._run(self.vary(self._random("", seed, 0)), None, seed, 0)

    def failed(self, cause: str, seed: int) -> Run:
        """Return a run that fails of a cause: draws that do not fail are drawn again.

        Raises
        ------
        RuntimeError
            If none of `MOST_ATTEMPTS` draws failed.
        """
        for attempt in range(MOST_ATTEMPTS):
            rng = self._random(cause, seed, attempt)
            settings = self.vary(rng)
            fault = self.faults[cause](rng)
            settings = replace(settings, **fault.settings)
            run = self._run(settings, fault, seed, attempt)
            caused = run.onset is None or run.onset <= run.failed_at
            if fault.on_log is not None:
                if not run.failure:
                    return replace(run, log=fault.on_log(run.log), failure="the log is not what happened")
            elif run.failure and caused and (fault.begins is None or run.onset is not None):
                return run
        raise RuntimeError(f"{self.name}: no draw of {cause!r}, seed {seed}, fails")

    def _random(self, cause: str, seed: int, attempt: int) -> np.random.Generator:
        return np.random.default_rng([*self.name.encode(), *cause.encode(), seed, attempt])

    def _run(self, settings: Any, fault: Fault | None, seed: int, attempt: int) -> Run:
        log, onset, failure, at = simulate(self, settings, fault or Fault(""))
        return Run(self.name, seed, attempt, log, fault, onset, failure, at)


def simulate(loop: Loop, settings: Any, fault: Fault) -> tuple[Log, float | None, str, float]:
    """Return a run's log, the onset of its fault, how it failed, and when [s]."""
    model = mujoco.MjModel.from_xml_string(loop.mjcf(settings))
    data = mujoco.MjData(model)
    control = loop.control(model, settings)
    control.start(data)
    mujoco.mj_forward(model, data)
    onset, failure, failed_at = fault.onset, "", float("inf")
    measured = deque[Any](maxlen=1 + round(settings.delay / settings.timestep))
    with sf.record(model, data, loop.robot(settings)) as log:
        while data.time < min(settings.duration, failed_at + AFTER):
            q, v = data.qpos.copy(), data.qvel.copy()
            if fault.on_measured is not None:
                fault.on_measured(data.time, q, v)
            measured.append((q, v))
            data.ctrl[:] = control.step(data.time, *measured[0])
            if fault.on_step is not None:
                fault.on_step(model, data)
            before = data.time
            mujoco.mj_step(model, data)
            if not data.time > before:  # MuJoCo has reset an unstable state
                failure, failed_at = failure or "the simulation became unstable", min(before, failed_at)
                break
            if onset is None and fault.begins is not None and fault.begins(model, data):
                onset = float(data.time)
            if not failure:
                failure = control.fallen(data)
                failed_at = float(data.time) if failure else failed_at
    if not failure:
        failure = control.missed(data)
        failed_at = float(data.time) if failure else failed_at
    return _with_notes(log, control), onset, failure, failed_at


def _with_notes(log: Log, control: Control) -> Log:
    """Return the log with the command and the facts that the loop has."""
    command, arrays = control.command(), dict(log.arrays)
    if command is not None:
        arrays["command"] = np.broadcast_to(np.asarray(command, dtype=float), (len(log), 3)).copy()
    return Log(arrays, {**log.facts, **control.facts()})
