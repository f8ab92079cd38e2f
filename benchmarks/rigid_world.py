"""What a simulated second of a standing robot costs: the rigid world against MuJoCo, same controller."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from benchmarks.timing import Timing, one_core
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot, load_robot, place
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.worlds.interface.world_names import make_world

SETTLED = 500
"""Last steps of a run, over which the resting force is judged."""


@dataclass(frozen=True)
class DropResult:
    """One world's drop.

    Attributes
    ----------
    world
        "rigid" or "mujoco".
    wall
        Wall time per simulated second, controller included, over the first second [s].
    step, controller
        Time of one world step and of one controller step.
    contacts
        Largest number of contact points in one step.
    weight_error
        Largest | total normal force / m g - 1 | over the last half second.
    penetration
        Deepest [m].
    energy_made
        Largest energy beyond the start's and the motors' work [J]; NaN where the world does not tell.
    rest_speed
        Largest velocity component at the end [m/s, rad/s].
    """

    world: str
    wall: float
    step: Timing
    controller: Timing
    contacts: int
    weight_error: float
    penetration: float
    energy_made: float
    rest_speed: float


def drop(world: str, robot: str = "go2", height: float = 0.3, seconds: float = 4.0) -> DropResult:
    """Drop a robot with the standing controller active; measure one simulated second, and how it ends."""
    model = load_robot(robot)
    with one_core():
        list(_steps(*_made(world, model, height), 0.3))  # compiles and warms up
        dropped = _made(world, model, height)
        begin = time.perf_counter()
        timed = list(_steps(*dropped, 1.0))
        wall = time.perf_counter() - begin
    made, controller = _made(world, model, height)
    energy = made.energy() if world == "rigid" else np.nan
    normals, deepest, contacts, given, excess = [], 0.0, 0, 0.0, -np.inf
    for step in _steps(made, controller, seconds):
        reading = made.contacts()
        normals.append(reading.forces[:, 2].sum())
        deepest = min(deepest, float(reading.gaps.min()))
        contacts = max(contacts, int((reading.forces[:, 2] > 0.0).sum()))
        given += float(step.torques @ (made.q_v()[0] - step.q)[7:])
        excess = max(excess, made.energy() - energy - given) if world == "rigid" else np.nan
    resting = np.array(normals[-SETTLED:]) / (model.mass * GRAVITY)
    return DropResult(
        world, wall, Timing.of([s.simulation for s in timed]), Timing.of([s.controller for s in timed]),
        contacts, float(np.abs(resting - 1.0).max()), max(0.0, -deepest), float(excess),
        float(np.abs(made.q_v()[1]).max()),
    )  # fmt: skip


class _Step(NamedTuple):
    """One step: q before it, the torques, and the wall times of both parts [s]."""

    q: FloatArray
    torques: FloatArray
    controller: float
    simulation: float


def _made(world: str, robot: Robot, height: float) -> tuple[Any, StandingController]:
    ground, q = FlatTerrain(), place(robot)
    made = make_world(world, robot, ground)
    start = q.copy()
    start[2] += height
    made.reset(start)
    return made, StandingController(robot, StandingPlan(robot, ground, q), ground, q)


def _steps(made: Any, controller: StandingController, seconds: float) -> Iterator[_Step]:
    """Take steps for so long [s] and yield each."""
    clock = time.perf_counter
    for k in range(round(seconds / made.dt)):
        q, v = made.q_v()
        begin = clock()
        torques = controller.step(RobotState(q, v, k * made.dt)).torques
        between = clock()
        made.step(torques)
        yield _Step(q, torques, between - begin, clock() - between)
