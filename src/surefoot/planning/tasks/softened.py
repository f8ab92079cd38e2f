"""What the tasks have in common whose plans come from a softened small problem."""

from __future__ import annotations

import time

from surefoot.errors import ProblemError
from surefoot.planning.plan import Search
from surefoot.planning.tasks.task import Iteration, Request, Tell
from surefoot.planning.transcription.continuation import Answer, Settings, Stage, follow
from surefoot.planning.transcription.forms import FORMS, RECOMMENDED, form_named, schedule
from surefoot.planning.transcription.problem import SmallProblem
from surefoot.planning.transcription.program import transcribe

METHODS = (RECOMMENDED, *(name for name in FORMS if name != RECOMMENDED))
"""The forms, the recommended first."""
SMOOTHINGS = schedule(0.1, 1e-8)
"""Of the search; a last stage with the modes held makes the answer exact."""


def search(problem: SmallProblem, request: Request, tell: Tell) -> tuple[Answer, float]:
    """Return what a request's method makes of a random start, and the wall time [s]."""
    begun, count = time.perf_counter(), 0
    program = transcribe(problem, form_named(request.method or RECOMMENDED))

    def heard(stage: Stage) -> None:
        nonlocal count
        count += stage.iterations
        note = f"a b <= {stage.eps:.0e}" if stage.eps else "modes held"
        tell(Iteration(max(1, count), stage.outcome.cost, stage.outcome.complementarity, note))

    settings = Settings() if request.max_iterations is None else Settings(total=request.max_iterations)
    answer = follow(program, problem.guess(request.seed), SMOOTHINGS, settings, polished=True, tell=heard)
    return answer, time.perf_counter() - begun


def told(request: Request, task: str, found: tuple[Answer, float], reached: bool, goal: str) -> Search:
    """Return how a plan was found."""
    answer, seconds = found
    cost = answer.outcome.cost
    method = request.method or RECOMMENDED
    return Search(task, method, cost, reached, answer.iterations, seconds, goal)


def within(request: Request, task: str, unit: str, low: float, high: float) -> float:
    """Return a request's number.

    Raises
    ------
    ProblemError
        If it is outside of what the task is for.
    """
    amount = request.amount
    if amount is None or not low <= amount <= high:
        raise ProblemError(f"{task} takes a number from {low:g} to {high:g} {unit}, got {amount!r}")
    return amount
