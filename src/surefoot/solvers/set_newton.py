"""Semismooth Newton for contacts of any kind, on the natural map λ - P_K(λ - (u + θ Γ(u)) / w) = 0.

Steps are full, with a small proximal term that keeps redundant contacts solvable; the velocity error judges
them and the best point is kept. By itself a local method; in `auto` ADMM finds out who slides, and these
steps finish from where it is.

Source: L. Qi, J. Sun, "A nonsmooth version of Newton's method", Math. Programming 58, 1993; P. Alart, A.
Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods", CMAME
92, 1991.

Limits: fast near a solution and no promise far from one; dense matrices.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import working_time
from surefoot.solvers.set_admm import Sets
from surefoot.solvers.set_kernels import WIDEST, jacobian_sets, newton_matrix, project_sets
from surefoot.solvers.solver import Answer, SolverSettings, register

MAX_ITERATIONS, PATIENCE = 100, 12
PROXIMAL, PROXIMAL_FAR, SHARE = 1e-11, 1e-2, 1e-2
"""The proximal term: a share of the velocity error, within bounds."""


def run_newton(
    s: Sets, forces: FloatArray, tol: float, limit: int, end: float
) -> tuple[FloatArray, float, int]:
    """Take steps from scaled forces (m,); return the best, its velocity error, and the number of steps."""
    m, n = forces.size, s.step.size
    J, A = np.empty((n, WIDEST, WIDEST)), np.empty((m, m))
    u, error = s.measure(forces)
    best, least, done, since = forces, error, 0, 0
    while least > tol and done < limit and since < PATIENCE and working_time() < end:
        jacobian_sets(*s.packed, s.point, J)
        newton_matrix(s.G, *s.packed, s.step, u, J, A)
        A[np.diag_indices(m)] += min(max(SHARE * error, PROXIMAL), PROXIMAL_FAR)
        try:
            forces = forces - np.linalg.solve(A, s.gap)
        except np.linalg.LinAlgError:
            break
        u, error = s.measure(forces)
        done, since = done + 1, since + 1
        if error < least:
            since = 0 if error < 0.9 * least else since
            best, least = forces, error
        if not np.isfinite(error):
            break
    # a point of the sets: what is left of the natural map goes into the velocities
    admissible = np.empty(m)
    project_sets(*s.packed, best, admissible)
    error = s.error(admissible)
    return (admissible, error, done) if error <= max(least, tol) else (best, least, done)


@register("set_newton", laws=None, polyhedral=True, bilateral=True, general=True)
def solve_set_newton(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve contacts of any kind, under any law, as far as Newton's method gets from (n, d), (m,) forces."""
    s = Sets(problem, warm_start)
    end = working_time() + settings.max_time
    limit = MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations
    forces, _, done = run_newton(s, s.z, settings.tol, limit, end)
    stop = Status.MAX_ITERATIONS if done >= limit else Status.STALLED
    return Answer(forces * s.D, done, Status.MAX_TIME if working_time() > end else stop)
