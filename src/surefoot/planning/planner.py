"""`surefoot.plan`: a robot and a task in, a plan out."""

from __future__ import annotations

from dataclasses import replace

from surefoot.arrays import real_number, whole_number
from surefoot.errors import ProblemError, unknown_name
from surefoot.planning.plan import Plan
from surefoot.planning.tasks.table import TASKS, find_task
from surefoot.planning.tasks.task import Iteration, PlanRequest, Task, Tell
from surefoot.robot import Robot


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
    knots: int | None = None,
    road: str | None = None,
    seed: int = 0,
    max_iterations: int | None = None,
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
    knots
        Number of knots; None for the task's.
    road
        How it is looked for: "schedule" or "direct" for a jump. Each task says which there are; None for
        the recommended one.
    seed
        Of random starts.
    max_iterations
        Of the optimiser; None for the task's.
    tell
        Called with every `Iteration`.

    Returns
    -------
    Plan
        Also where none was found: its status says so. A plan is a log.

    Raises
    ------
    ProblemError
        For an unknown task or road, a number out of range, or a robot that the task is not for.
    MissingExtra
        If what a road needs is not installed.
    """
    found = find_task(task)
    request = _checked(found, PlanRequest(robot, amount, mu, dt, knots, road, seed, max_iterations))
    return found.plan(request, tell or _silent)


def _silent(iteration: Iteration) -> None:
    """Tell nobody."""


def _checked(task: Task, request: PlanRequest) -> PlanRequest:
    """Return a request with its blanks filled in, after checking what does not depend on the task."""
    real_number("mu", request.mu, low=0.0, high=1e6)
    whole_number("seed", request.seed)
    if request.dt is not None:
        real_number("dt", request.dt, low=1e-4, high=1.0)
    if request.knots is not None:
        whole_number("knots", request.knots, low=1)
    if request.max_iterations is not None:
        whole_number("max_iterations", request.max_iterations, low=1)
    if request.road is not None and request.road not in task.roads:
        raise ProblemError(unknown_name(f"road of {task.name}", request.road, task.roads))
    if request.robot is not None and not task.robots:
        raise ProblemError(f"the task {task.name} has a robot of its own: it takes none")
    if request.amount is not None:
        if not task.amount:
            raise ProblemError(f"the task {task.name} takes no number, got {request.amount!r}")
        real_number(task.amount, request.amount, low=-1e3, high=1e3)
    amount = task.default if request.amount is None else request.amount
    return replace(request, amount=amount, road=request.road or task.roads[0])
