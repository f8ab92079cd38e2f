"""What every run has in common: disturbances, the loop over the world's steps, and its share of the log."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import SimulationError, WriteError
from surefoot.robot import Robot
from surefoot.simulation.log import Log
from surefoot.simulation.log_stream import Recorder
from surefoot.simulation.world import ContactReading, World

START_SPEED = 0.01
"""Standard deviation of the seeded disturbance of the base's velocity at the start [m/s]."""
LOOK_EVERY = 20
"""Steps between looks at whether the robot has fallen, and calls of the progress function."""


@dataclass(frozen=True)
class Push:
    """A (3,) force on the base in world axes [N], from `start` for `duration` [s]."""

    start: float
    force: tuple[float, float, float]
    duration: float


@dataclass(frozen=True)
class Ice:
    """The ground's friction becomes `mu` at `start` [s]."""

    start: float
    mu: float


@dataclass(frozen=True)
class Scenario:
    """What happens to the robot.

    Attributes
    ----------
    duration
        Length of the run [s].
    mu
        Friction of the ground at the start.
    pushes, ice
        What disturbs it.
    seed
        Seed of every random number of the run; None for no disturbance at the start.
    """

    duration: float
    mu: float
    pushes: Sequence[Push] = ()
    ice: Sequence[Ice] = ()
    seed: int | None = None

    def steps(self, dt: float) -> int:
        """Return the number of steps of length `dt` [s], at least one."""
        return max(1, round(self.duration / dt))


def start_velocity(robot: Robot, seed: int | None) -> FloatArray | None:
    """Return a small random velocity of the base, or None without a seed."""
    if seed is None:
        return None
    v = np.zeros(robot.model.nv)
    v[:3] = START_SPEED * np.random.default_rng(seed).normal(size=3)
    return v


def push_at(pushes: Sequence[Push], time: float) -> FloatArray | None:
    """Return the sum of the pushes at a time, or None."""
    total = None
    for push in pushes:
        if push.start - 1e-9 <= time < push.start + push.duration - 1e-9:
            total = np.asarray(push.force) if total is None else total + np.asarray(push.force)
    return total


@dataclass(frozen=True)
class Ended:
    """How a run ended.

    Attributes
    ----------
    outcome
        "done", "fell", "invalid" (the state stopped being finite, or the world could not go on),
        "interrupted" or "stopped" (the log could not be written).
    wall_time
        Real time of the run [s].
    error
        One line that says what happened, or empty.
    """

    outcome: str
    wall_time: float
    error: str = ""


def recorder_of(
    world: World, scenario: Scenario, folder: Path | None, facts: dict[str, Any], **more: tuple[int, ...]
) -> Recorder:
    """Return a recorder with the rows and facts that every run has, and more of both.

    `folder` is where the rows go during the run, see `Recorder`.
    """
    robot, p = world.robot, len(world.contact_foot)
    shared = {
        "robot": robot.name,
        "mass": robot.mass,
        "dt": world.dt,
        "feet": list(robot.foot_names),
        "joints": list(robot.joint_names),
        "contact_foot": world.contact_foot,
        "contact_centres": np.vstack([foot.centres for foot in robot.feet]),
        "effort_limits": robot.effort_limits,
        "duration": scenario.duration,
        "outcome": "interrupted",  # until the run has ended in another way
        "wall_time": float("nan"),
        **facts,
    }
    return Recorder(
        scenario.steps(world.dt), folder, shared,
        time=(), q=(int(robot.model.nq),), v=(int(robot.model.nv),), torques=(robot.joints,), forces=(p, 3),
        forces_commanded=(p, 3), gaps=(p,), contact_velocities=(p, 3), contact_positions=(p, 3), active=(p,),
        attained=(), saturated=(), push=(3,), mu=(), controller_time=(), **more,
    )  # fmt: skip


def run_steps(
    world: World,
    scenario: Scenario,
    recorder: Recorder,
    control: Callable[[float, FloatArray, FloatArray, ContactReading], tuple[FloatArray, float]],
    note: Callable[[dict[str, Any], int], None],
    fallen: Callable[[FloatArray], str | None],
    progress: Callable[[float], None] | None,
) -> Ended:
    """Step a world that has been reset to the end, a fall, Ctrl-C or a loss; fill the recorder.

    Whatever ends the run before its first row is complete is raised: there is nothing to keep.

    Parameters
    ----------
    world, scenario, recorder
        Where, what happens, and where the rows go.
    control
        From time, q, v and the last contact reading to (joints,) torques [N m], and the wall time that
        the controller itself took [s].
    note
        Writes the controller's own rows of a step.
    fallen
        Tells "fell" or "invalid" from q, or None.
    progress
        Called with the simulated time now and then.
    """
    begin = clock.perf_counter()
    outcome, error = "done", ""
    try:
        outcome = _loop(world, scenario, recorder, control, note, fallen, progress)
    except (KeyboardInterrupt, SimulationError, WriteError) as stop:
        if recorder.count == 0:
            recorder.abandon()
            raise
        if isinstance(stop, KeyboardInterrupt):
            outcome = "interrupted"
        else:
            outcome, error = "invalid" if isinstance(stop, SimulationError) else "stopped", str(stop)
    except BaseException:
        recorder.abandon()
        raise
    return Ended(outcome, clock.perf_counter() - begin, error)


def _loop(
    world: World,
    scenario: Scenario,
    recorder: Recorder,
    control: Callable[[float, FloatArray, FloatArray, ContactReading], tuple[FloatArray, float]],
    note: Callable[[dict[str, Any], int], None],
    fallen: Callable[[FloatArray], str | None],
    progress: Callable[[float], None] | None,
) -> str:
    """Step the world to the end or a fall and return the outcome; see `run_steps`."""
    rows = recorder.arrays
    ice = sorted(scenario.ice, key=lambda change: change.start)
    mu = scenario.mu
    world.set_friction(mu)
    reading = world.contacts()
    for k in range(scenario.steps(world.dt)):
        # what the world is like, and what the controller makes of it
        now = k * world.dt
        while ice and now >= ice[0].start - 1e-9:
            mu = ice.pop(0).mu
            world.set_friction(mu)
        push = push_at(scenario.pushes, now)
        q, v = world.state()
        torques, spent = control(now, q, v, reading)
        # the step
        world.step(torques, push)
        reading = world.contacts()
        # its row
        i = recorder.slot()
        rows["time"][i], rows["q"][i], rows["v"][i], rows["mu"][i] = now, q, v, mu
        rows["torques"][i], rows["forces"][i], rows["gaps"][i] = torques, reading.forces, reading.gaps
        rows["contact_velocities"][i] = reading.velocities
        rows["contact_positions"][i] = reading.positions
        rows["push"][i] = 0.0 if push is None else push
        rows["controller_time"][i] = spent
        note(rows, i)
        recorder.count += 1
        if k % LOOK_EVERY == 0:
            if progress is not None:
                progress(now)
            verdict = fallen(q)
            if verdict is not None:
                return verdict
    return "done"


def finish(recorder: Recorder, ended: Ended, **more: Any) -> Log:
    """Return the log with how it ended, and `more` facts that only the end knows."""
    told = {"error": ended.error} if ended.error else {}
    return recorder.finish({"outcome": ended.outcome, "wall_time": ended.wall_time, **told, **more})
