"""Damped semismooth Newton on the Fischer-Burmeister equations of an LCP.

phi(z, w) = sqrt(z² + w²) - z - w vanishes exactly where z >= 0, w >= 0, z w = 0; its squared norm is
smooth, so a line search and, where Newton's direction fails, its gradient globalise the method. The linear
system is regularised as Levenberg and Marquardt do when it is near singular.

Source: T. De Luca, F. Facchinei, C. Kanzow, "A semismooth equation approach to the solution of nonlinear
complementarity problems", Mathematical Programming 75, 1996.

Limits: finds stationary points of the merit function, which are solutions for P0 matrices only.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.solvers.lcp import LcpAnswer, register_lcp
from surefoot.solvers.solver import Search, SolverSettings


def _equations(z: FloatArray, w: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(z, w) - z - w)


@register_lcp("newton")
def solve_newton(problem: LCP, settings: SolverSettings) -> LcpAnswer:
    """Solve an LCP by damped Newton steps on the Fischer-Burmeister equations."""
    scale = max(float(np.abs(problem.M).max()), 1e-300)
    M, q = problem.M / scale, problem.q / scale
    z = np.zeros(problem.size)
    w = q.copy()
    phi = _equations(z, w)
    search = Search(settings, 200, z, problem.residual(z), np.inf)
    while search.done < search.limit:
        root = np.hypot(z, w)
        smooth = root > 1e-14 * max(1.0, float(np.abs(q).max()))
        safe = np.where(smooth, root, 1.0)
        a = np.where(smooth, z / safe, 0.5**0.5) - 1.0
        b = np.where(smooth, w / safe, 0.5**0.5) - 1.0
        J = np.diag(a) + b[:, None] * M
        gradient = J.T @ phi
        merit = 0.5 * float(phi @ phi)
        step = _direction(J, phi, gradient)
        length = 1.0
        while length > 1e-10:
            trial = z + length * step
            slack = M @ trial + q
            new = _equations(trial, slack)
            if 0.5 * float(new @ new) <= merit + 1e-4 * length * float(gradient @ step):
                break
            length *= 0.5
        z, w, phi = trial, slack, new
        point = np.maximum(z, 0.0)
        if search.over(point, problem.residual(point)):
            break
        if length <= 1e-10:
            message = "a stationary point that is no solution"
            return LcpAnswer(search.best, search.done, Status.STALLED, None, message)
    return LcpAnswer(search.best, search.done, search.stop)


def _direction(J: FloatArray, phi: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return Newton's direction if it descends well, else a Levenberg-Marquardt one."""
    try:
        step = np.linalg.solve(J, -phi)
        slope = float(gradient @ step)
        if np.isfinite(step).all() and slope <= -1e-8 * float(step @ step) ** 1.05:
            return np.asarray(step)
    except np.linalg.LinAlgError:
        pass
    damping = 1e-8 + 0.1 * float(np.linalg.norm(phi))
    return np.asarray(np.linalg.solve(J.T @ J + damping * np.eye(phi.size), -gradient))
