"""The direct method: a motion and its contacts found together, softened less and less, and made exact in the end.

Posa, Cantu, Tedrake, "A direct method for trajectory optimization of rigid bodies through contact", IJRR 33
(2014): states, torques and contact impulses of all knots are variables of one NLP, and the laws of contact are
among its constraints. No contact is given. Here the step is that of `surefoot.stepping.Knot`, so that a solution
is a motion of the exact step. The road:

1. Ipopt on the softened laws, a b <= eps, for eps falling from 1 J to 1e-8 J, each from the last;
2. the modes of all contacts are read off, and Ipopt solves the equations of these modes: nothing is soft;
3. exact steps follow the result (`follow`). That is the plan, whatever the optimiser said.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, whole_number
from surefoot.contact import Status
from surefoot.planning.direct.contact_rows import ContactLaw, Facets, GivenModes, RoundCone, read_modes
from surefoot.planning.direct.follow import follow
from surefoot.planning.direct.guess import Guess
from surefoot.planning.direct.problem import DirectProblem
from surefoot.planning.direct.search import DirectSearch, Iterate
from surefoot.planning.plan import Plan, Search, plan_from
from surefoot.planning.tasks.task import Iteration, Tell
from surefoot.planning.trajectory import Trajectory
from surefoot.planning.transcription.forms import schedule

SMOOTHINGS = schedule(1.0, 1e-8)
"""Of the continuation [J]."""
MAX_ITERATIONS = 300
"""Of Ipopt, at each smoothing."""
REACH = 1e-3
"""How far the exact motion may end outside a window that it was to reach [m, rad, and in ten times as many m/s]."""
WARM: dict[str, Any] = {
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-8,
    "warm_start_bound_frac": 1e-8,
    "warm_start_slack_bound_push": 1e-8,
    "warm_start_slack_bound_frac": 1e-8,
    "warm_start_mult_bound_push": 1e-8,
}
"""Ipopt's options for a start that is near already."""


@dataclass(frozen=True, eq=False)
class Stage:
    """One of Ipopt's runs: its smoothing [J] (0 for the equations of the modes), and what came of it."""

    smoothing: float
    iterations: int
    cost: float
    violation: float
    said: str


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
        Ipopt's runs.
    departure
        Largest distance of a position or angle of the exact motion from the optimiser's [m, rad].
    open_departure
        That of its torques alone, without feedback: how far errors grow.
    products
        Largest |min(φ dt, λ_n)| of the optimiser's motion [m or N s]: how far from complementary it is.
    miss
        How far outside its windows the exact motion is at worst: [m, rad], or in tenths of m/s.
    """

    plan: Plan
    motion: Guess
    trajectory: Trajectory
    stages: tuple[Stage, ...]
    departure: float
    open_departure: float
    products: float
    miss: float


def plan_direct(
    problem: DirectProblem,
    *,
    law: ContactLaw | None = None,
    guess: Guess | Trajectory | None = None,
    smoothings: Sequence[float] = SMOOTHINGS,
    max_iterations: int = MAX_ITERATIONS,
    task: str = "direct",
    tell: Tell | None = None,
) -> DirectPlan:
    """Return a motion through contact, found by the direct method.

    Parameters
    ----------
    problem
        See `DirectProblem`.
    law
        How the laws are written: `Facets` or `RoundCone`; None for Facets(2) in the plane and RoundCone() in
        space.
    guess
        What to start from: a motion of any number of knots. None for the straight way to the reference.
    smoothings
        Of the continuation [J], falling. One small value with a good guess is a warm start.
    max_iterations
        Of Ipopt, at each smoothing.
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
    >>> from surefoot.planning.direct import DirectProblem, Window, plan_direct, planar_hopper
    >>> hopper = planar_hopper()
    >>> there = hopper.nominal + [0.3, 0.0, 0.0, 0.0, 0.0]
    >>> ahead = DirectProblem(
    ...     hopper, hopper.nominal, np.zeros(5), knots=24, dt=0.03, reference=there,
    ...     end=Window.at(there, np.zeros(5), within=1e-3, speed=1e-2),
    ... )
    >>> found = plan_direct(ahead)
    >>> found.plan.status.value, found.plan.law_residual < 1e-8, len(found.plan.contacts) > 1
    ('solved', True, True)
    """
    began = time.perf_counter()
    whole_number("max_iterations", max_iterations, low=1)
    law = (Facets(2) if problem.planar else RoundCone()) if law is None else law
    start = Guess.between(problem) if guess is None else Guess.of(guess, problem)
    search = DirectSearch(problem, law)
    stages = list[Stage]()

    def note(smoothing: float, found: Iterate) -> None:
        stages.append(Stage(smoothing, found.iterations, found.cost, found.violation, found.said))
        if tell is not None:
            total = sum(s.iterations for s in stages)
            what = f"eps {smoothing:g}" if smoothing else "modes"
            tell(Iteration(total, found.cost, max(smoothing, found.violation), what))

    soft = _soften_less(search, search.pack(start.checked(problem)), smoothings, max_iterations, note)
    hard = _with_modes(problem, soft.guess, *search.seen(soft.guess), max_iterations)
    note(0.0, hard)
    motion, trajectory = _better(problem, [g for g in (hard, soft) if np.isfinite(g.variables).all()])
    products = np.minimum(search.seen(motion)[0] * problem.dt, motion.impulses[..., 2])
    open_loop = follow(problem, motion, feedback=False)
    miss = window_miss(problem, trajectory)
    return DirectPlan(
        _plan(problem, trajectory, task, stages, miss, time.perf_counter() - began),
        motion, trajectory, tuple(stages), departure(problem, motion, trajectory),
        departure(problem, motion, open_loop), float(np.abs(products).max(initial=0.0)), miss,
    )  # fmt: skip


def _soften_less(
    search: DirectSearch, start: FloatArray, smoothings: Sequence[float], most: int, note: Any
) -> Iterate:
    """Return what the continuation ends in: every smoothing from the solution of the one before."""
    found: Iterate | None = None
    for eps in smoothings:
        options = {"max_iter": most, "tol": min(1e-6, max(eps, 1e-8))}
        if found is not None:
            options |= {**WARM, "mu_init": min(1e-2, eps)}
        variables, multipliers = (start, None) if found is None else (found.variables, found.multipliers)
        found = search.solve(variables, eps, multipliers=multipliers, **options)
        note(eps, found)
    assert found is not None
    return found


def _with_modes(
    problem: DirectProblem, motion: Guess, closing: FloatArray, sliding: FloatArray, most: int
) -> Iterate:
    """Return the motion that obeys the equations of the modes that a softened one is in."""
    law = GivenModes()
    modes = read_modes(motion.impulses, closing, sliding, problem.mu)
    search, d = DirectSearch(problem, law), problem.tangents - 1
    return search.solve(
        search.pack(motion), 0.0, contact_bounds=law.bounds(modes, d), row_bounds=law.row_bounds(modes, d),
        max_iter=most, tol=1e-9, mu_init=1e-4, bound_relax_factor=0.0, bound_push=1e-6, bound_frac=1e-6,
    )  # fmt: skip


def _better(problem: DirectProblem, candidates: Sequence[Iterate]) -> tuple[Guess, Trajectory]:
    """Return the motion whose exact one reaches more, and that; the first where both do."""
    best = None
    for candidate in candidates:
        trajectory = follow(problem, candidate.guess)
        miss = window_miss(problem, trajectory)
        if best is None or (miss < best[0] and best[0] > REACH):
            best = miss, candidate.guess, trajectory
    assert best is not None
    return best[1], best[2]


def window_miss(problem: DirectProblem, trajectory: Trajectory) -> float:
    """Return how far a trajectory is outside the windows of a problem: [m, rad], velocities in tenths of m/s."""
    nq, nv = trajectory.q.shape[1], trajectory.v.shape[1]
    worst = 0.0
    scale = np.concatenate([np.ones(nq), np.full(nv, 0.1)])
    for k, window in [*problem.windows.items(), (problem.knots, problem.end)]:
        state = np.concatenate([trajectory.q[k], trajectory.v[k]])
        sides = [(window.q_low, window.v_low, 1.0), (window.q_high, window.v_high, -1.0)]
        for q, v, sign in sides:
            free = -sign * np.inf
            edge = np.concatenate([np.full(nq, free) if q is None else q, np.full(nv, free) if v is None else v])
            beyond = scale * sign * (edge - state)
            if not np.isfinite(state).all():
                return np.inf
            worst = max(worst, float(beyond.max()))
    return worst


def departure(problem: DirectProblem, motion: Guess, trajectory: Trajectory) -> float:
    """Return the largest entry of q ⊖ q between a motion and a trajectory [m, rad]; infinite where it is lost."""
    import pinocchio

    if not np.isfinite(trajectory.q).all():
        return np.inf
    model = problem.robot.model
    pairs = zip(motion.q, trajectory.q, strict=True)
    return max(float(np.abs(pinocchio.difference(model, a, b)).max()) for a, b in pairs)


def _plan(
    problem: DirectProblem, trajectory: Trajectory, task: str, stages: Sequence[Stage], miss: float, seconds: float
) -> Plan:
    """Return the plan of a trajectory."""
    iterations = sum(s.iterations for s in stages)
    goal = f"ends {miss:.2g} outside its windows (allowed {REACH:g})"
    search = Search(
        task, "direct", exact_cost(problem, trajectory), miss <= REACH, iterations, seconds, goal, Status.STALLED
    )
    return plan_from(trajectory, problem.robot, search, problem.terrain)


def exact_cost(problem: DirectProblem, trajectory: Trajectory) -> float:
    """Return the cost of a trajectory under a problem's weights."""
    w, dt, t = problem.weights, problem.dt, trajectory
    off, change = t.q[1:] - problem.references[1:], np.diff(t.v, axis=0)
    running = w.torque * np.sum(t.torques**2) + w.velocity * np.sum(t.v[1:] ** 2) + w.posture * np.sum(off**2)
    end = np.sum(off[-1] ** 2) + np.sum(t.v[-1] ** 2)
    return float(dt * running + w.change / dt * np.sum(change**2) + w.end * end)
