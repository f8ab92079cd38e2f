"""Projected Gauss-Seidel (and SOR) for LCPs.

Source: C. W. Cryer, "The solution of a quadratic programming problem using systematic overrelaxation",
SICON 9, 1971. Limits: converges for symmetric positive definite (with a solution also semidefinite) and for
diagonally dominant matrices; needs a positive diagonal; linear rate.
"""

from __future__ import annotations

import time

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.kernels import kernel
from surefoot.solvers.lcp import LcpAnswer, register_lcp
from surefoot.solvers.solver import SolverSettings


@kernel
def _sweeps(M: FloatArray, q: FloatArray, z: FloatArray, count: int) -> float:
    """Run `count` sweeps in place; return the largest change of the last one, infinite if it blows up."""
    change = 0.0
    for _ in range(count):
        change = 0.0
        for i in range(q.size):
            w = q[i]
            for j in range(q.size):
                w += M[i, j] * z[j]
            new = max(0.0, z[i] - w / M[i, i])
            change = max(change, abs(new - z[i]))
            z[i] = new
        if not change < 1e150:
            return np.inf
    return change


@register_lcp("pgs")
def solve_pgs(problem: LCP, settings: SolverSettings) -> LcpAnswer:
    """Solve an LCP by projected Gauss-Seidel; an iteration is a sweep."""
    if not (np.diagonal(problem.M) > 0.0).all():
        return LcpAnswer(
            np.zeros(problem.size), 0, Status.STALLED, None, "a diagonal entry of M is not positive"
        )
    limit = 20_000 if settings.max_iterations is None else settings.max_iterations
    end = time.perf_counter() + settings.max_time
    z, done = np.zeros(problem.size), 0
    while done < limit:
        count = min(20, limit - done)
        change = _sweeps(problem.M, problem.q, z, count)
        done += count
        if change == np.inf:
            return LcpAnswer(np.zeros(problem.size), done, Status.STALLED, None, "the sweeps diverge")
        if problem.residual(z) <= settings.tol:
            break
        if change == 0.0:
            return LcpAnswer(z, done, Status.STALLED)
        if time.perf_counter() > end:
            return LcpAnswer(z, done, Status.MAX_TIME)
    return LcpAnswer(z, done)
