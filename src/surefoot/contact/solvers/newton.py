"""Semismooth Newton as a solver of its own, on the equations that suit the contacts.

Exact cones of three rows take the steps of Alart and Curnier (`newton_step`): up to 128 contacts in the
compiled call of `auto`, with one sweep before the first step and twice as many before each further attempt;
above, steps by sparse factorisation with one sweep before each attempt. Contacts of any other kind, and
other laws, take steps on the natural map λ - P_K(λ - (u + θ Γ(u)) / w) = 0: full ones, with a small proximal
term that keeps redundant contacts solvable; the velocity error judges them and the best point is kept. By
itself a local method; in `auto` ADMM finds out who slides, and these steps finish from where it is.

Source: L. Qi, J. Sun, "A nonsmooth version of Newton's method", Math. Programming 58, 1993; P. Alart, A.
Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods", CMAME
92, 1991.

Limits: see `newton_step` and `newton_sparse`; on the natural map fast near a solution and no promise far from
one, with dense matrices.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.compiled import SOON, UNBOUNDED, attempt
from surefoot.contact.solvers.newton_sparse import BlockNewton
from surefoot.contact.solvers.newton_step import PROXIMAL_SHARES
from surefoot.contact.solvers.scaled import ScaledContacts
from surefoot.contact.solvers.set_kernels import WIDEST, jacobian_sets, newton_matrix, project_sets
from surefoot.contact.solvers.solver import Answer, SolverSettings, register, start_forces

ROUNDS = 40
"""Attempts on many contacts, a sweep before each."""
NATURAL_STEPS, NATURAL_PATIENCE = 100, 12
"""Steps on the natural map at most, and those that may pass without a better velocity error."""
PROXIMAL, PROXIMAL_FAR, SHARE = 1e-11, 1e-2, 1e-2
"""The proximal term on the natural map: a share of the velocity error, within bounds."""


@register("newton", laws=None, polyhedral=True, bilateral=True, general=True)
def solve_newton(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve contacts of any kind as far as Newton gets from a warm start (n, 3), (n, d) or (m,).

    An iteration is a Newton step or a sweep.
    """
    limit, end = settings.max_iterations, working_time() + settings.max_time
    if problem.general or problem.facets is not None:
        scaled = ScaledContacts(problem)
        start = start_forces(problem, warm_start) / scaled.D
        most = NATURAL_STEPS if limit is None else limit
        forces, _, done = on_natural_map(scaled, start, settings.tol, most, end)
        return Answer(forces.reshape(problem.shape), done, _stop(done, most, end))
    found = attempt(problem, settings.tol, limit, settings.max_time, warm_start, SOON)
    if found is not None:
        record, used, _, fits = found
        stop = Status.STALLED
        if used >= fits:
            stop = Status.MAX_ITERATIONS if fits == limit else Status.MAX_TIME
        return Answer(record[: problem.contacts], used, stop)
    forces = start_forces(problem, warm_start)
    most = UNBOUNDED if limit is None else limit
    newton, done = BlockNewton(problem, settings.tol, end), 0
    for turn in range(ROUNDS):
        if done >= most or working_time() > end:
            break
        # a sweep finds out who slides anew, another share of the proximal
        # term each turn goes elsewhere from there
        done += newton.sweep(forces, 1)
        steps, relative = newton.run(forces, min(30, most - done), PROXIMAL_SHARES[turn % 3])
        done += steps
        if relative <= settings.tol:
            break
    return Answer(forces.reshape(-1, 3), done, _stop(done, most, end))


def _stop(done: int, most: int, end: float) -> Status:
    if working_time() > end:
        return Status.MAX_TIME
    return Status.MAX_ITERATIONS if done >= most else Status.STALLED


def on_natural_map(
    s: ScaledContacts, forces: FloatArray, tol: float, limit: int, end: float
) -> tuple[FloatArray, float, int]:
    """Take steps from scaled forces (m,); return the best, not scaled, its velocity error, and the steps."""
    m, n = forces.size, s.step.size
    J, A = np.empty((n, WIDEST, WIDEST)), np.empty((m, m))
    u, error = s.measure(forces)
    best, least, done, since = forces, error, 0, 0
    admissible = np.empty(m)

    def beside(point: FloatArray) -> float:
        project_sets(*s.packed, point, admissible)
        return s.measure(admissible)[1]

    while done < limit and since < NATURAL_PATIENCE and working_time() < end:
        if error <= tol:
            # the point of the sets beside it: what is left of the natural map goes into the velocities, which
            # may take another step
            left = beside(forces)
            if left <= tol:
                return admissible * s.D, left, done
            u, error = s.measure(forces)
        jacobian_sets(*s.packed, s.point, J)
        newton_matrix(s.G, *s.packed, s.step, u, J, A)
        # redundant contacts make A singular; the term shrinks with the error, so
        # that the last steps are Newton's own
        A[np.diag_indices(m)] += min(max(SHARE * error, PROXIMAL), PROXIMAL_FAR)
        try:
            forces = forces - np.linalg.solve(A, s.gap)
        except np.linalg.LinAlgError:
            break
        u, error = s.measure(forces)
        done, since = done + 1, since + 1
        if error < least:
            # progress by less than a tenth counts as none
            since = 0 if error < 0.9 * least else since
            best, least = forces, error
        if not np.isfinite(error):
            break
    error = beside(best)
    if error <= max(least, tol):
        best, least = admissible, error
    return best * s.D, least, done
