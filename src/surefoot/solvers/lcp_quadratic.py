"""A positive semidefinite LCP as the quadratic program min zᵀ(M z + q) over z >= 0, M z + q >= 0.

For a symmetric M the optimality conditions of min 1/2 zᵀMz + qᵀz over z >= 0 are the LCP itself. Source:
Cottle, Pang, Stone 2009, section 1.4. Limits: PSD matrices only (it says so for others); needs the `qp`
extra.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.errors import MissingExtra
from surefoot.solvers.lcp import LcpAnswer, register_lcp
from surefoot.solvers.solver import Settings


@register_lcp("qp")
def solve_quadratic(problem: LCP, settings: Settings) -> LcpAnswer:
    """Solve a PSD LCP as a QP, by Clarabel."""
    try:
        import clarabel
    except ImportError as error:
        raise MissingExtra("clarabel", "qp") from error
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
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = max(1e-3 * settings.tol, 1e-13)
    if settings.max_iterations is not None:
        options.max_iter = settings.max_iterations
    if np.isfinite(settings.max_time):
        options.time_limit = settings.max_time
    upper = sp.csc_matrix(np.triu(H))
    cones = [clarabel.NonnegativeConeT(b.size)]
    found = clarabel.DefaultSolver(upper, q, sp.csc_matrix(A), b, cones, options).solve()
    z = np.maximum(np.asarray(found.x), 0.0) * size / scale
    w = problem.M @ z + problem.q
    snapped = np.where(z * scale > w, z, 0.0)
    z = snapped if problem.residual(snapped) < problem.residual(z) else z
    text = str(found.status)
    if "Infeasible" in text:  # the multipliers of M z + q >= 0 are the Farkas vector
        dual = np.asarray(found.z)
        return LcpAnswer(z, int(found.iterations), Status.INFEASIBLE, None if symmetric else dual[n:])
    return LcpAnswer(z, int(found.iterations), Status.STALLED)
