"""What a simulated second of a standing robot costs: the rigid world against MuJoCo, same controller."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.timing import Timing, one_core
from surefoot.arrays import FloatArray
from surefoot.control.controller import RobotState
from surefoot.control.standing import StandingController
from surefoot.control.standing_plan import StandingPlan
from surefoot.robot import Robot, load_robot, place
from surefoot.simulation.worlds import make_world
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain

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
    q = place(model)
    with one_core():
        _timed(world, model, q, height, 0.3)  # compiles and warms up
        wall = _timed(world, model, q, height, 1.0)
    return _watched(world, model, q, height, seconds, wall)


def _made(world: str, robot: Robot, q: FloatArray, height: float) -> tuple[Any, StandingController]:
    ground = FlatTerrain()
    made = make_world(world, robot, ground)
    start = q.copy()
    start[2] += height
    made.reset(start)
    return made, StandingController(robot, StandingPlan(robot, ground, q), ground, q)


def _timed(
    world: str, robot: Robot, q: FloatArray, height: float, seconds: float
) -> tuple[float, list[float], list[float]]:
    """Return the wall time of a bare loop, and the times of its single steps [s]."""
    made, controller = _made(world, robot, q, height)
    steps: list[float] = []
    commands: list[float] = []
    clock = time.perf_counter
    begin = clock()
    for k in range(round(seconds / made.dt)):
        a = clock()
        command = controller.step(RobotState(made.state()[0], made.state()[1], k * made.dt))
        b = clock()
        made.step(command.torques)
        steps.append(clock() - b)
        commands.append(b - a)
    return clock() - begin, steps, commands


def _watched(
    world: str,
    robot: Robot,
    q: FloatArray,
    height: float,
    seconds: float,
    timed: tuple[float, list[float], list[float]],
) -> DropResult:
    """Run again with everything recorded."""
    made, controller = _made(world, robot, q, height)
    normals, deepest, contacts, given, excess = [], 0.0, 0, 0.0, -np.inf
    rigid = world == "rigid"
    begin = made.energy() if rigid else np.nan
    for k in range(round(seconds / made.dt)):
        state, v = made.state()
        torques = controller.step(RobotState(state, v, k * made.dt)).torques
        made.step(torques)
        reading, moved = made.contacts(), made.state()[0]
        normals.append(reading.forces[:, 2].sum())
        deepest = min(deepest, float(reading.gaps.min()))
        contacts = max(contacts, int((reading.forces[:, 2] > 0.0).sum()))
        if rigid:
            given += float(torques @ (moved - state)[7:])
            excess = max(excess, made.energy() - begin - given)
    resting = np.array(normals[-SETTLED:]) / (robot.mass * GRAVITY)
    return DropResult(
        world,
        timed[0],
        Timing.of(timed[1]),
        Timing.of(timed[2]),
        contacts,
        float(np.abs(resting - 1.0).max()),
        max(0.0, -deepest),
        float(excess) if rigid else np.nan,
        float(np.abs(made.state()[1]).max()),
    )
