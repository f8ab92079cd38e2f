"""Lemke's complementary pivoting with lexicographic ratio tests.

A covering variable z0 makes the start feasible; each pivot brings in the complement of what left, until z0
leaves (a solution) or nothing can (a ray). Ties are broken lexicographically by the rows of the inverse
basis, so that no basis comes twice. The problem is equilibrated first, by a congruence that keeps its class.
The answer is computed anew from the final basis, not from the tableau. A ray is a claim, not a proof: see
`lcp_proof`.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, "The Linear Complementarity Problem", 2009, algorithms 4.4.1
and 4.4.5, theorem 4.4.12 (copositive-plus: a ray proves infeasibility); Stewart and Trinkle 1996 for
friction.

Limits: a dense tableau, O(n²) a pivot, and the number of pivots can be exponential (Murty's examples).
Outside the classes that it processes (copositive-plus, P, E0 under conditions ...) a ray proves nothing.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel, working_time
from surefoot.contact.problem.lcp import LCP, equilibrated, stewart_trinkle
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.solver import Answer, SolverSettings, register

PIVOTS = (1e-8, 1e-12)
"""Entries below this, relative to the largest of the entering column, are no pivots; tried in turn."""
TIE = 1e-9
"""Ratios closer than this, relatively, are ties: redundant contacts make many, and tableaus have rounding."""
ZERO = 1e-13
"""What a difference leaves below this, relatively, is zero: noise would break ties in the wrong order."""
DONE, RAY, MORE = 0, 1, 2


@kernel
def _leaving_row(T: FloatArray, column: int, basis: IntArray, n: int, least: float) -> int:
    """Return the row of the lexicographic minimum ratio, -1 for a ray; z0 (number 2n) wins every tie."""
    largest = 0.0
    for i in range(n):
        largest = max(largest, abs(T[i, column]))
    best = -1
    for i in range(n):
        pivot = T[i, column]
        # pivots that small are rounding
        if pivot <= least * largest or pivot <= 1e-13:
            continue
        if best < 0:
            best = i
            continue
        other = T[best, column]
        # ratios are compared relative to their own size: redundant contacts
        # make exact ties, which rounding blurs
        scale = abs(T[i, 2 * n + 1]) / pivot + abs(T[best, 2 * n + 1]) / other
        difference = T[i, 2 * n + 1] / pivot - T[best, 2 * n + 1] / other
        # a tie: entry by entry, so that no basis comes back (lexicographic rule)
        if abs(difference) <= TIE * scale:
            difference = 0.0
            if basis[i] == 2 * n:
                difference = -1.0
            elif basis[best] == 2 * n:
                difference = 1.0
            else:
                for j in range(n):
                    difference = T[i, j] / pivot - T[best, j] / other
                    if abs(difference) > 1e-12 * (abs(T[i, j] / pivot) + abs(T[best, j] / other)):
                        break
        if difference < 0.0:  # lexicographically smaller: (q, B⁻¹) row over the pivot, entry by entry
            best = i
    return best


@kernel
def _pivot(T: FloatArray, row: int, column: int) -> None:
    """Make a column of the tableau a unit vector."""
    inverse = 1.0 / T[row, column]
    for j in range(T.shape[1]):
        T[row, j] *= inverse
    T[row, column] = 1.0
    for i in range(T.shape[0]):
        factor = T[i, column]
        if i != row and factor != 0.0:
            for j in range(T.shape[1]):
                # what is left of two equal numbers is rounding, and a lexicographic
                # comparison reads every digit: exact zero
                step = factor * T[row, j]
                rest = T[i, j] - step
                T[i, j] = rest if abs(rest) > ZERO * abs(step) else 0.0
            T[i, column] = 0.0


@kernel
def _run(T: FloatArray, basis: IntArray, entering: int, limit: int, least: float) -> tuple[int, int, int]:
    """Pivot until done, a ray, or `limit`; return the outcome, the pivots and the next entering variable."""
    n = T.shape[0]
    for count in range(limit):
        row = _leaving_row(T, entering, basis, n, least)
        if row < 0:
            return RAY, count, entering
        leaving = basis[row]
        _pivot(T, row, entering)
        basis[row] = entering
        if leaving == 2 * n:
            return DONE, count + 1, entering
        # the complement of what left comes in: Lemke's rule keeps z·w = 0
        entering = leaving + n if leaving < n else leaving - n
    return MORE, limit, entering


def _from_basis(problem: LCP, basis: IntArray, T: FloatArray) -> FloatArray:
    """Return z from the equations of the final basis, or from the tableau if they are singular."""
    n = problem.size
    z = np.zeros(n)
    among = (basis >= n) & (basis < 2 * n)
    active = basis[among] - n
    if active.size == 0:
        return z
    rows = np.ones(n, dtype=bool)
    rows[basis[basis < n]] = False
    # w_i = 0 on the rows without a basic slack: M_held,active z_active =
    # -q_held, in the numbers as they were given
    held = np.flatnonzero(rows)
    tableau, size = np.zeros(n), float(np.abs(problem.q).max())
    tableau[active] = size * T[among, -1]
    if held.size != active.size:
        return np.maximum(tableau, 0.0)
    try:
        z[active] = np.linalg.solve(problem.M[np.ix_(held, active)], -problem.q[held])
    except np.linalg.LinAlgError:
        return np.maximum(tableau, 0.0)
    better = problem.residual(np.maximum(z, 0.0)) <= problem.residual(np.maximum(tableau, 0.0))
    return np.maximum(z if better else tableau, 0.0)


def solve_lemke(problem: LCP, settings: SolverSettings) -> Answer:
    """Solve an LCP by Lemke's method; an iteration is a pivot."""
    if (problem.q >= 0.0).all():
        return Answer(np.zeros(problem.size), 0)
    M, d = equilibrated(problem.M)
    mantissa, exponent = np.frexp(problem.q)
    # powers of two only, which round nothing: a solution of the scaled problem is one of the problem
    top = int((exponent + d)[mantissa != 0.0].max())
    scaled = LCP(M, np.ldexp(problem.q, d - top))
    end = working_time() + settings.max_time
    limit = 50 * problem.size + 1000 if settings.max_iterations is None else settings.max_iterations
    pivots = 0
    for least in PIVOTS:
        found = _pivot_to_end(scaled, least, limit - pivots, end)
        pivots += found.iterations
        # a pivot as small as the first bound refuses may be needed after all: only then the smaller bound,
        # since small pivots spoil the tableau
        if scaled.residual(found.forces) <= settings.tol or pivots >= limit or working_time() > end:
            break
    with np.errstate(over="ignore"):
        z = np.ldexp(found.forces, d + top)
        ray = None if found.ray is None else np.ldexp(found.ray, d - int(d.max()))
    return found._replace(forces=z, iterations=pivots, ray=ray)


def _pivot_to_end(problem: LCP, least: float, limit: int, end: float) -> Answer:
    """Pivot from the start to a solution, a ray, or a limit; entries below `least` are no pivots."""
    n, q = problem.size, problem.q
    T = np.hstack([np.eye(n), -problem.M, -np.ones((n, 1)), q[:, None] / float(np.abs(q).max())])
    basis = np.arange(n)
    row = int(n - 1 - np.argmin(q[::-1]))  # ties go to the last row, the lexicographically least
    _pivot(T, row, 2 * n)
    basis[row] = 2 * n
    entering, pivots, outcome = row + n, 1, MORE
    while outcome == MORE and pivots < limit:
        outcome, used, entering = _run(T, basis, entering, min(200, limit - pivots), least)
        pivots += used
        if outcome == MORE and working_time() > end:
            return Answer(_from_basis(problem, basis, T), pivots, Status.MAX_TIME)
    if outcome == RAY:
        return _ray(problem, T, basis, entering, pivots)
    stop = Status.STALLED if outcome == DONE else Status.MAX_ITERATIONS
    return Answer(_from_basis(problem, basis, T), pivots, stop)


def _ray(problem: LCP, T: FloatArray, basis: IntArray, entering: int, pivots: int) -> Answer:
    """Return the secondary ray's direction in z, a claim of infeasibility that is still to be proven."""
    n = problem.size
    direction = np.zeros(2 * n + 1)
    # nothing blocks the entering variable: along it the basic ones move by minus its column, for ever
    direction[entering] = 1.0
    direction[basis] = -T[:, entering]
    z, slack = np.maximum(direction[n : 2 * n], 0.0), np.flatnonzero(direction[n : 2 * n] > 1e-12)
    message = f"Lemke's method left along a ray in z{slack.tolist()}"
    forces = _from_basis(problem, basis, T)
    return Answer(forces, pivots, Status.INFEASIBLE, ray=z, message=message)


@register("lemke", laws=("coulomb",), exact=False, polyhedral=True, bounds=False)
def solve_friction(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve Coulomb's law on pyramids as Stewart and Trinkle's LCP by Lemke; a (n, 3) start is unused."""
    friction = stewart_trinkle(problem)
    if friction.lcp.size == 0:
        return Answer(np.zeros((problem.contacts, 3)), 0)
    found = solve_lemke(friction.lcp, settings)
    stop = Status.STALLED if found.stop is Status.INFEASIBLE else found.stop
    return Answer(friction.forces(found.forces), found.iterations, stop)
