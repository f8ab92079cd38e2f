"""Run a standing robot in a world: pushes, ice, payload and lifted feet, logged step by step."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.standing import Command, StandingController
from surefoot.simulation.log import Log
from surefoot.simulation.run import Scenario, finish, recorder_of, run_steps, start_velocity
from surefoot.simulation.world import ContactReading, World
from surefoot.spatial import rotation_from_quaternion

FALL_HEIGHT = 0.5
"""The robot has fallen when its base is below this share of its starting height ..."""
FALL_TILT = np.radians(50.0)
"""... or tilts this far from its starting orientation [rad]."""
START_DEPTH = 1e-5
"""The robot starts this deep in the ground, so that rounding leaves no foot in the air [m]."""


def run_standing(
    world: World,
    controller: StandingController,
    q: FloatArray,
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    folder: Path | None = None,
) -> Log:
    """Run the controller in the world and return the log, also when interrupted or fallen.

    The log's fact ``outcome`` is that of `surefoot.simulation.run.Ended`. `progress` is called with the
    simulated time about every 20 ms of it. The rows go to the new `folder` as they come, and what a killed
    run leaves there `surefoot.simulation.log.read_log` reads; without one, only a long log goes to disk.
    """
    _warm_up(world, controller, q)
    q = q.copy()
    q[:3] -= START_DEPTH * world.terrain.normal(q[:2])
    world.reset(q, start_velocity(world.robot, scenario.seed))
    p = len(world.contact_foot)
    facts = {
        "normal_min": controller.normal_min,
        "normal_max": controller.normal_max,
        "mu_controller": controller.mu,
    }
    recorder = recorder_of(
        world, scenario, folder, facts, wrench_desired=(6,), wrench_error=(6,), grasp_map=(6, 3 * p)
    )
    up = rotation_from_quaternion(q[3:7])
    last: list[Command] = []

    def control(
        now: float, state: FloatArray, velocity: FloatArray, reading: ContactReading
    ) -> tuple[FloatArray, float]:
        start = clock.perf_counter()
        command = controller.step(state, velocity, now)
        last[:] = [command]
        return command.torques, clock.perf_counter() - start

    ended = run_steps(
        world, scenario, recorder, control, lambda rows, k: _note(rows, k, last[0]),
        lambda state: fallen(state, q, up), progress,
    )  # fmt: skip
    return finish(recorder, ended)


def _warm_up(world: World, controller: StandingController, q: FloatArray) -> None:
    """Compile or load every kernel of the loop, so that times are of the steps alone."""
    world.reset(q)
    state, velocity = world.state()
    for time in (0.0, *(0.5 * (lift.start + lift.end) for lift in controller.plan.lifts)):
        world.step(controller.step(state, velocity, time).torques)
    world.contacts()
    controller.reset()


def fallen(q: FloatArray, start: FloatArray, rotation: FloatArray) -> str | None:
    """Return "fell" or "invalid" when the state says so, else None."""
    if not np.isfinite(q).all():
        return "invalid"
    # the cosine of the turn since the start, from the trace
    turn = 0.5 * (float(np.trace(rotation.T @ rotation_from_quaternion(q[3:7]))) - 1.0)
    if turn < np.cos(FALL_TILT) or q[2] - start[2] < -FALL_HEIGHT * abs(start[2]):
        return "fell"
    return None


def _note(rows: dict[str, Any], k: int, command: Command) -> None:
    """Write the controller's rows of one step."""
    rows["forces_commanded"][k] = command.forces
    rows["wrench_desired"][k], rows["wrench_error"][k] = command.wrench_desired, command.wrench_error
    rows["grasp_map"][k], rows["active"][k] = command.grasp_map, command.active
    rows["attained"][k], rows["saturated"][k] = command.attained, command.saturated
