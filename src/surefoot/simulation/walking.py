"""Run a walking robot in a world: pushes, ice and faults, logged step by step."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.walking import WalkCommand, WalkingController
from surefoot.simulation.faults import Faults
from surefoot.simulation.log import Log
from surefoot.simulation.run import Scenario, finish, recorder_of, run_steps, start_velocity
from surefoot.simulation.world import ContactReading, World
from surefoot.spatial import GRAVITY, rotation_from_quaternion

TOUCH = 0.02
"""A foot feels the ground when its normal force exceeds this share of m g."""
LOWEST, STEEPEST = 0.4, math.radians(60.0)
"""The robot has fallen when its base is below this share of its height over the ground, or tilts this far."""
AT_LIMIT = 1.0 - 1e-6
"""A torque is saturated from this share of its limit on."""


@dataclass(frozen=True)
class WalkScenario(Scenario):
    """What happens to the robot; see `surefoot.simulation.run.Scenario`.

    Attributes
    ----------
    faults
        What is wrong with sensors and motors; None for nothing.
    """

    faults: Faults | None = None


def run_walking(
    world: World,
    controller: WalkingController,
    q: FloatArray,
    scenario: WalkScenario,
    progress: Callable[[float], None] | None = None,
    folder: Path | None = None,
) -> Log:
    """Run the controller in the world and return the log, also when interrupted or fallen.

    The log's fact ``outcome`` is that of `surefoot.simulation.run.Ended`. `progress` is called with the
    simulated time about every 20 ms of it. The rows go to the new `folder` as they come, and what a killed
    run leaves there `surefoot.simulation.log.read_log` reads; without one, only a long log goes to disk.
    """
    world.reset(q, start_velocity(world.robot, scenario.seed))
    settings, weight = controller.settings, world.robot.mass * GRAVITY
    facts = {
        "kind": "walk",
        "normal_min": settings.normal_min * weight,
        "normal_max": settings.normal_max * weight,
        "mu_controller": settings.mu,
        "gait": getattr(controller.schedule, "name", "schedule"),
    }
    feet = len(world.robot.feet)
    recorder = recorder_of(world, scenario, folder, facts, planned=(feet,), command=(3,))
    faults = (scenario.faults or Faults()).start(world, scenario.seed)
    height = float(q[2] - world.terrain.height(q[:2]))
    last: list[WalkCommand] = []

    def control(
        now: float, state: FloatArray, velocity: FloatArray, reading: ContactReading
    ) -> tuple[FloatArray, float]:
        seen, moving = faults.sense(state, velocity)
        start = clock.perf_counter()
        command = controller.step(seen, moving, _felt(world, reading), now)
        spent = clock.perf_counter() - start
        last[:] = [command]
        return faults.act(command.whole_body.torques), spent

    ended = run_steps(
        world, scenario, recorder, control, lambda rows, k: _note(rows, k, last[0], controller),
        lambda state: _fallen(world, state, height), progress,
    )  # fmt: skip
    return finish(recorder, ended, notes=list(controller.notes))


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


def _note(rows: dict[str, Any], k: int, command: WalkCommand, controller: WalkingController) -> None:
    """Write the controller's rows of one step."""
    whole = command.whole_body
    rows["forces_commanded"][k] = whole.forces
    rows["active"][k] = command.carrying[controller.whole_body.point_foot]
    rows["planned"][k], rows["command"][k] = command.planned, command.wanted
    rows["attained"][k] = whole.feasible
    rows["saturated"][k] = (np.abs(whole.torques) >= AT_LIMIT * controller.whole_body.limits).any()
