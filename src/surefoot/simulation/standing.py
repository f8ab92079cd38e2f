"""Run a standing robot in a world: pushes, ice, payload and lifted feet, logged step by step."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.standing import Command, StandingController
from surefoot.robot import Robot
from surefoot.simulation.log import Log, Recorder
from surefoot.simulation.world import World
from surefoot.spatial import rotation_from_quaternion

FALL_HEIGHT = 0.5
"""The robot has fallen when its base is below this share of its starting height ..."""
FALL_TILT = np.radians(50.0)
"""... or tilts this far from its starting orientation [rad]."""
START_DEPTH = 1e-5
"""The robot starts this deep in the ground, so that rounding leaves no foot in the air [m]."""
START_SPEED = 0.01
"""Standard deviation of the seeded disturbance of the base's velocity at the start [m/s]."""


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
class StandScenario:
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
        Seed of a small disturbance of the base's velocity at the start; None for none.
    """

    duration: float
    mu: float
    pushes: Sequence[Push] = ()
    ice: Sequence[Ice] = ()
    seed: int | None = None


def run_standing(
    world: World,
    controller: StandingController,
    q: FloatArray,
    scenario: StandScenario,
    progress: Callable[[float], None] | None = None,
) -> Log:
    """Run the controller in the world and return the log, also when interrupted or fallen.

    The log's fact ``outcome`` is "done", "fell", "interrupted" or "invalid" (the state stopped being
    finite). `progress` is called with the simulated time about every 20 ms of it.
    """
    steps = max(1, round(scenario.duration / world.dt))
    _warm_up(world, controller, q)
    q = q.copy()
    q[:3] -= START_DEPTH * world.terrain.normal(q[:2])
    world.reset(q, start_velocity(world.robot, scenario.seed))
    world.set_friction(scenario.mu)
    recorder = _recorder(world, steps)
    rows = recorder.arrays
    ice = sorted(scenario.ice, key=lambda change: change.start)
    mu, outcome, begin = scenario.mu, "done", clock.perf_counter()
    up = rotation_from_quaternion(q[3:7])
    try:
        for k in range(steps):
            now = k * world.dt
            while ice and now >= ice[0].start - 1e-9:
                mu = ice.pop(0).mu
                world.set_friction(mu)
            push = push_at(scenario.pushes, now)
            state, velocity = world.state()
            start = clock.perf_counter()
            command = controller.step(state, velocity, now)
            rows["controller_time"][k] = clock.perf_counter() - start
            world.step(command.torques, push)
            record(rows, k, now, state, velocity, command, world, push, mu)
            recorder.count = k + 1
            if k % 20 == 0:
                if progress is not None:
                    progress(now)
                verdict = fallen(state, q, up)
                if verdict:
                    outcome = verdict
                    break
    except KeyboardInterrupt:
        outcome = "interrupted"
    return recorder.finish(_facts(world, controller, scenario, outcome, clock.perf_counter() - begin))


def _warm_up(world: World, controller: StandingController, q: FloatArray) -> None:
    """Compile or load every kernel of the loop, so that times are of the steps alone."""
    world.reset(q)
    state, velocity = world.state()
    for time in (0.0, *(0.5 * (lift.start + lift.end) for lift in controller.plan.lifts)):
        world.step(controller.step(state, velocity, time).torques)
    world.contacts()
    controller.reset()


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


def fallen(q: FloatArray, start: FloatArray, rotation: FloatArray) -> str | None:
    """Return "fell" or "invalid" when the state says so, else None."""
    if not np.isfinite(q).all():
        return "invalid"
    # the cosine of the turn since the start, from the trace
    turn = 0.5 * (float(np.trace(rotation.T @ rotation_from_quaternion(q[3:7]))) - 1.0)
    if turn < np.cos(FALL_TILT) or q[2] - start[2] < -FALL_HEIGHT * abs(start[2]):
        return "fell"
    return None


def record(
    rows: dict[str, Any],
    k: int,
    now: float,
    q: FloatArray,
    v: FloatArray,
    command: Command,
    world: World,
    push: FloatArray | None,
    mu: float,
) -> None:
    """Write one step into the rows of a log."""
    reading = world.contacts()
    rows["time"][k], rows["q"][k], rows["v"][k], rows["mu"][k] = now, q, v, mu
    rows["torques"][k] = command.torques
    rows["forces"][k], rows["gaps"][k] = reading.forces, reading.gaps
    rows["contact_velocities"][k], rows["contact_positions"][k] = reading.velocities, reading.positions
    rows["forces_commanded"][k] = command.forces
    rows["wrench_desired"][k], rows["wrench_error"][k] = command.wrench_desired, command.wrench_error
    rows["grasp_map"][k] = command.grasp_map
    rows["active"][k] = command.active
    rows["attained"][k], rows["saturated"][k] = command.attained, command.saturated
    if push is not None:
        rows["push"][k] = push


def _recorder(world: World, steps: int) -> Recorder:
    robot, p = world.robot, len(world.contact_foot)
    nq, nv = int(robot.model.nq), int(robot.model.nv)
    return Recorder(
        steps,
        time=(), q=(nq,), v=(nv,), torques=(robot.joints,), forces=(p, 3), forces_commanded=(p, 3), gaps=(p,),
        contact_velocities=(p, 3), contact_positions=(p, 3), wrench_desired=(6,), wrench_error=(6,),
        grasp_map=(6, 3 * p), active=(p,), attained=(), saturated=(), push=(3,), mu=(), controller_time=(),
    )  # fmt: skip


def _facts(
    world: World, controller: StandingController, scenario: StandScenario, outcome: str, wall: float
) -> dict[str, Any]:
    robot = world.robot
    return {
        "robot": robot.name,
        "mass": robot.mass,
        "dt": world.dt,
        "feet": list(robot.foot_names),
        "joints": list(robot.joint_names),
        "contact_foot": world.contact_foot,
        "contact_centres": np.vstack([foot.centres for foot in robot.feet]),
        "effort_limits": robot.effort_limits,
        "normal_min": controller.normal_min,
        "normal_max": controller.normal_max,
        "mu_controller": controller.mu,
        "duration": scenario.duration,
        "outcome": outcome,
        "wall_time": wall,
    }
