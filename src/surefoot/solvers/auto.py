"""The default solver: it chooses, combines and keeps to its time.

Small problems (up to 40 contacts): one compiled call that alternates bursts of Gauss-Seidel sweeps, which find
out who sticks, slides or takes off, with Newton steps, which finish. Larger ones: the same alternation on
3x3 blocks with a sparse factorisation. Whatever these leave unsolved is handed, best forces first, to ADMM
(degenerate problems) until the time is up. The status is that of the best forces found.
"""

from __future__ import annotations

import math
import time

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.solvers.newton import run_dense
from surefoot.solvers.newton_sparse import newton_sparse
from surefoot.solvers.nsgs import prepare_blocks, run_blocks
from surefoot.solvers.solver import Answer, Settings, register, start_forces

SMALL = 40
"""Number of contacts up to which the compiled dense alternation is used."""
ROUNDS = 8


@register("auto", bilateral=True)
def solve_auto(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law, exact or on pyramids; an iteration is a sweep or a Newton step."""
    forces = start_forces(problem, warm_start)
    if problem.contacts <= SMALL:
        norm = problem.norm
        sweeps, steps, relative = run_dense(
            problem.G, problem.g, problem.mu, problem.normal_min, problem.normal_max, problem.law == "convex",
            1.0 / norm if norm > 0.0 else 1.0, settings.tol, ROUNDS, 3, forces,
        )  # fmt: skip
        done = sweeps + steps
        if relative <= settings.tol:
            return Answer(forces.reshape(-1, 3), done)
        return Answer(forces.reshape(-1, 3), done, Status.MAX_ITERATIONS)
    end = time.perf_counter() + settings.max_time
    done, relative = alternate(problem, settings, end, forces)
    return Answer(forces.reshape(-1, 3), done, Status.MAX_ITERATIONS)


@register("newton", bilateral=True)
def solve_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law by semismooth Newton alone as far as it gets: one sweep before each attempt.

    An iteration is a Newton step or a sweep; see `surefoot.solvers.newton`.
    """
    forces = start_forces(problem, warm_start)
    end = time.perf_counter() + settings.max_time
    rounds = 40 if settings.max_iterations is None else settings.max_iterations
    done, _ = alternate(problem, settings, end, forces, burst=1, grow=1, rounds=rounds)
    stop = Status.MAX_TIME if time.perf_counter() > end else Status.STALLED
    return Answer(forces.reshape(-1, 3), done, stop)


def alternate(
    problem: ContactProblem,
    settings: Settings,
    end: float,
    forces: FloatArray,
    burst: int = 10,
    grow: int = 2,
    rounds: int = 14,
) -> tuple[int, float]:
    """Alternate sweeps and Newton steps on the blocks of G; update flat forces in place."""
    b = problem.blocks
    matrix = b.starts, b.columns, b.values
    local = prepare_blocks(*matrix)
    scale = 1.0 / problem.norm if problem.norm > 0.0 else 1.0
    laws = problem.g, problem.mu, problem.normal_min, problem.normal_max, problem.law == "convex"
    done, relative = 0, math.inf
    for _ in range(rounds):
        sweeps, solved = run_blocks(*matrix, *laws, scale, settings.tol, burst, local, forces)
        done += sweeps
        if solved or time.perf_counter() > end:
            return done, 0.0
        steps, relative = newton_sparse(problem, b, local, settings.tol, 30, end, forces)
        done += steps
        if relative <= settings.tol or time.perf_counter() > end:
            return done, relative
        burst = min(grow * burst, 400)
    return done, relative
