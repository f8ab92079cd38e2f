"""The default solver: a table of plans (`plans`), and a runner that keeps to its time.

Exact cones, up to 128 contacts: one compiled call that alternates bursts of Gauss-Seidel sweeps with Newton
steps (`compiled`); of more than 25 it takes one round first (of few bodies a taste of it), and further ones
after an interior point where bodies are few or its steps lightest (`redundant_contacts`). Larger problems:
sweeps on 3x3 blocks, then Newton steps by sparse factorisation with sweeps between them while they halve the
error (`on_blocks`); of few bodies, or known ones, an interior point before them, unless the forces are near
already. What these leave unsolved goes through the stages of its plan. Connected parts are solved each by
itself there: one that has no solution must not keep the others from theirs; and a proof is looked for that
there is no solution.
The forces returned are the best that any stage found; the status is theirs.
`max_time` is checked between methods and iterations; the one compiled call of a small problem looks at no
clock and is given as many iterations as should fit. Without `max_time` no clock decides anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import MissingExtra, SolverNotFound
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.proof import check_proof, connected_parts
from surefoot.contact.problem.redundancy import few_bodies
from surefoot.contact.problem.residuals import certificate
from surefoot.contact.sets import ContactSet
from surefoot.contact.solution import Status
from surefoot.contact.solvers import on_blocks
from surefoot.contact.solvers import strategies as plans
from surefoot.contact.solvers.compiled import COMPILED_CONTACTS, LATER, attempt
from surefoot.contact.solvers.infeasibility import find_proof
from surefoot.contact.solvers.newton_step import FEW
from surefoot.contact.solvers.redundant_contacts import (
    where_dense,
    where_few_bodies,
    where_heaviest,
    where_light,
    where_lightest,
    where_long,
    where_redundant,
    where_sparse,
)
from surefoot.contact.solvers.solver import (
    Answer,
    SolverSettings,
    mismatch,
    nearest_to_zero,
    register,
    registry,
    solve,
    start_forces,
)
from surefoot.contact.solvers.strategies import INTERIOR, ON_BLOCKS, PARTS, PROOF, Plan, PlanStage

NEARLY = 1e-2
"""A velocity error of the compiled call's forces below which other methods come before a look for a proof."""
POSSIBLE = 1e-3
"""A velocity error of many contacts below which forces are polished, and no proof of infeasibility is looked
for before all else has failed."""
SURELY = 1e-6
"""The same of few contacts."""
NEARLY_SOLVED = 1e-6
"""A velocity error that an interior point has left, from which Newton steps mostly end it."""
EARLY_TIME, EARLY = 0.1, 0.1
"""Seconds that an early look for a proof may take at least, and the share of what time is left."""
NO_GUESS = 0.1
"""A force error above which forces are no better a start than none."""
RUNAWAY = 100.0
"""Forces beyond this many times s_k / ||G_kk||, what stops the fastest contact, run away: 8e3 to 1e5 where
redundant contacts contradict each other, 12 in dense heaps of capsules; but up to 850, too, under bodies a
thousand times as heavy and more."""


@register("auto", laws=None, bilateral=True, polyhedral=True, general=True, attempt=attempt, proves=True)
def solve_auto(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve either law from a (n, 3) warm start; an iteration is one of whatever method ran."""
    start = working_time()
    if problem.general:
        return _run(problem, settings, warm_start, 0, plans.GENERAL, start)
    if problem.facets is not None:
        return _run(problem, settings, warm_start, 0, plans.PYRAMIDS[problem.law], start)
    if problem.contacts <= COMPILED_CONTACTS:
        return _run(problem, settings, warm_start, 0, _small_plan(problem, warm_start), start)
    forces = start_forces(problem, warm_start)
    tried: list[FloatArray] = []

    def light(forces: FloatArray, most: int) -> int:
        """Take the forces of an interior point if better, where bodies are few or known and steps light."""
        left = settings.max_time - (working_time() - start)
        bound = None if settings.max_iterations is None else most
        found = where_light(problem, SolverSettings(settings.tol, bound, left), None)
        if found is None:
            return 0
        tried.append(found.forces)
        # far from an answer it tells less than sweeps do: theirs run away where there is none
        error = worst_of(problem, found.forces)
        if error < max(POSSIBLE, settings.tol) and (
            error <= settings.tol or error < worst_of(problem, forces.reshape(-1, 3))
        ):
            forces[:] = found.forces.ravel()
        return max(found.iterations, 1)

    done, error, far = on_blocks.alternate(problem, settings, forces, light)
    proof, doubted = None, error > max(settings.tol, POSSIBLE)
    runs_away = doubted and not tried and _run_away(problem, forces)
    if doubted and (tried or runs_away):
        # where a light interior point fails there may be no answer, and forces that run away look like
        # progress, but so do those of light bodies under heavy ones: these are worth a plain look alone.
        # Where time is bounded, the look is: else no clock may decide what is found
        taken = working_time() - start
        left = settings.max_time - taken
        proof = find_proof(problem, min(left, max(taken, EARLY_TIME, EARLY * left)), plain=runs_away)
    if error <= settings.tol or proof is not None:
        return Answer(forces.reshape(-1, 3), done, proof=proof)
    guess = None if far > NO_GUESS else forces.reshape(-1, 3)
    if tried and (found := worst_of(problem, tried[0])) < error:
        guess, error = tried[0], found
    plan = _large_plan(problem, bool(tried), error, runs_away)
    return _run(problem, settings, guess, done, plan, start)


def _large_plan(problem: ContactProblem, tried: bool, error: float, runs_away: bool = False) -> Plan:
    """Return the plan of many contacts: ADMM first where bodies are known and few, or Newton steps heavy.

    Without the interior point that was tried already, but for its long path; where that has left a small
    error, Newton steps from there come before all else. Without the first Newton steps where forces have run
    away under some.
    """
    lighter = problem.factor is not None and (few_bodies(problem) or problem.contacts > on_blocks.FULL)
    plan = (plans.CONES_BODIES if lighter else plans.CONES_LARGE)[problem.law]
    if runs_away:
        return tuple(stage for stage in plan if stage != plans.FIRST_NEWTON)
    if not tried:
        return plan
    rest = tuple(stage for stage in plan if stage.name != plans.SPARSE)
    return (plans.AFTER, *rest) if error <= NEARLY_SOLVED else rest


def _run_away(problem: ContactProblem, forces: FloatArray) -> bool:
    """Tell whether flat forces (3n,) may be on their way to infinity."""
    weight, speed = problem.scales[:2]
    # w_k ||λ_k|| is the speed that a contact's own force gives it: far beyond any speed of the problem, it
    # runs away
    size = weight * np.linalg.norm(forces.reshape(-1, 3), axis=1)
    return bool((size > RUNAWAY * speed).any())


def later_rounds(problem: ContactProblem, settings: SolverSettings, best: FloatArray) -> Answer | None:
    """Go on from the forces (n, 3) of the compiled call's first round, where it took no more."""
    found = attempt(problem, settings.tol, settings.max_iterations, settings.max_time, best, LATER)
    return None if found is None else Answer(found[0][: problem.contacts], found[1])


def _small_plan(problem: ContactProblem, forces: FloatArray | None) -> Plan:
    """Return the plan of few contacts, in the order that the compiled call's forces suggest."""
    plan = (plans.CONES if problem.contacts <= FEW else plans.CONES_MORE)[problem.law]
    if forces is not None and worst_of(problem, forces) < NEARLY:  # it has a solution, probably
        at = [stage.name for stage in plan].index(PROOF)
        plan = (*plan[:at], plan[at + 1], plan[at], *plan[at + 2 :])
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
    most, spent, looked = settings.max_iterations, False, False
    stages = list(plan)
    for number, stage in enumerate(stages, 1):
        left = settings.max_time - (working_time() - start)
        if left <= 0.0:
            return Answer(best, done, Status.MAX_TIME)
        spent = most is not None and done >= most
        if stage.name == PROOF:  # takes no iterations
            # nearly lawful forces mean that a solution probably exists: the proof,
            # slow on many contacts, is kept for last
            possible = best_error <= (POSSIBLE if problem.contacts > COMPILED_CONTACTS else SURELY)
            if looked:
                continue
            if possible and number < len(stages):
                if PROOF not in {later.name for later in stages[number:]}:
                    stages.append(stage)
                continue
            looked = True
        elif spent:
            continue
        bound = stage.most if most is None else min(stage.most or most, most - done)
        answer = try_stage(stage, problem, SolverSettings(settings.tol, bound, left), best)
        if answer is None:
            continue
        done += answer.iterations
        if answer.proof is not None or stage.name == PARTS:
            return answer._replace(iterations=done)
        found = np.ascontiguousarray(answer.forces, dtype=np.float64)
        if (error := worst_of(problem, found)) < best_error:
            best, best_error = found, error
        if best_error <= settings.tol:
            break
    return Answer(best, done, Status.MAX_ITERATIONS if spent else Status.STALLED)


def try_stage(
    stage: PlanStage, problem: ContactProblem, settings: SolverSettings, best: FloatArray
) -> Answer | None:
    """Return what a stage answers from the best forces (rows,) so far, in the problem's unit of force.

    None where it is not one for the problem, or its package is missing.
    """
    part = LOOKS.get(stage.name)
    if part is not None:
        return part(problem, settings, best)
    function = FUNCTIONS.get(stage.name)
    if function is None:
        entry = registry().get(stage.name)
        if entry is None or mismatch(entry, problem) is not None:
            return None
        function = entry.function
    try:
        return function(problem, settings, best if stage.warm else None)
    except (MissingExtra, SolverNotFound):  # an optional package that is not installed
        return None


def look_for_proof(problem: ContactProblem, settings: SolverSettings, best: FloatArray) -> Answer | None:
    """Return the best forces (rows,) so far, any unit, with a proof that there is no solution; else None."""
    proof = find_proof(problem, settings.max_time)
    return None if proof is None else Answer(best, 0, Status.INFEASIBLE, proof=proof)


def solve_parts(problem: ContactProblem, settings: SolverSettings, best: FloatArray) -> Answer | None:
    """Solve the connected parts one by one, the smallest first; None where there is only one.

    Each has an equal share of the iterations and of the time that the ones before it have left. Parts that
    the best forces (rows,), any unit, solve are left as they are.
    """
    label = connected_parts(problem)
    count = int(label.max()) + 1
    if count == 1:
        return None
    contacts = problem.contact_set
    end, left = working_time() + settings.max_time, settings.max_iterations
    forces, done, stops, proof = best.copy(), 0, [], None
    flat = forces.reshape(-1)
    for turn, name in enumerate(np.argsort(np.bincount(label), kind="stable")):
        members = np.flatnonzero(label == name)
        part, rows = part_of(problem, contacts, members)
        own = flat[rows].reshape(part.shape)
        if worst_of(part, own) <= settings.tol:
            continue
        # the smallest first: what they leave of time and iterations goes to the large ones
        share = count - turn
        found = solve(
            part, "auto", settings.tol, max_time=max(end - working_time(), 0.0) / share,
            max_iterations=None if left is None else max(left - done, 0) // share,
        )  # fmt: skip
        done += found.iterations
        flat[rows] = found.forces.ravel()
        if not found.solved:
            stops.append(found.status)
        if found.proof is not None and proof is None:
            direction = np.zeros(problem.g.size)
            direction[rows] = found.proof.direction.ravel()
            proof = check_proof(problem, direction.reshape(problem.shape))
    return Answer(forces, done, stops[0] if stops else Status.STALLED, proof=proof)


def part_of(
    problem: ContactProblem, contacts: ContactSet, members: IntArray
) -> tuple[ContactProblem, IntArray]:
    """Return the problem of some of its contacts (k,) alone, and its rows (m,) among all: dimensionless."""
    rows = np.concatenate([np.arange(*contacts.offsets[k : k + 2]) for k in members])
    chosen = [contacts[k] for k in members]
    G = problem.operator[rows][:, rows]
    part = ContactProblem(G, problem.g[rows], contacts=chosen, law=problem.law)
    part.factor = None if problem.factor is None else problem.factor[rows]
    return part, rows


StageFunction = Callable[[ContactProblem, SolverSettings, FloatArray | None], Answer | None]
"""As a solver's function; None where it is none for the problem."""
LOOKS = {
    PROOF: look_for_proof,
    PARTS: solve_parts,
    INTERIOR: where_redundant,
    plans.FEW_BODIES: where_few_bodies,
    plans.SPARSE: where_sparse,
    plans.DENSE: where_dense,
    plans.HEAVIEST: where_heaviest,
    plans.LONG_PATH: where_long,
    plans.LIGHTEST: where_lightest,
    plans.LATER: later_rounds,
}
"""Stages that look at the problem with the best forces so far: they may end the plan, or have no answer."""
FUNCTIONS: dict[str, StageFunction] = {
    ON_BLOCKS: on_blocks.on_blocks,
    plans.ADMM_AND_NEWTON: on_blocks.admm_and_newton,
    plans.NEWTON_STEPS: on_blocks.newton_steps,
}
"""Stages that are no solvers of their own."""


def worst_of(problem: ContactProblem, forces: FloatArray) -> float:
    """Return what the certificate of (n, 3) forces compares with the tolerance; infinite if not finite."""
    numbers = certificate(problem, forces)[1][:3]
    return math.inf if math.isnan(numbers[0]) else max(numbers)
