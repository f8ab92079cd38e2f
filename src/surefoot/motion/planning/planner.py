"""`surefoot.plan`: a robot and a task in, a plan out."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.mechanics import FlatTerrain, Robot, Terrain, load_robot
from surefoot.motion.planning.plan import Plan
from surefoot.motion.planning.tasks.task import PlanRequest, Task, Tell
from surefoot.motion.planning.tasks.task_names import TASKS, find_task

ON_GROUND = 2e-3
"""How far from the ground feet may be at the start [m]."""
RANGES = {"payload": (0.0, 1e3), "direction": (-pi, pi), "turn": (-pi, pi), "over": (0.0, 1e2)}
"""Least and largest values [kg, rad, rad, m]."""


def task_names() -> tuple[str, ...]:
    """Return the names of the tasks that can be planned."""
    return tuple(TASKS)


def plan(
    robot: Robot | None,
    task: str,
    amount: float | None = None,
    *,
    mu: float = 0.6,
    dt: float | None = None,
    seed: int = 0,
    max_iterations: int | None = None,
    start: ArrayLike | None = None,
    payload: float = 0.0,
    direction: float = 0.0,
    turn: float = 0.0,
    terrain: Terrain | None = None,
    over: float = 0.0,
    near: Plan | None = None,
    tell: Tell | None = None,
) -> Plan:
    """Return a motion through contact that does a task.

    Parameters
    ----------
    robot
        Who moves; None for the task's own.
    task
        One of `task_names()`.
    amount
        The task's number, a distance or height [m] or a speed [m/s]; None for the task's default.
    mu
        Friction of the ground [-].
    dt
        Length of a knot [s]; None for the task's.
    seed
        Of random starts.
    max_iterations
        Of the optimiser; None for the task's.
    start
        (nq,) the configuration to start from, at rest on the ground [m, -, rad]; None for the nominal pose. A
        jump ends as it starts.
    payload
        Mass on the base that the plan knows of [kg].
    direction, turn
        Of a jump: where to, from straight ahead to the left, and by how much the robot turns to the left on
        the way [rad].
    terrain
        Of a jump: a plane, or level ground in steps along x (stairs, a ditch) that it lands on or beyond;
        None for flat ground.
    over
        Of a jump: width of a gap in flat ground ahead, along x, that neither feet nor links may go into [m];
        a jump without an amount is as long as that takes.
    near
        A plan over a schedule for the same task, robot and number of knots: the search starts from its motion
        and multipliers. What is found is judged all the same; a start that is near costs half the time.
    tell
        Called with every `Iteration`.

    Returns
    -------
    Plan
        Also where none was found: its status says so. A plan is a log.

    Raises
    ------
    ProblemError
        For an unknown task, a number out of range, or a robot that the task is not for.
    MissingExtra
        If what its search needs is not installed.
    """
    found = find_task(task)
    request = PlanRequest(robot, amount, mu, dt, seed, max_iterations)
    _check(found, request)
    asked = {
        "start": start, "payload": payload, "direction": direction, "turn": turn, "terrain": terrain,
        "over": over, "near": near,
    }  # fmt: skip
    request = replace(request, **_checked_extra(found, request, asked))
    if request.amount is None and not request.over:
        request = replace(request, amount=found.default)
    return found.plan(request, tell or (lambda iteration: None))


def _checked_extra(task: Task, request: PlanRequest, extra: dict[str, Any]) -> dict[str, Any]:
    """Return what a task is asked for beside its number, checked."""
    for name, (low, high) in RANGES.items():
        extra[name] = real_number(name, extra[name], low=low, high=high)
    if extra["near"] is not None:
        of_kind("near", extra["near"], Plan)
    for name, value in extra.items():
        if value is not None and not np.array_equal(value, 0.0) and name not in task.takes:
            takes = ", ".join(task.takes) or "none of these"
            raise ProblemError(f"the task {task.name} takes no {name}; it takes {takes}")
    ground = extra["terrain"] or FlatTerrain()
    of_kind("terrain", ground, Terrain)
    if extra["over"] and extra["terrain"] is not None:
        raise ProblemError(f"over and terrain both say what the ground is: give one, got {ground!r} as well")
    if extra["start"] is not None:
        extra["start"] = _checked_start(request.robot or load_robot("go2"), extra["start"], ground)
    return extra


def _checked_start(robot: Robot, start: ArrayLike, ground: Terrain) -> FloatArray:
    """Return a configuration (nq,) that stands on the ground."""
    q = robot.configuration(finite_array("start", start, (robot.model.nq,)))
    gaps = ground.gap(robot.foot_positions(q)) - robot.contact_points.foot_radii
    worst = int(np.abs(gaps).argmax())
    if abs(gaps[worst]) > ON_GROUND:
        where = f"{abs(gaps[worst]):.3g} m {'off' if gaps[worst] > 0.0 else 'in'} it"
        raise ProblemError(f"start must stand on the ground, {robot.foot_names[worst]} is {where}")
    return q


def _check(task: Task, request: PlanRequest) -> None:
    """Refuse what no task, or this one, can be asked."""
    real_number("mu", request.mu, low=0.0, high=1e6)
    whole_number("seed", request.seed)
    if request.dt is not None:
        real_number("dt", request.dt, low=1e-4, high=1.0)
    if request.max_iterations is not None:
        whole_number("max_iterations", request.max_iterations, low=1)
    if request.robot is not None:
        of_kind("robot", request.robot, Robot)
        if not task.robots:
            raise ProblemError(f"the task {task.name} has a robot of its own: it takes none")
        if not request.robot.floating:
            raise ProblemError(f"the task {task.name} moves a free base: {request.robot.name} is bolted down")
    if request.amount is not None:
        if not task.amount:
            raise ProblemError(f"the task {task.name} takes no number, got {request.amount!r}")
        real_number(task.amount, request.amount, low=-1e3, high=1e3)
