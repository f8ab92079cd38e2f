"""What a task is: a goal for a robot, and the ways to look for a plan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.planning.plan import Plan


@dataclass(frozen=True)
class Iteration:
    """What a search tells of itself on the way.

    Attributes
    ----------
    number
        Of the iteration, from 1.
    cost
        Of the current candidate.
    law_residual
        How far it is from the laws, in the method's own measure.
    note
        What the search does: a stage of a continuation, say.
    """

    number: int
    cost: float
    law_residual: float
    note: str = ""


Tell = Callable[[Iteration], None]
"""Who hears of every iteration."""


@dataclass(frozen=True)
class PlanRequest:
    """What a task is asked for; None leaves it to the task.

    Attributes
    ----------
    robot
        Who moves; None for the task's own (a ball, a block, a hopper) or Go2.
    amount
        The task's number: a height or distance [m], a speed [m/s].
    mu
        Friction of the ground.
    dt
        Length of a knot [s].
    seed
        Of random starts.
    max_iterations
        Of the optimiser.
    start, payload, direction, turn, terrain, over, near
        See `surefoot.plan`; angles in radians.
    """

    robot: Robot | None = None
    amount: float | None = None
    mu: float = 0.6
    dt: float | None = None
    seed: int = 0
    max_iterations: int | None = None
    start: FloatArray | None = None
    payload: float = 0.0
    direction: float = 0.0
    turn: float = 0.0
    terrain: Terrain | None = None
    over: float = 0.0
    near: Plan | None = None


class Task(Protocol):
    """A goal that can be planned for.

    Attributes
    ----------
    name
        For people.
    amount
        What the request's number is, with its unit; empty where there is none.
    default
        The number where none is given.
    robots
        Whether a robot of the catalogue can be given; else the task has its own.
    takes
        Which of start, payload, direction, turn, terrain, over and near can be given.
    """

    name: str
    amount: str
    default: float | None
    robots: bool
    takes: tuple[str, ...]

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan for a request whose blanks are filled in; `tell` hears of every iteration.

        A task that cannot be done returns a plan that is not SOLVED, and says why in its fact ``goal``; a
        `KeyboardInterrupt` during the search returns the best so far.

        Raises
        ------
        ProblemError
            For a robot or an amount that the task is not for.
        """
        ...
