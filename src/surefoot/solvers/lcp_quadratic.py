"""A positive semidefinite LCP as the quadratic program min zᵀ(M z + q) over z >= 0, M z + q >= 0.

For a symmetric M the optimality conditions of min 1/2 zᵀMz + qᵀz over z >= 0 are the LCP itself. Source:
Cottle, Pang, Stone 2009, section 1.4. Limits: PSD matrices only (it says so for others); needs the `qp`
extra.
"""

from __future__ import annotations

import numpy as np

from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.solvers.backends import ConeProgram, End, Options, backend
from surefoot.solvers.lcp import LcpAnswer, register_lcp
from surefoot.solvers.solver import SolverSettings


@register_lcp("qp")
def solve_quadratic(problem: LCP, settings: SolverSettings) -> LcpAnswer:
    """Solve a PSD LCP as a QP, by Clarabel."""
    n = problem.size
    scale = max(float(np.abs(problem.M).max()), 1e-300)
    size = max(float(np.abs(problem.q).max()), 1e-300)
    M, q = problem.M / scale, problem.q / size
    symmetric = bool(np.abs(M - M.T).max() <= 1e-12)
    H = M if symmetric else M + M.T
    if float(np.linalg.eigvalsh(H).min()) < -1e-9 * n:
        message = "M is not positive semidefinite: as a QP it would not be convex"
        return LcpAnswer(np.zeros(n), 0, Status.STALLED, None, message)
    A = -np.eye(n) if symmetric else np.vstack([-np.eye(n), -M])
    b = np.zeros(n) if symmetric else np.concatenate([np.zeros(n), q])
    options = Options(max(1e-3 * settings.tol, 1e-13), settings.max_iterations, settings.max_time)
    found = backend("clarabel", options).solve(ConeProgram.of(H, q, nonneg=(A, b)))
    assert found.x is not None
    assert found.y is not None
    z = np.maximum(found.x, 0.0) * size / scale
    w = problem.M @ z + problem.q
    snapped = np.where(z * scale > w, z, 0.0)
    z = snapped if problem.residual(snapped) < problem.residual(z) else z
    if found.end in (End.INFEASIBLE, End.ALMOST_INFEASIBLE, End.UNBOUNDED):
        # the multipliers of M z + q >= 0 are the Farkas vector
        return LcpAnswer(z, found.iterations, Status.INFEASIBLE, None if symmetric else found.y[n:])
    return LcpAnswer(z, found.iterations, Status.STALLED)
