"""Mehrotra's predictor-corrector for monotone LCPs.

Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIOPT 2, 1992; S. J.
Wright, "Primal-Dual Interior-Point Methods", 1997, chapter 8. Limits: PSD matrices (not necessarily
symmetric); on others it may stall, and says so.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.contact.solvers.solver import Answer, SolverSettings

MOST, PATIENCE = 200, 40
"""Iterations, and those in which the residual has to fall by a tenth now and then."""


def solve_interior_point(problem: LCP, settings: SolverSettings) -> Answer:
    """Solve a monotone LCP by a primal-dual interior-point method."""
    # one scale for M and q leaves z as it is: tolerances and starts are for entries of size one
    scale = max(float(np.abs(problem.M).max()), 1e-300)
    M, q = problem.M / scale, problem.q / scale
    start = max(float(np.abs(q).max()), 1e-3)
    z, w = np.full(q.size, start), np.full(q.size, start)
    limit = MOST if settings.max_iterations is None else settings.max_iterations
    end, best, idle = working_time() + settings.max_time, np.zeros(q.size), 0
    error = problem.residual(best)
    for done in range(1, limit + 1):
        with np.errstate(all="ignore"):
            z, w = _advance(M, q, z, w)
        if not (np.isfinite(z).all() and np.isfinite(w).all()):
            return Answer(best, done, Status.STALLED)
        # an interior point has no zeros: z_i = 0 wherever w_i is larger is
        # judged beside it, and mostly is nearer
        snapped = np.where(z > w, z, 0.0)
        residuals = problem.residual(z), problem.residual(snapped)
        idle = 0 if min(residuals) < 0.9 * error else idle + 1
        if min(residuals) < error:
            best, error = (snapped if residuals[1] < residuals[0] else z), min(residuals)
        if error <= settings.tol:
            return Answer(best, done)
        if idle > PATIENCE or working_time() > end:
            return Answer(best, done, Status.STALLED if idle > PATIENCE else Status.MAX_TIME)
    return Answer(best, limit, Status.MAX_ITERATIONS)


def _advance(M: FloatArray, q: FloatArray, z: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Take one predictor-corrector step."""
    gap = float(z @ w) / z.size
    # an infeasible start: every full step takes the equation's residual out
    slack = w - M @ z - q
    lu, pivots, _ = scipy.linalg.lapack.dgetrf(M + np.diag(w / z))

    def direction(target: FloatArray) -> tuple[FloatArray, FloatArray]:
        dz = scipy.linalg.lapack.dgetrs(lu, pivots, slack + target / z)[0]
        return dz, M @ dz - slack

    dz, dw = direction(-z * w)
    length = min(_longest(z, dz), _longest(w, dw))
    after = float((z + length * dz) @ (w + length * dw)) / z.size
    # Mehrotra's rule: centre little where the predictor got far
    sigma = (after / gap) ** 3
    # the corrector makes up for the product dz dw that linearisation dropped, with the predictor's own
    dz, dw = direction(sigma * gap - z * w - dz * dw)
    # 0.5 % short of the boundary: z and w stay positive
    length = min(1.0, 0.995 * min(_longest(z, dz), _longest(w, dw)))
    return z + length * dz, w + length * dw


def _longest(x: FloatArray, dx: FloatArray) -> float:
    """Return the longest step that keeps x >= 0, at most 2."""
    down = dx < 0.0
    return min(2.0, float((-x[down] / dx[down]).min())) if down.any() else 2.0
