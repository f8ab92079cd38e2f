"""Mehrotra's predictor-corrector for monotone LCPs.

Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIOPT 2, 1992; S. J.
Wright, "Primal-Dual Interior-Point Methods", 1997, chapter 8. Limits: PSD matrices (not necessarily
symmetric); on others it may stall, and says so.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from surefoot.arrays import FloatArray
from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.solvers.solver import Answer, BestPoint, SolverSettings


def solve_interior_point(problem: LCP, settings: SolverSettings) -> Answer:
    """Solve a monotone LCP by a primal-dual interior-point method."""
    scale = max(float(np.abs(problem.M).max()), 1e-300)
    M, q = problem.M / scale, problem.q / scale
    start = max(float(np.abs(q).max()), 1e-3)
    z, w = np.full(q.size, start), np.full(q.size, start)
    search = BestPoint(settings, 200, np.zeros(q.size), problem.residual(np.zeros(q.size)), 40)
    while search.done < search.limit:
        with np.errstate(all="ignore"):
            z, w = _advance(M, q, z, w)
        if not (np.isfinite(z).all() and np.isfinite(w).all()):
            return Answer(search.best, search.done + 1, Status.STALLED)
        snapped = np.where(z > w, z, 0.0)
        residuals = problem.residual(z), problem.residual(snapped)
        if search.over(snapped if residuals[1] < residuals[0] else z, min(residuals)):
            break
    return Answer(search.best, search.done, search.stop)


def _advance(M: FloatArray, q: FloatArray, z: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Take one predictor-corrector step."""
    gap = float(z @ w) / z.size
    slack = w - M @ z - q
    lu, pivots, _ = scipy.linalg.lapack.dgetrf(M + np.diag(w / z))

    def direction(target: FloatArray) -> tuple[FloatArray, FloatArray]:
        dz = scipy.linalg.lapack.dgetrs(lu, pivots, slack + target / z)[0]
        return dz, M @ dz - slack

    dz, dw = direction(-z * w)
    length = min(_longest(z, dz), _longest(w, dw))
    after = float((z + length * dz) @ (w + length * dw)) / z.size
    sigma = (after / gap) ** 3
    dz, dw = direction(sigma * gap - z * w - dz * dw)
    length = min(1.0, 0.995 * min(_longest(z, dz), _longest(w, dw)))
    return z + length * dz, w + length * dw


def _longest(x: FloatArray, dx: FloatArray) -> float:
    """Return the longest step that keeps x >= 0, at most 2."""
    down = dx < 0.0
    return min(2.0, float((-x[down] / dx[down]).min())) if down.any() else 2.0
