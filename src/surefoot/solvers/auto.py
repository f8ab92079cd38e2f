"""The default solver: it chooses, combines and keeps to its time.

Exact cones, up to 45 contacts: one compiled call that alternates bursts of Gauss-Seidel sweeps, which find
out who sticks, slides or takes off, with Newton steps, which finish. Larger problems: the same alternation
on 3x3 blocks with a sparse factorisation. What these leave unsolved is handed on, best forces first: to
ADMM for Coulomb's law, and for the convex law to Newton's method on its dual (`distribution`) and an
interior point, where redundant contacts make sweeps crawl. Pyramids: ADMM, then Lemke's method (Coulomb) or
a QP solver (convex). The forces returned are the best that any of them found; the status is theirs.
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
from surefoot.contact.solution import Status
from surefoot.errors import SurefootError
from surefoot.kernels import kernel
from surefoot.solvers.admm import run_admm
from surefoot.solvers.newton import FEW, SHARES_MANY, run_dense
from surefoot.solvers.newton_sparse import newton_sparse
from surefoot.solvers.nsgs import Sweeper, prepare_blocks
from surefoot.solvers.solver import (
    Answer,
    Settings,
    fitting,
    mismatch,
    register,
    registry,
    start_forces,
)

NEWTON_ROUNDS, UNBOUNDED = 40, 1 << 40
NO_GUESS = 0.1
"""A relative gap above which forces are no better a start than none."""
ROUNDS, BURST, BURST_MANY = 8, 2, 10
"""Alternations on small problems, and sweeps before the first Newton step (then twice as many each time),
of few contacts and of many."""
CONES: dict[str, tuple[tuple[str, int | None, bool], ...]] = {
    "coulomb": (
        ("admm", 600, True),
        ("admm", 1500, False),
        ("staggered", 100, True),
        ("interior_point", None, False),
        ("admm", None, True),
        ("nsgs", None, True),
    ),
    "convex": (
        ("distribution", None, False),
        ("interior_point", None, False),
        ("admm", 4000, True),
        ("clarabel", None, False),
    ),
}
CONES_LARGE: dict[str, tuple[tuple[str, int | None, bool], ...]] = {
    "coulomb": (("admm", 600, True), ("admm", None, False), ("staggered", 100, True)),
    "convex": CONES["convex"][1:],
}
PYRAMIDS: dict[str, tuple[tuple[str, int | None, bool], ...]] = {
    "coulomb": (("admm", 2000, True), ("lemke", None, False), ("admm", None, True)),
    "convex": (("admm", 2000, True), ("daqp", None, False), ("admm", None, True)),
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
    G, g, laws, step, convex = packed[:m], packed[m], packed[m + 1], packed[m + 2, 0], packed[m + 2, 1] != 0.0
    mu, low, high = laws[:n], laws[n : 2 * n], laws[2 * n :]
    forces, velocities = np.zeros(m), np.empty(m)
    if warm:
        for k in range(n):
            for a in range(3):
                forces[3 * k + a] = buffer[k, a]
    most = UNBOUNDED if most < 0 else most
    if burst == 0:
        burst = BURST if n <= FEW else BURST_MANY
    done, _ = run_dense(G, g, mu, low, high, convex, step, tol, ROUNDS, burst, most, forces, velocities)
    numbers = certify_dense(G, g, mu, low, high, step, 0, True, not convex, forces, velocities)
    for k in range(n):
        for a in range(3):
            buffer[k, a], buffer[n + k, a] = forces[3 * k + a], velocities[3 * k + a]
    buffer[2 * n, 0], buffer[2 * n, 1], buffer[2 * n, 2] = numbers[0], numbers[1], numbers[2]
    buffer[2 * n + 1, 0], buffer[2 * n + 1, 1], buffer[2 * n + 1, 2] = numbers[3], numbers[4], 0.0
    return done if numbers[0] <= tol else ~done


@register("auto", bilateral=True, polyhedral=True, shortcut=solve_compiled)
def solve_auto(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law, exact or on pyramids; an iteration is one of whatever method ran."""
    start = time.perf_counter()
    if problem.facets is not None:
        return _hand_on(problem, settings, warm_start, 0, PYRAMIDS[problem.law], start)
    if problem.contacts <= COMPILED_CONTACTS:
        return _hand_on(problem, settings, warm_start, 0, CONES[problem.law], start)
    forces = start_forces(problem, warm_start)
    done, relative = alternate(problem, settings, start + settings.max_time, forces, hopeless=3)
    if relative <= settings.tol:
        return Answer(forces.reshape(-1, 3), done)
    names = CONES_LARGE[problem.law]
    if problem.law == "coulomb" and relative > NO_GUESS:
        names = names[1:]
    return _hand_on(problem, settings, forces.reshape(-1, 3), done, names, start)


def _hand_on(
    problem: ContactProblem,
    settings: Settings,
    forces: FloatArray | None,
    done: int,
    names: tuple[tuple[str, int | None, bool], ...],
    start: float,
) -> Answer:
    """Try solvers in turn, each with its own bound on iterations, from the best forces so far."""
    best = np.zeros((problem.contacts, 3)) if forces is None else forces
    best_gap = certificate(problem, best)[1][0]
    stop, entries = Status.STALLED, registry()
    for name, bound, warm in names:
        left = settings.max_time - (time.perf_counter() - start)
        if left <= 0.0 or (settings.max_iterations is not None and done >= settings.max_iterations):
            stop = Status.MAX_TIME if left <= 0.0 else Status.MAX_ITERATIONS
            break
        if name not in entries or mismatch(entries[name], problem) is not None:
            continue
        if settings.max_iterations is not None:
            bound = min(bound or settings.max_iterations, settings.max_iterations - done)
        try:
            mixed = name == "admm" and problem.facets is None and problem.contacts > COMPILED_CONTACTS
            function = _admm_and_newton if mixed else entries[name].function
            answer = function(problem, Settings(settings.tol, bound, left), best if warm else None)
        except SurefootError:  # an optional package that is not installed
            continue
        done, stop = done + answer.iterations, answer.stop
        found = np.ascontiguousarray(answer.forces, dtype=np.float64)
        gap = certificate(problem, found)[1][0]
        if gap < best_gap:
            best, best_gap = found, gap
        if best_gap <= settings.tol or stop is Status.INFEASIBLE:
            break
    return Answer(best, done, stop)


def _admm_and_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Run ADMM, with Newton steps from where it is every now and then.

    It sorts out who slides long before it converges.
    """
    b = problem.blocks
    local = prepare_blocks(b.starts, b.columns, b.values)
    end = time.perf_counter() + settings.max_time

    def finish(forces: FloatArray) -> tuple[FloatArray, float]:
        found = forces.copy()
        _, relative = newton_sparse(problem, b, local, settings.tol, 30, SHARES_MANY[0], end, found)
        return found, relative

    return run_admm(problem, settings, warm_start, finish)


@register("newton", bilateral=True)
def solve_newton(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law by semismooth Newton as far as it gets, from one sweep.

    Small problems have twice as many sweeps before each further attempt. An iteration is a Newton step or a
    sweep; see `surefoot.solvers.newton`.
    """
    if (packed := problem.compiled) is not None:
        n = problem.contacts
        buffer = np.empty((2 * n + 2, 3))
        if warm_start is not None:
            buffer[:n] = warm_start
        most = -1 if settings.max_iterations is None else settings.max_iterations
        fits = fitting(settings.max_time, n, most)
        steps = solve_compiled(packed, settings.tol, fits, 1, warm_start is not None, buffer)
        used, stop = max(steps, ~steps), Status.STALLED
        if used >= fits:
            stop = Status.MAX_ITERATIONS if fits == most else Status.MAX_TIME
        return Answer(buffer[:n], used, stop)
    forces = start_forces(problem, warm_start)
    end = time.perf_counter() + settings.max_time
    rounds = NEWTON_ROUNDS if settings.max_iterations is None else settings.max_iterations
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
    hopeless: int | None = None,
) -> tuple[int, float]:
    """Alternate sweeps and Newton steps on the blocks of G; update flat forces in place.

    Stop after round `hopeless` where the forces are still no guess and have hardly got better.
    """
    sweep = Sweeper(problem, forces, blocks=True)
    done, relative, first = 0, math.inf, math.inf
    for attempt in range(rounds):
        sweeps, solved = sweep(settings.tol, burst)
        done += sweeps
        if solved:
            return done, 0.0
        if time.perf_counter() > end:
            break
        steps, relative = newton_sparse(
            problem, problem.blocks, sweep.local, settings.tol, 30, SHARES_MANY[attempt % 3], end, forces
        )
        done += steps
        if relative <= settings.tol or time.perf_counter() > end:
            break
        first = relative if attempt == 0 else first
        if attempt == hopeless and relative > max(NO_GUESS, 0.5 * first):
            break
        burst = min(grow * burst, 400)
    return done, relative
