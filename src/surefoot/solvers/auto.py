"""The default solver: it chooses, combines and keeps to its time.

Exact cones, up to 45 contacts: one compiled call that alternates bursts of Gauss-Seidel sweeps, which find
out who sticks, slides or takes off, with Newton steps, which finish. Larger problems: sweeps on 3x3 blocks,
then Newton steps by sparse factorisation with sweeps between them. What these leave unsolved is handed on:
for Coulomb's law to an interior point and ADMM, with Newton steps from where it is, and for the convex law to
Newton's method on its dual (`distribution`) and an interior point. Pyramids: ADMM, then Lemke's method
(Coulomb) or a QP solver (convex). The forces returned are the best that any of them found; the status is
theirs.
`max_time` is checked between methods and iterations; the one compiled call of a small problem looks at no
clock and is given as many iterations as should fit.
"""

from __future__ import annotations

import math
import time

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import COMPILED_CONTACTS, ContactProblem
from surefoot.contact.residuals import certificate, certify_dense
from surefoot.contact.scales import scales_dense
from surefoot.contact.solution import Status
from surefoot.errors import MissingExtra, SolverNotFound
from surefoot.kernels import kernel
from surefoot.solvers.admm import run_admm
from surefoot.solvers.infeasibility import find_proof
from surefoot.solvers.newton import FEW, SHARES_MANY, run_dense
from surefoot.solvers.newton_sparse import NO_GUESS, BlockNewton
from surefoot.solvers.solver import (
    Answer,
    Settings,
    SolverFunction,
    fitting,
    mismatch,
    nearest_to_zero,
    register,
    registry,
    start_forces,
)
from surefoot.solvers.stopping import settle

NEWTON_ROUNDS, UNBOUNDED = 40, 1 << 40
CHUNK, STEP_WORTH = 10, 50
"""Sweeps on blocks between two looks at the gap, and how many of them a Newton step is worth."""
Try = tuple[float, int, int, int | None]
FIRST_TRY: Try = (0.3, 50, 8, 6)
"""Newton on blocks: the proximal term's share, sweeps after a step, patience, and steps without a guess."""
NO_GUESS_TRIES: tuple[Try, ...] = ((1e-4, 100, 20, 17),)
GUESS_TRIES: tuple[Try, ...] = ((3.0, 50, 25, None), (0.03, 50, 25, None), (100.0, 50, 25, None))
"""What follows, after ADMM, if that found no guess (mass ratios of 1e6 bear no large proximal term), and if
it did."""
FINISH = (0.1, 50, 5)
"""Newton from the forces of ADMM: share, sweeps, patience."""
ROUNDS, BURST, BURST_MANY = 8, 2, 10
"""Alternations on small problems, and sweeps before the first Newton step (then twice as many each time),
of few contacts and of many."""
ON_BLOCKS, ADMM_AND_NEWTON, PROOF = "sweeps and newton on blocks", "admm and newton", "infeasibility proof"
MORE_NEWTON, EARLY_PROOF = "more newton on blocks", "infeasibility proof, in small parts only"
"""What is asked besides solvers; see `_PARTS`."""
NEARLY = 1e-2
"""A velocity error of the compiled call's forces below which other methods come before a look for a proof."""
POSSIBLE, EARLY_TIME = 1e-3, 0.1
"""A velocity error of many contacts below which no proof of infeasibility is looked for before all else has
failed, and seconds for an early look."""
Plan = tuple[tuple[str, int | None, bool], ...]
CONES: dict[str, Plan] = {
    "coulomb": (
        (PROOF, None, False),
        ("newton", None, False),
        ("admm", 1500, False),
        (ON_BLOCKS, 20_000, False),
        ("interior_point", None, False),
        ("admm", 10_000, True),
        ("staggered", 20, True),
        ("nsgs", 20_000, True),
    ),
    "convex": (
        (PROOF, None, False),
        ("distribution", None, False),
        ("interior_point", None, False),
        ("admm", 4000, True),
        ("clarabel", None, False),
    ),
}
CONES_LARGE: dict[str, Plan] = {
    "coulomb": (
        (EARLY_PROOF, None, False),
        ("interior_point", 40, False),
        (ADMM_AND_NEWTON, 6000, True),
        (PROOF, None, False),
        (MORE_NEWTON, 30_000, True),
        (ADMM_AND_NEWTON, 20_000, True),
        (MORE_NEWTON, 100_000, True),
    ),
    "convex": (
        (PROOF, None, False),
        ("interior_point", None, False),
        (ADMM_AND_NEWTON, 4000, True),
        ("clarabel", None, False),
    ),
}
PYRAMIDS: dict[str, Plan] = {
    "coulomb": (("admm", 2000, True), (PROOF, None, False), ("lemke", None, False), ("admm", None, True)),
    "convex": (("admm", 2000, True), (PROOF, None, False), ("daqp", None, False), ("admm", None, True)),
}
"""Who is asked next, for at most how many iterations (None: its own limit), and whether from the best forces
so far: a bad guess can hold a method back, so some start afresh."""


@kernel
def solve_compiled(
    packed: FloatArray, tol: float, most: int, burst: int, warm: bool, buffer: FloatArray
) -> int:  # fmt: skip
    """Fill the buffer: forces, velocities, and what `contact.residuals` says of them; see `Shortcut`.

    `burst` is the number of sweeps before the first Newton step.
    """
    m = packed.shape[1]
    n = m // 3
    G, g, laws, convex = packed[:m], packed[m], packed[m + 1], packed[m + 2, 0] != 0.0
    mu, low, high = laws[:n], laws[n : 2 * n], laws[2 * n :]
    forces, velocities, scales = np.zeros(m), np.empty(m), np.empty((4, n))
    scales_dense(G, g, low, high, scales)
    if warm:
        for k in range(n):
            for a in range(3):
                forces[3 * k + a] = buffer[k, a]
    most = UNBOUNDED if most < 0 else most
    if burst == 0:
        burst = BURST if n <= FEW else BURST_MANY
    settle(low, scales, forces)
    done, _ = run_dense(G, g, mu, low, high, convex, scales, tol, ROUNDS, burst, most, forces, velocities)
    settle(low, scales, forces)
    numbers = certify_dense(G, g, mu, low, high, scales, 0, True, not convex, forces, velocities)
    for k in range(n):
        for a in range(3):
            buffer[k, a], buffer[n + k, a] = forces[3 * k + a], velocities[3 * k + a]
    buffer[2 * n, 0], buffer[2 * n, 1], buffer[2 * n, 2] = numbers[0], numbers[1], numbers[2]
    buffer[2 * n + 1, 0], buffer[2 * n + 1, 1], buffer[2 * n + 1, 2] = numbers[3], numbers[4], numbers[5]
    buffer[2 * n + 2, 0], buffer[2 * n + 2, 1], buffer[2 * n + 2, 2] = numbers[6], 0.0, 0.0
    return done if max(numbers[0], numbers[1], numbers[2]) <= tol else ~done


@register("auto", bilateral=True, polyhedral=True, shortcut=solve_compiled)
def solve_auto(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law, exact or on pyramids; an iteration is one of whatever method ran."""
    start = time.perf_counter()
    if problem.facets is not None:
        return _hand_on(problem, settings, warm_start, 0, PYRAMIDS[problem.law], start)
    if problem.contacts <= COMPILED_CONTACTS:
        names = CONES[problem.law]
        if problem.contacts > FEW:  # a dense iteration of ADMM costs more than a sweep on blocks
            names = tuple(sorted(names, key=lambda entry: entry[0] not in (PROOF, ON_BLOCKS)))
        if warm_start is not None and worst_of(problem, warm_start) < NEARLY:  # it has a solution, probably
            names = (*names[1:2], *names[:1], *names[2:])
        return _hand_on(problem, settings, warm_start, 0, names, start)
    forces = start_forces(problem, warm_start)
    done, error, far = alternate(problem, settings, forces)
    if error <= settings.tol:
        return Answer(forces.reshape(-1, 3), done)
    guess = None if far > NO_GUESS else forces.reshape(-1, 3)
    return _hand_on(problem, settings, guess, done, CONES_LARGE[problem.law], start)


def _hand_on(
    problem: ContactProblem,
    settings: Settings,
    forces: FloatArray | None,
    done: int,
    names: Plan,
    start: float,
) -> Answer:
    """Try solvers in turn, each with its own bound on iterations, from the best forces so far."""
    best = nearest_to_zero(problem)
    best_error = worst_of(problem, best)
    if forces is not None and worst_of(problem, forces) <= best_error:
        best, best_error = forces, worst_of(problem, forces)
    stop, entries = Status.STALLED, registry()
    for name, bound, warm in names:
        left = settings.max_time - (time.perf_counter() - start)
        if left <= 0.0 or (settings.max_iterations is not None and done >= settings.max_iterations):
            stop = Status.MAX_TIME if left <= 0.0 else Status.MAX_ITERATIONS
            break
        if name in (PROOF, EARLY_PROOF):
            if problem.contacts > COMPILED_CONTACTS and best_error <= POSSIBLE:
                continue
            given = left if name == PROOF else min(left, EARLY_TIME)
            if (proof := find_proof(problem, given)) is not None:
                return Answer(best, done, Status.INFEASIBLE, proof=proof)
            continue
        function = _PARTS.get(name)
        if function is None:
            if name not in entries or mismatch(entries[name], problem) is not None:
                continue
            function = entries[name].function
        if settings.max_iterations is not None:
            bound = min(bound or settings.max_iterations, settings.max_iterations - done)
        try:
            answer = function(problem, Settings(settings.tol, bound, left), best if warm else None)
        except (MissingExtra, SolverNotFound):  # an optional package that is not installed
            continue
        done += answer.iterations
        found = np.ascontiguousarray(answer.forces, dtype=np.float64)
        error = worst_of(problem, found)
        if error < best_error:
            best, best_error = found, error
        if best_error <= settings.tol:
            break
    return Answer(best, done, stop)


def worst_of(problem: ContactProblem, forces: FloatArray) -> float:
    """Return what the certificate compares with the tolerance; infinite for forces that are not finite."""
    numbers = certificate(problem, forces)[1][:3]
    return math.inf if math.isnan(numbers[0]) else max(numbers)


def _on_blocks(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve few contacts as many are solved."""
    forces = start_forces(problem, warm_start)
    done, error, far = alternate(problem, settings, forces)
    if error > settings.tol:
        done += more_newton(problem, settings, forces, done, far)[0]
    return Answer(forces.reshape(-1, 3), done, Status.STALLED)


def _more_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Take Newton steps under other proximal terms than the first try's."""
    forces = start_forces(problem, warm_start)
    done, _ = more_newton(problem, settings, forces, 0, 0.0)
    return Answer(forces.reshape(-1, 3), done, Status.STALLED)


def _admm_and_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Run ADMM, with Newton steps from where it is every now and then.

    It sorts out who slides long before it converges.
    """
    newton = BlockNewton(problem, settings.tol, time.perf_counter() + settings.max_time)

    def finish(forces: FloatArray) -> tuple[FloatArray, float]:
        found = forces.copy()
        _, relative = newton.run(found, UNBOUNDED, *FINISH)
        return found, relative

    return run_admm(problem, settings, warm_start, finish)


_PARTS: dict[str, SolverFunction] = {
    ON_BLOCKS: _on_blocks,
    ADMM_AND_NEWTON: _admm_and_newton,
    MORE_NEWTON: _more_newton,
}


def call_compiled(
    packed: FloatArray, settings: Settings, burst: int, warm_start: FloatArray | None
) -> tuple[FloatArray, int, int]:
    """Call `solve_compiled`; return (n, 3) forces, what it returned, and the iterations it was given."""
    n = packed.shape[1] // 3
    buffer = np.empty((2 * n + 3, 3))
    if warm_start is not None:
        buffer[:n] = warm_start
    most = -1 if settings.max_iterations is None else settings.max_iterations
    fits = fitting(settings.max_time, n, most)
    done = solve_compiled(packed, settings.tol, fits, burst, warm_start is not None, buffer)
    return buffer[:n], done, fits


@register("newton", bilateral=True)
def solve_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law by semismooth Newton as far as it gets, from one sweep.

    Small problems have twice as many sweeps before each further attempt. An iteration is a Newton step or a
    sweep; see `surefoot.solvers.newton`.
    """
    if (packed := problem.compiled) is not None:
        found, done, fits = call_compiled(packed, settings, 1, warm_start)
        used, stop = max(done, ~done), Status.STALLED
        if used >= fits:
            stop = Status.MAX_ITERATIONS if fits == settings.max_iterations else Status.MAX_TIME
        return Answer(found, used, stop)
    forces = start_forces(problem, warm_start)
    end = time.perf_counter() + settings.max_time
    most = UNBOUNDED if settings.max_iterations is None else settings.max_iterations
    newton, done = BlockNewton(problem, settings.tol, end), 0
    for attempt in range(NEWTON_ROUNDS):
        if done >= most or time.perf_counter() > end:
            break
        done += newton.sweep(forces, 1)
        steps, relative = newton.run(forces, min(30, most - done), SHARES_MANY[attempt % 3])
        done += steps
        if relative <= settings.tol:
            break
    stop = Status.MAX_ITERATIONS if done >= most else Status.STALLED
    return Answer(forces.reshape(-1, 3), done, Status.MAX_TIME if time.perf_counter() > end else stop)


def alternate(problem: ContactProblem, settings: Settings, forces: FloatArray) -> tuple[int, float, float]:
    """Sweep on the blocks of G as long as that will do, then take Newton steps with sweeps between them.

    Flat forces are updated in place; return the sweeps and steps, the velocity error and the force error.
    """
    tol, most = settings.tol, UNBOUNDED if settings.max_iterations is None else settings.max_iterations
    newton = BlockNewton(problem, tol, time.perf_counter() + settings.max_time)
    done, before = 0, math.inf
    _, error, far = newton.measure(forces)
    while error > tol and done < most and time.perf_counter() < newton.end:
        done += newton.sweep(forces, min(CHUNK, most - done))
        before, (_, error, far) = error, newton.measure(forces)
        if done > CHUNK and not tol > error * (error / before) ** (STEP_WORTH / CHUNK):
            break
    if error > tol and done < most and time.perf_counter() < newton.end:
        used, error = newton.run(forces, most - done, *FIRST_TRY)
        done, far = done + used, newton.measure(forces)[2]
    return done, error, far


def more_newton(
    problem: ContactProblem, settings: Settings, forces: FloatArray, done: int, far: float
) -> tuple[int, float]:
    """Try Newton steps from flat forces, in place, under one proximal term after the other.

    `done` iterations count against the limit; `far` is the force error so far. Return the sweeps and steps,
    and the velocity error.
    """
    most = UNBOUNDED if settings.max_iterations is None else settings.max_iterations - done
    newton = BlockNewton(problem, settings.tol, time.perf_counter() + settings.max_time)
    used, error = 0, newton.measure(forces)[1]
    for now in NO_GUESS_TRIES if far > NO_GUESS else GUESS_TRIES:
        if not (error > settings.tol and used < most and time.perf_counter() < newton.end):
            break
        steps, error = newton.run(forces, most - used, *now)
        used += steps
    return used, error
