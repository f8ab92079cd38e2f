"""The direct method: a motion and its contacts found together, softened less and less, made exact in the end.

Posa, Cantu, Tedrake, "A direct method for trajectory optimization of rigid bodies through contact", IJRR 33
(2014): states, torques and contact impulses of all knots are variables of one NLP, and the laws of contact
are among its constraints. No contact is given. Here the step is that of `dynamics.Knot`, so that a
solution is a motion of the exact step. The method:

1. Ipopt on the softened laws, a b <= eps, for eps falling from 1 J to 1e-8 J, each from the last;
2. the modes of all contacts are read off, and Ipopt solves the equations of these modes: nothing is soft;
3. exact steps follow the result (`exact_rollout.follow`). That is the plan, whatever the optimiser said.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.contact import Status
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.plan import Plan, PlanSearch, plan_from
from surefoot.motion.planning.tasks.task import Iteration, Tell
from surefoot.motion.planning.trajectory import Trajectory
from surefoot.motion.planning.transcription.contact_rows import (
    OPEN,
    SLIDE,
    STICK,
    Facets,
    GivenModes,
    read_modes,
)
from surefoot.motion.planning.transcription.direct_problem import DirectProblem
from surefoot.motion.planning.transcription.exact_rollout import follow
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.motion_errors import REACH, departure, exact_cost, window_miss
from surefoot.motion.planning.transcription.nlp import Iterate
from surefoot.motion.planning.transcription.smoothed_complementarity import schedule

SMOOTHINGS = schedule(1.0, 1e-8)
"""Of the continuation [J]."""
MAX_ITERATIONS = 300
"""Of Ipopt, at each smoothing."""
WARM: dict[str, Any] = {
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-8,
    "warm_start_bound_frac": 1e-8,
    "warm_start_slack_bound_push": 1e-8,
    "warm_start_slack_bound_frac": 1e-8,
    "warm_start_mult_bound_push": 1e-8,
}
"""Ipopt's options for the solution of a neighbour, with its multipliers."""
NEAR: dict[str, Any] = {"mu_init": 1e-4, "bound_push": 1e-6, "bound_frac": 1e-6}
"""Those for a motion that obeys the equations but for the softening."""


@dataclass(frozen=True, eq=False)
class DirectPlan:
    """What the direct method found.

    Attributes
    ----------
    plan
        The exact motion; SOLVED or not.
    motion
        The optimiser's last one, which is not exact: a warm start for the next problem.
    trajectory
        Of the plan.
    stages
        Ipopt's runs: the smoothing of each [J] (0 for the equations of the modes), and what came of it.
    departure
        Largest distance of a position or angle of the exact motion from the optimiser's [m, rad].
    miss
        How far outside its windows the exact motion is at worst: [m, rad], or in tenths of m/s.
    """

    plan: Plan
    motion: Guess
    trajectory: Trajectory
    stages: tuple[tuple[float, Iterate], ...]
    departure: float
    miss: float


def plan_direct(
    problem: DirectProblem,
    *,
    guess: Guess | Trajectory | None = None,
    smoothings: Sequence[float] = SMOOTHINGS,
    max_iterations: int = MAX_ITERATIONS,
    total: int | None = None,
    within: float = np.inf,
    task: str = "direct",
    tell: Tell | None = None,
) -> DirectPlan:
    """Return a motion through contact, found by the direct method.

    Parameters
    ----------
    problem
        See `DirectProblem`.
    guess
        What to start from: a motion of any number of knots. None for the straight way to the reference.
    smoothings
        Of the continuation [J], falling. One small value with a good guess is a warm start.
    max_iterations, total
        Of Ipopt, at each smoothing and of all together.
    within
        The exact motion counts only where it is no further than this from the optimiser's [m, rad].
    task
        What the plan is called.
    tell
        Called after each of Ipopt's runs.

    Returns
    -------
    DirectPlan
        Also where nothing was found: `plan.status` says so.

    Raises
    ------
    ProblemError
        For a guess that does not fit.
    MissingExtra
        If CasADi or Pinocchio is not installed.

    Examples
    --------
    >>> from surefoot.motion.planning.direct import DirectProblem, StateWindow, plan_direct, planar_hopper
    >>> hopper = planar_hopper()
    >>> there = hopper.nominal + [0.3, 0.0, 0.0, 0.0, 0.0]
    >>> ahead = DirectProblem(
    ...     hopper, hopper.nominal, np.zeros(5), knots=24, dt=0.03, reference=there,
    ...     end=StateWindow.at(there, np.zeros(5), within=1e-3, speed=1e-2),
    ... )
    >>> found = plan_direct(ahead)
    >>> found.plan.status.value, found.plan.law_residual < 1e-8, len(found.plan.contacts) > 1
    ('almost', True, True)

    Not SOLVED, since the feedback of joints alone, see `certify`, does not balance a body on one point.
    """
    began = time.perf_counter()
    most = whole_number("max_iterations", max_iterations, low=1)
    nlp, stages = DirectNlp(problem, Facets()), _Runs(tell, total)
    found = []
    soft = _soften_less(nlp, nlp.pack(_start(problem, guess)), smoothings, most, stages)
    if soft.finite:
        motion = nlp.unpack(soft.variables)
        found.append(motion)
        if stages.left(most):
            modes = read_modes(motion.impulses, *nlp.contact_speeds(motion), problem.frictions)
            held = DirectNlp(problem, GivenModes())
            found = [*_with_modes(held, motion, modes, stages.left(most), stages, **NEAR), motion]
    return _made_exact(problem, found, (task, "direct"), stages, began, within)


def plan_with_modes(
    problem: DirectProblem,
    modes: IntArray,
    *,
    guess: Guess | Trajectory | None = None,
    max_iterations: int = 3 * MAX_ITERATIONS,
) -> DirectPlan:
    """Return a motion over given modes: no complementarity is left, only equations and bounds.

    Parameters
    ----------
    problem, guess, max_iterations
        See `plan_direct`.
    modes
        (knots, p) of every contact in every knot: 0 open, 1 sticks, 2 slides.

    Raises
    ------
    ProblemError
        For modes or a guess that do not fit.
    """
    began = time.perf_counter()
    wanted, modes = (problem.knots, len(problem.robot.contact_points)), np.asarray(modes, dtype=np.int64)
    if modes.shape != wanted or not np.isin(modes, (OPEN, STICK, SLIDE)).all():
        said = (
            f"got shape {modes.shape}"
            if modes.shape != wanted
            else f"got {sorted(set(modes.ravel().tolist()))}"
        )
        raise ProblemError(f"modes must have shape {wanted}, of 0 (open), 1 (sticks), 2 (slides), {said}")
    stages = _Runs()
    nlp = DirectNlp(problem, GivenModes())
    found = _with_modes(nlp, _start(problem, guess), modes, max_iterations, stages)
    return _made_exact(problem, found, ("direct", "given modes"), stages, began)


class _Runs(list[tuple[float, Iterate]]):
    """Ipopt's runs, reported as they come."""

    def __init__(self, tell: Tell | None = None, total: int | None = None) -> None:
        super().__init__()
        self._tell, self._total = tell, total

    @property
    def iterations(self) -> int:
        """Of all runs."""
        return sum(found.iterations for _, found in self)

    def left(self, most: int) -> int:
        """Return how many iterations the next run may take, `most` unless fewer are left of all."""
        return most if self._total is None else max(min(most, self._total - self.iterations), 0)

    def note(self, smoothing: float, found: Iterate) -> None:
        """Keep a run, and tell of it."""
        self.append((smoothing, found))
        if self._tell is not None:
            what = f"eps {smoothing:g}" if smoothing else "modes"
            self._tell(Iteration(self.iterations, found.cost, max(smoothing, found.violation), what))


def _start(problem: DirectProblem, guess: Guess | Trajectory | None) -> Guess:
    """Return what to start from, on the problem's knots."""
    start = Guess.between(problem) if guess is None else Guess.of(guess, problem)
    return start.checked(problem)


def _soften_less(
    nlp: DirectNlp, start: FloatArray, smoothings: Sequence[float], most: int, stages: _Runs
) -> Iterate:
    """Return what the continuation ends in: every smoothing from the solution of the one before."""
    if not len(smoothings):
        raise ProblemError("a continuation needs at least one smoothing")
    found: Iterate | None = None
    for eps in smoothings:
        if found is not None and not (stages.left(most) and found.finite):
            break
        options: dict[str, Any] = {"max_iter": stages.left(most), "tol": min(1e-6, max(eps, 1e-8))}
        if found is not None:
            options |= {**WARM, "mu_init": min(1e-2, eps)}
        variables, multipliers = (start, None) if found is None else (found.variables, found.multipliers)
        found = nlp.solve(variables, eps, multipliers=multipliers, **options)
        stages.note(eps, found)
    assert found is not None
    return found


def _with_modes(
    nlp: DirectNlp, motion: Guess, modes: IntArray, most: int, stages: _Runs, **start: Any
) -> list[Guess]:
    """Return the motion that obeys the equations of modes (N, p), from one that need not; none if lost."""
    law, mu = GivenModes(), nlp.problem.frictions
    found = nlp.solve(
        nlp.pack(motion), 0.0, contact_bounds=law.bounds(modes, mu),
        row_bounds=law.row_bounds(modes, mu),
        max_iter=most, tol=1e-9, bound_relax_factor=0.0, **start,
    )  # fmt: skip
    stages.note(0.0, found)
    return [nlp.unpack(found.variables)] if found.finite else []


def _made_exact(
    problem: DirectProblem,
    found: Sequence[Guess],
    names: tuple[str, str],
    stages: _Runs,
    began: float,
    within: float = np.inf,
) -> DirectPlan:
    """Return the plan of the motion whose exact one comes nearest to the goal, the first if both arrive."""
    best: tuple[float, Guess, Trajectory] | None = None
    for candidate in found:
        trajectory = follow(problem, candidate)
        miss = window_miss(problem, trajectory)
        if best is None or (miss < best[0] and best[0] > REACH):
            best = miss, candidate, trajectory
    if best is None:  # Ipopt met an error: nothing but to stay
        motion = _start(problem, None)
        trajectory = follow(problem, motion, feedback=False)
        best = window_miss(problem, trajectory), motion, trajectory
    miss, motion, trajectory = best
    off = departure(problem.robot, motion, trajectory)
    cost, reached = exact_cost(problem, trajectory), miss <= REACH and off <= within
    goal = f"ends {miss:.2g} outside its windows (allowed {REACH:g}), {off:.1e} from the optimiser's motion"
    spent = time.perf_counter() - began
    stopped = Status.STALLED if stages.left(MAX_ITERATIONS) else Status.MAX_ITERATIONS
    search = PlanSearch(*names, cost, reached, stages.iterations, spent, goal, stopped)
    touches = trajectory.touch_impulses
    facts = {} if touches is None else {"touch_impulses": touches}
    return DirectPlan(
        plan_from(trajectory, problem.robot, search, problem.terrain, problem, **facts), motion, trajectory,
        tuple(stages), off, miss,
    )  # fmt: skip
