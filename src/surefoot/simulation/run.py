"""What every run has in common: disturbances, the loop over the world's steps, and its share of the log."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.robot import Robot
from surefoot.simulation.log import Log, Recorder
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


def recorder_of(world: World, steps: int, **more: tuple[int, ...]) -> Recorder:
    """Return a recorder with the rows that every run has, and `more`."""
    robot, p = world.robot, len(world.contact_foot)
    return Recorder(
        steps,
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
) -> tuple[str, float]:
    """Step a world that has been reset to the end, a fall or Ctrl-C; fill the recorder.

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

    Returns
    -------
    tuple
        How it ended ("done", "fell", "invalid" or "interrupted"), and the wall time [s].
    """
    rows, clocked = recorder.arrays, clock.perf_counter
    ice = sorted(scenario.ice, key=lambda change: change.start)
    mu, begin = scenario.mu, clocked()
    world.set_friction(mu)
    reading = world.contacts()
    try:
        for k in range(scenario.steps(world.dt)):
            now = k * world.dt
            while ice and now >= ice[0].start - 1e-9:
                mu = ice.pop(0).mu
                world.set_friction(mu)
            push = push_at(scenario.pushes, now)
            q, v = world.state()
            torques, rows["controller_time"][k] = control(now, q, v, reading)
            world.step(torques, push)
            reading = world.contacts()
            rows["time"][k], rows["q"][k], rows["v"][k], rows["mu"][k] = now, q, v, mu
            rows["torques"][k], rows["forces"][k], rows["gaps"][k] = torques, reading.forces, reading.gaps
            rows["contact_velocities"][k] = reading.velocities
            rows["contact_positions"][k] = reading.positions
            if push is not None:
                rows["push"][k] = push
            note(rows, k)
            recorder.count = k + 1
            if k % LOOK_EVERY == 0:
                if progress is not None:
                    progress(now)
                verdict = fallen(q)
                if verdict is not None:
                    return verdict, clocked() - begin
    except KeyboardInterrupt:
        return "interrupted", clocked() - begin
    return "done", clocked() - begin


def finish(
    world: World, scenario: Scenario, recorder: Recorder, ended: tuple[str, float], **more: Any
) -> Log:
    """Return the log with the facts that every run has, and `more`."""
    robot = world.robot
    return recorder.finish(
        {
            "robot": robot.name,
            "mass": robot.mass,
            "dt": world.dt,
            "feet": list(robot.foot_names),
            "joints": list(robot.joint_names),
            "contact_foot": world.contact_foot,
            "contact_centres": np.vstack([foot.centres for foot in robot.feet]),
            "effort_limits": robot.effort_limits,
            "duration": scenario.duration,
            "outcome": ended[0],
            "wall_time": ended[1],
            **more,
        }
    )
