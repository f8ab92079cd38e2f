"""The default solver: a table of plans (`plans`), and a runner that keeps to its time.

Exact cones, up to 45 contacts: one compiled call that alternates bursts of Gauss-Seidel sweeps with Newton
steps (`compiled`). Larger problems: sweeps on 3x3 blocks, then Newton steps by sparse factorisation with
sweeps between them (`on_blocks`). What these leave unsolved is handed on: for Coulomb's law to an interior
point and ADMM, with Newton steps from where it is, and for the convex law to Newton's method on its dual
(`distribution`) and an interior point. Pyramids: ADMM, then Lemke's method (Coulomb) or a QP solver (convex).
Contacts of any kind: ADMM with Newton steps from where it is.
The forces returned are the best that any of them found; the status is theirs.
`max_time` is checked between methods and iterations; the one compiled call of a small problem looks at no
clock and is given as many iterations as should fit.
"""

from __future__ import annotations

import math
import time

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.residuals import certificate
from surefoot.contact.solution import Status
from surefoot.errors import MissingExtra, SolverNotFound
from surefoot.solvers import on_blocks, plans
from surefoot.solvers.compiled import COMPILED_CONTACTS, attempt
from surefoot.solvers.infeasibility import find_proof
from surefoot.solvers.newton_sparse import NO_GUESS
from surefoot.solvers.newton_step import FEW
from surefoot.solvers.plans import EARLY_PROOF, ON_BLOCKS, PROOF, Plan, Stage
from surefoot.solvers.set_newton import set_admm_and_newton
from surefoot.solvers.solver import (
    Answer,
    SolverFunction,
    SolverSettings,
    mismatch,
    nearest_to_zero,
    register,
    registry,
    start_forces,
)

NEARLY = 1e-2
"""A velocity error of the compiled call's forces below which other methods come before a look for a proof."""
POSSIBLE, EARLY_TIME = 1e-3, 0.1
"""A velocity error of many contacts below which no proof of infeasibility is looked for before all else has
failed, and seconds for an early look."""
PARTS: dict[str, SolverFunction] = {
    ON_BLOCKS: on_blocks.on_blocks,
    plans.ADMM_AND_NEWTON: on_blocks.admm_and_newton,
    plans.MORE_NEWTON: on_blocks.more_newton,
    plans.SETS: set_admm_and_newton,
}


@register("auto", laws=None, bilateral=True, polyhedral=True, general=True, attempt=attempt)
def solve_auto(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve either law from a (n, 3) warm start; an iteration is one of whatever method ran."""
    start = time.perf_counter()
    if problem.general:
        return _run(problem, settings, warm_start, 0, plans.GENERAL, start)
    if problem.facets is not None:
        return _run(problem, settings, warm_start, 0, plans.PYRAMIDS[problem.law], start)
    if problem.contacts <= COMPILED_CONTACTS:
        return _run(problem, settings, warm_start, 0, _small_plan(problem, warm_start), start)
    forces = start_forces(problem, warm_start)
    done, error, far = on_blocks.alternate(problem, settings, forces)
    if error <= settings.tol:
        return Answer(forces.reshape(-1, 3), done)
    guess = None if far > NO_GUESS else forces.reshape(-1, 3)
    return _run(problem, settings, guess, done, plans.CONES_LARGE[problem.law], start)


def _small_plan(problem: ContactProblem, forces: FloatArray | None) -> Plan:
    """Return the plan of few contacts, in the order that the compiled call's forces suggest."""
    plan = plans.CONES[problem.law]
    if problem.contacts > FEW:  # a dense iteration of ADMM costs more than a sweep on blocks
        plan = tuple(sorted(plan, key=lambda stage: stage.name not in (PROOF, ON_BLOCKS)))
    if forces is not None and worst_of(problem, forces) < NEARLY:  # it has a solution, probably
        plan = (*plan[1:2], *plan[:1], *plan[2:])
    return plan


def _run(
    problem: ContactProblem,
    settings: SolverSettings,
    forces: FloatArray | None,
    done: int,
    plan: Plan,
    start: float,
) -> Answer:
    """Try the stages of a plan in turn, each with its own bound on iterations, and keep the best forces."""
    best = nearest_to_zero(problem)
    best_error = worst_of(problem, best)
    if forces is not None and (error := worst_of(problem, forces)) <= best_error:
        best, best_error = forces, error
    most = settings.max_iterations
    for stage in plan:
        left = settings.max_time - (time.perf_counter() - start)
        if left <= 0.0 or (most is not None and done >= most):
            return Answer(best, done, Status.MAX_TIME if left <= 0.0 else Status.MAX_ITERATIONS)
        if stage.name in (PROOF, EARLY_PROOF):
            if problem.contacts > COMPILED_CONTACTS and best_error <= POSSIBLE:
                continue
            proof = find_proof(problem, left if stage.name == PROOF else min(left, EARLY_TIME))
            if proof is not None:
                return Answer(best, done, Status.INFEASIBLE, proof=proof)
            continue
        bound = stage.most if most is None else min(stage.most or most, most - done)
        answer = _ask(stage, problem, SolverSettings(settings.tol, bound, left), best)
        if answer is None:
            continue
        done += answer.iterations
        found = np.ascontiguousarray(answer.forces, dtype=np.float64)
        if (error := worst_of(problem, found)) < best_error:
            best, best_error = found, error
        if best_error <= settings.tol:
            break
    return Answer(best, done, Status.STALLED)


def _ask(stage: Stage, problem: ContactProblem, settings: SolverSettings, best: FloatArray) -> Answer | None:
    """Return what a stage answers; None where it does not take the problem or its package is missing."""
    function = PARTS.get(stage.name)
    if function is None:
        entry = registry().get(stage.name)
        if entry is None or mismatch(entry, problem) is not None:
            return None
        function = entry.function
    try:
        return function(problem, settings, best if stage.warm else None)
    except (MissingExtra, SolverNotFound):  # an optional package that is not installed
        return None


def worst_of(problem: ContactProblem, forces: FloatArray) -> float:
    """Return what the certificate of (n, 3) forces compares with the tolerance; infinite if not finite."""
    numbers = certificate(problem, forces)[1][:3]
    return math.inf if math.isnan(numbers[0]) else max(numbers)
