"""Small tasks for the direct method: a ball, a hopper and a push, whose contacts nobody gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.motion.planning.direct.direct_planner import plan_direct
from surefoot.motion.planning.direct.textbook import SmallProblem, falling_ball, hopper, pushed_block
from surefoot.motion.planning.plan import Plan
from surefoot.motion.planning.tasks.task import PlanRequest, Tell

QUIET = 1e-2
"""Weight of the hopper's changes of velocity, see `Weights.change`: without any a replay at a tenth of the
step ends 14 to 53 cm off, with it 1 to 2 cm, at four feedback gains."""
SAME = 1e-6
"""A motion that nothing drives is found if exact steps are nowhere further from it [m]."""


@dataclass(frozen=True)
class SmallTask:
    """A task with a robot of its own; its number is from `low` to `high`.

    Attributes
    ----------
    make
        Number, friction, number of knots and their length [s] to the problem.
    knots, dt
        Those of the task: a number, or what makes it of the task's number and dt.
    within
        How far the exact motion may be from the optimiser's [m, rad].
    """

    name: str
    amount: str
    default: float | None
    low: float
    high: float
    make: Callable[[float, float, int, float], SmallProblem]
    knots: Callable[[float, float], int]
    dt: float
    within: float = np.inf
    robots: bool = False
    takes: tuple[str, ...] = ()

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan; see `Task`."""
        amount = self.default if request.amount is None else request.amount
        if amount is None or not self.low <= amount <= self.high:
            raise ProblemError(
                f"{self.name} takes a number from {self.low:g} to {self.high:g}, its {self.amount}, got "
                f"{amount!r}"
            )
        dt = request.dt or self.dt
        small = self.make(amount, request.mu, self.knots(amount, dt), dt)
        return plan_direct(
            small.problem, guess=small.guess(request.seed), total=request.max_iterations, within=self.within,
            task=self.name, tell=tell,
        ).plan  # fmt: skip


BALL = SmallTask(
    "ball", "height of the fall [m]", 1.0, 0.0, 3.0,
    lambda height, mu, knots, dt: falling_ball(height, knots=knots, dt=dt),
    lambda height, dt: max(10, round((np.sqrt(2.0 * height / 9.81) + 0.5) / dt)), 0.02, SAME,
)  # fmt: skip


def quiet_hopper(distance: float, mu: float, knots: int, dt: float) -> SmallProblem:
    """Return the textbook's hopper with a price on changes of velocity, whose plans can be replayed."""
    small = hopper(distance, mu, knots, dt)
    problem = small.problem
    return replace(small, problem=replace(problem, weights=replace(problem.weights, change=QUIET)))


HOPPER = SmallTask(
    "hopper", "distance [m]", 0.3, -1.0, 1.0, quiet_hopper,
    lambda distance, dt: max(10, round(0.9 / dt)), 0.02,
)  # fmt: skip
PUSH = SmallTask(
    "push", "distance [m]", 0.3, 0.0, 1.0, pushed_block,
    lambda distance, dt: 25, 0.04,
)  # fmt: skip
