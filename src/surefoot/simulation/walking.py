"""Run a walking robot in a world: pushes, ice and faults, logged step by step."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.walking import WalkCommand, WalkingController
from surefoot.simulation.faults import Faults
from surefoot.simulation.log import Log, Recorder
from surefoot.simulation.standing import Ice, Push, push_at
from surefoot.simulation.world import ContactReading, World
from surefoot.spatial import GRAVITY, rotation_from_quaternion

TOUCH = 0.02
"""A foot feels the ground when its normal force exceeds this share of m g."""
LOWEST, STEEPEST = 0.4, math.radians(60.0)
"""The robot has fallen when its base is below this share of its height over the ground, or tilts this far."""
AT_LIMIT = 1.0 - 1e-6
"""A torque is saturated from this share of its limit on."""
START_SPEED = 0.01
"""Standard deviation of the seeded disturbance of the base's velocity at the start [m/s]."""


@dataclass(frozen=True)
class WalkScenario:
    """What happens to the robot.

    Attributes
    ----------
    duration
        Length of the run [s].
    mu
        Friction of the ground at the start.
    pushes, ice
        What disturbs it.
    faults
        What is wrong with sensors and motors; None for nothing.
    seed
        Seed of every random number of the run; None for no disturbance at the start.
    """

    duration: float
    mu: float
    pushes: Sequence[Push] = ()
    ice: Sequence[Ice] = ()
    faults: Faults | None = None
    seed: int | None = None


def run_walking(
    world: World,
    controller: WalkingController,
    q: FloatArray,
    scenario: WalkScenario,
    progress: Callable[[float], None] | None = None,
) -> Log:
    """Run the controller in the world and return the log, also when interrupted or fallen.

    The log's fact ``outcome`` is "done", "fell", "interrupted" or "invalid" (the state stopped being
    finite). `progress` is called with the simulated time about every 20 ms of it.
    """
    steps = max(1, round(scenario.duration / world.dt))
    world.reset(q, _start_velocity(world, scenario.seed))
    world.set_friction(scenario.mu)
    recorder = _recorder(world, steps)
    faults = (scenario.faults or Faults()).start(world, scenario.seed)
    ice = sorted(scenario.ice, key=lambda change: change.start)
    height = float(q[2] - world.terrain.height(q[:2]))
    mu, outcome, begin = scenario.mu, "done", clock.perf_counter()
    reading = world.contacts()
    try:
        for k in range(steps):
            now = k * world.dt
            while ice and now >= ice[0].start - 1e-9:
                mu = ice.pop(0).mu
                world.set_friction(mu)
            push = push_at(scenario.pushes, now)
            state, velocity = world.state()
            seen, moving = faults.sense(state, velocity)
            start = clock.perf_counter()
            command = controller.step(seen, moving, _felt(world, reading), now)
            spent = clock.perf_counter() - start
            torques = faults.act(command.whole_body.torques)
            world.step(torques, push)
            reading = world.contacts()
            _record(recorder.arrays, k, now, state, velocity, torques, command, controller, reading, push, mu)
            recorder.arrays["controller_time"][k] = spent
            recorder.count = k + 1
            if k % 20 == 0:
                if progress is not None:
                    progress(now)
                verdict = _fallen(world, state, height)
                if verdict:
                    outcome = verdict
                    break
    except KeyboardInterrupt:
        outcome = "interrupted"
    return recorder.finish(_facts(world, controller, scenario, outcome, clock.perf_counter() - begin))


def _start_velocity(world: World, seed: int | None) -> FloatArray | None:
    if seed is None:
        return None
    v = np.zeros(world.robot.model.nv)
    v[:3] = START_SPEED * np.random.default_rng(seed).normal(size=3)
    return v


def _felt(world: World, reading: ContactReading) -> BoolArray:
    """Return which feet feel the ground: (n,)."""
    out = np.zeros(len(world.robot.feet), dtype=bool)
    out[world.contact_foot[reading.forces[:, 2] > TOUCH * world.robot.mass * GRAVITY]] = True
    return out


def _fallen(world: World, q: FloatArray, height: float) -> str | None:
    """Return "fell" or "invalid" when the state says so, else None."""
    if not np.isfinite(q).all():
        return "invalid"
    up = rotation_from_quaternion(q[3:7])[:, 2]
    normal = world.terrain.normal(q[:2])
    if float(up @ normal) < math.cos(STEEPEST) or q[2] - float(world.terrain.height(q[:2])) < LOWEST * height:
        return "fell"
    return None


def _record(
    rows: dict[str, Any],
    k: int,
    now: float,
    q: FloatArray,
    v: FloatArray,
    torques: FloatArray,
    command: WalkCommand,
    controller: WalkingController,
    reading: ContactReading,
    push: FloatArray | None,
    mu: float,
) -> None:
    """Write one step into the rows of a log."""
    whole = command.whole_body
    foot = controller.whole_body.point_foot
    rows["time"][k], rows["q"][k], rows["v"][k], rows["mu"][k] = now, q, v, mu
    rows["torques"][k] = torques
    rows["forces"][k], rows["gaps"][k] = reading.forces, reading.gaps
    rows["contact_velocities"][k], rows["contact_positions"][k] = reading.velocities, reading.positions
    rows["forces_commanded"][k] = whole.forces
    rows["active"][k], rows["planned"][k] = command.carrying[foot], command.planned
    limits = controller.whole_body.limits
    rows["attained"][k] = whole.feasible
    rows["saturated"][k] = (np.abs(whole.torques) >= AT_LIMIT * limits).any()
    rows["command"][k] = command.wanted
    if push is not None:
        rows["push"][k] = push


def _recorder(world: World, steps: int) -> Recorder:
    robot, p = world.robot, len(world.contact_foot)
    return Recorder(
        steps,
        time=(), q=(int(robot.model.nq),), v=(int(robot.model.nv),), torques=(robot.joints,), forces=(p, 3),
        forces_commanded=(p, 3), gaps=(p,), contact_velocities=(p, 3), contact_positions=(p, 3), active=(p,),
        planned=(len(robot.feet),), attained=(), saturated=(), push=(3,), mu=(), command=(3,),
        controller_time=(),
    )  # fmt: skip


def _facts(
    world: World, controller: WalkingController, scenario: WalkScenario, outcome: str, wall: float
) -> dict[str, Any]:
    robot, settings = world.robot, controller.settings
    weight = robot.mass * GRAVITY
    return {
        "kind": "walk",
        "robot": robot.name,
        "mass": robot.mass,
        "dt": world.dt,
        "feet": list(robot.foot_names),
        "joints": list(robot.joint_names),
        "contact_foot": world.contact_foot,
        "contact_centres": np.vstack([foot.centres for foot in robot.feet]),
        "effort_limits": robot.effort_limits,
        "normal_min": settings.normal_min * weight,
        "normal_max": settings.normal_max * weight,
        "mu_controller": settings.mu,
        "gait": getattr(controller.schedule, "name", "schedule"),
        "notes": list(controller.notes),
        "duration": scenario.duration,
        "outcome": outcome,
        "wall_time": wall,
    }
