"""Contact problems of bodies on bodies, step after step: ours cold and warm, and Pinocchio's best, CPU time.

Everybody pays for the set-up: a problem is made from raw arrays in every call; where many contacts know
their bodies (`sf.contacts_from_mujoco`), one row has it made of their factor, cold. A warm start is the last
step's forces where the contacts are as many as then. Pinocchio runs in all its settings, each with the
loosest of its own tolerances that reaches the wanted error; the quickest that does stands for it. MuJoCo's
own whole step, of a softened problem, is there for scale.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

import surefoot as sf
from benchmarks.contact import rivals
from benchmarks.problems.judge import judge
from benchmarks.problems.stacked_scenes import Scene, Step, steps
from surefoot.base.arrays import FloatArray

PATIENCE = 60.0
"""Seconds that our solver may take for a step."""
REPEATS = 3
"""Timed calls of a rival on a problem; the quickest counts."""


@dataclass(frozen=True)
class SequenceRow:
    """One solver on the steps of one scene.

    Attributes
    ----------
    scene, contacts, solver
        Who on what; the largest number of contacts.
    seconds
        (steps,) CPU time [s] of those that were tried; of those that were solved for a rival.
    errors
        (steps,) velocity error that was reached, by `judge`; infinite where a rival never did.
    """

    scene: str
    contacts: int
    solver: str
    seconds: FloatArray
    errors: FloatArray

    def solved(self, tol: float) -> int:
        """Return how many steps are solved to a tolerance."""
        return int(np.sum(self.errors <= tol))


def race(
    name: str, scene: Scene, count: int, sampled: int, tol: float, progress: Callable[[str], object]
) -> Iterator[SequenceRow]:
    """Yield the rows of a scene of so many steps, of which a few are given to rivals."""
    progress(f"{name}: steps of MuJoCo")
    given = list(steps(scene, count))
    most = max(step.problem.contacts for step in given)
    ways = [("auto, warm", True, False), ("auto, cold", False, False)]
    if all(step.problem.factor is not None for step in given):
        ways.append(("auto, bodies known", False, True))
    for words, warm, known in ways:
        progress(f"{name}: {words}")
        yield SequenceRow(name, most, words, *_ours(given, tol, warm, known))
    if sampled:
        chosen = given[:: max(len(given) // sampled, 1)][:sampled]
        best = []
        for k, step in enumerate(chosen):
            progress(f"{name}: Pinocchio, step {k + 1} of {len(chosen)}")
            best.append(_pinocchio(step.problem, tol))
        seconds, errors = (np.array(part) for part in zip(*best, strict=True))
        yield SequenceRow(name, most, "pinocchio, cold", seconds, errors)
    seconds = np.array([step.mujoco for step in given])
    yield SequenceRow(name, most, "mujoco's step", seconds, np.full(len(given), np.nan))


def _ours(given: Sequence[Step], tol: float, warm: bool, known: bool) -> tuple[FloatArray, FloatArray]:
    """Return CPU seconds and errors of our solver on every step, after calls that compile or load kernels."""
    sf.solve(given[0].problem, "interior_point", tol, max_iterations=3)
    seconds, errors = [], []
    last: FloatArray | None = None
    for turn, step in enumerate((given[0], *given)):
        G, g, mu = step.problem.G, step.problem.g, step.problem.mu
        start_at = last if warm and last is not None and len(last) == len(mu) else None
        start = time.thread_time()
        if known:
            problem = sf.ContactProblem.of_factor(step.problem.factor, g, mu)
        else:
            problem = sf.ContactProblem(G, g, mu)
        found = sf.solve(problem, "auto", tol, warm_start=start_at, max_time=PATIENCE)
        took = time.thread_time() - start
        last = found.forces if turn else None
        if turn:
            seconds.append(took)
            errors.append(judge(step.problem, found.forces))
    return np.array(seconds), np.array(errors)


def _pinocchio(problem: sf.ContactProblem, tol: float) -> tuple[float, float]:
    """Return the least CPU seconds of Pinocchio's settings that reach the error, and that error."""
    plain = sf.ContactProblem(problem.G, problem.g, problem.mu)
    best, least = np.inf, np.inf
    for setting in rivals.settings(plain).values():
        call, error = rivals.best_call(plain, setting, tol)
        least = min(least, error)
        if call is None:
            continue
        item = (rivals.matrix(plain, setting), plain.g)
        for _ in range(REPEATS):
            start = time.thread_time()
            call.fresh(item)
            best = min(best, time.thread_time() - start)
    return best, least
