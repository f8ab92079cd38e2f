"""Sweeps and Newton steps on the 3x3 blocks of a sparse G, and ADMM between them: the parts of `auto`.

Each takes what a solver takes and returns an `Answer`; none is a solver of its own, since each leaves some
kind of problem to the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.admm import run_admm
from surefoot.contact.solvers.compiled import UNBOUNDED
from surefoot.contact.solvers.newton import NATURAL_STEPS, on_natural_map, solve_newton
from surefoot.contact.solvers.newton_sparse import BlockNewton
from surefoot.contact.solvers.scaled import ScaledContacts
from surefoot.contact.solvers.solver import Answer, SolverSettings, start_forces

CHUNK, STEP_WORTH = 10, 50
"""Sweeps on blocks between two looks at the gap, and how many of them a Newton step is worth."""
HEAVY, FULL = 50_000, 500
"""Blocks above which a Newton step, with its factorisation on contacts, takes as long as many sweeps, and
contacts up to which a full matrix is factorised soon enough however many blocks it has."""
FIRST_TRY = (0.3, 50, 8)
"""Newton on blocks: the proximal term's share, sweeps after a step, and patience."""
NEAR = 5e-3
"""A velocity error that sweeps have left, up to which a few Newton steps end it sooner than anything else."""
HALVING = 5
"""Of many contacts, steps in which the error has to halve: where it does not, another method is quicker."""
FINISH = (0.1, 50, 5)
"""Newton from the forces of ADMM: share, sweeps, patience."""

Steps = Callable[[FloatArray, int], int]
"""Take so many iterations at most from flat forces (3n,), updated in place; return how many were taken, zero
where it does not try."""


def heavy(problem: ContactProblem) -> bool:
    """Tell whether Newton steps on contacts take too long for a problem's many blocks."""
    return problem.contacts > FULL and problem.blocks.columns.size > HEAVY


def on_blocks(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve few contacts as many are solved, from a (n, 3) warm start."""
    forces = start_forces(problem, warm_start)
    done = alternate(problem, settings, forces)[0]
    return Answer(forces.reshape(-1, 3), done, Status.STALLED)


def admm_and_newton(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Run ADMM from a warm start (rows,), any unit, with Newton steps every now and then, on any contacts.

    It sorts out who slides long before it converges.
    """
    end, scaled = working_time() + settings.max_time, ScaledContacts(problem)
    if not problem.general and heavy(problem):
        return run_admm(scaled, settings, warm_start)
    newton = None if problem.general else BlockNewton(problem, settings.tol, end)

    def finish(z: FloatArray) -> tuple[FloatArray, float]:
        if newton is None:
            return on_natural_map(scaled, z.copy(), settings.tol, NATURAL_STEPS, end)[:2]
        found = z * scaled.D
        return found, newton.run(found, UNBOUNDED, *FINISH)[1]

    return run_admm(scaled, settings, warm_start, finish)


def newton_steps(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Take Newton steps, few sweeps between, from a (n, 3) warm start; None where each takes too long."""
    return None if heavy(problem) else solve_newton(problem, settings, warm_start)


def alternate(
    problem: ContactProblem,
    settings: SolverSettings,
    forces: FloatArray,
    between: Steps | None = None,
) -> tuple[int, float, float]:
    """Sweep on the blocks of G as long as that will do, then take Newton steps with sweeps between them.

    Flat (3n,) forces are updated in place. Another method may come `between` them, after which no Newton
    steps are taken. Return sweeps and steps, the velocity error and the force error.
    """
    tol, most = settings.tol, UNBOUNDED if settings.max_iterations is None else settings.max_iterations
    newton = BlockNewton(problem, tol, working_time() + settings.max_time)
    done, before = 0, math.inf
    _, error, far = newton.measure(forces)
    while error > tol and done < most and working_time() < newton.end:
        done += newton.sweep(forces, min(CHUNK, most - done))
        before, (_, error, far) = error, newton.measure(forces)
        # linear convergence extrapolated: would the sweeps that a Newton step is worth reach the tolerance?
        if done > CHUNK and not tol > error * (error / before) ** (STEP_WORTH / CHUNK):
            break
    if heavy(problem):
        return done, error, far

    def take_steps(forces: FloatArray, most: int) -> int:
        return newton.run(forces, most, *FIRST_TRY, None if between is None else HALVING)[0]

    # near an answer Newton steps end it sooner, if they can; far from it they may not even start well. Where
    # bodies are known the other method's way is as short as theirs
    first = error <= NEAR and problem.factor is None
    other = [] if between is None else [between]
    for method in (take_steps, *other) if first else (*other, take_steps):
        if error <= tol or done >= most or working_time() >= newton.end:
            break
        used = method(forces, most - done)
        done, (_, error, far) = done + used, newton.measure(forces)
        if used and not first:
            break
    return done, error, far
