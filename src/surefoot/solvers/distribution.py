"""The convex law by Newton's method on its dual: what `ForceDistributor` does, for any Delassus operator.

G is split into low rank plus diagonal, G = Bᵀ B + δ I with δ its smallest eigenvalue. Where that is
(almost) zero a proximal term takes its place, in the metric of G's largest eigenvalue, and the solve is
repeated around its own answer (the proximal point method [1]_); every round starts from the last.

References
----------
.. [1] R. T. Rockafellar, "Monotone operators and the proximal point algorithm", SIAM Journal on Control
   and Optimization 14(5), 1976.
"""

from __future__ import annotations

import time

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.residuals import residuals
from surefoot.contact.solution import Status
from surefoot.solvers.distribution_newton import CENTRE, DUAL, TARGET, VALUE, minimise
from surefoot.solvers.solver import Answer, Settings, register

WELL_CONDITIONED = 1e-7  # smallest over largest eigenvalue from which no proximal term is needed
PROXIMAL = 1e-5  # proximal weight over the largest eigenvalue
ROUNDS, NEWTON_LIMIT = 100, 200.0


@register("distribution", laws=("convex",))
def solve_distribution(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve the convex law with exact cones.

    Meant for up to some tens of contacts: an iteration factorises a matrix of the rank of G.
    """
    start = time.perf_counter()
    values, vectors = np.linalg.eigh(0.5 * (problem.G + problem.G.T))
    largest = float(values[-1]) if values[-1] > 0.0 else 1.0
    own = max(float(values[0]), 0.0)
    proximal = 0.0 if own >= WELL_CONDITIONED * largest else PROXIMAL * largest
    kept = values - own > 1e-15 * largest
    weight = own + proximal
    unit = 1.0 / np.sqrt(weight)
    columns = np.ascontiguousarray(vectors[:, kept] * (unit * np.sqrt(values[kept] - own)))
    n, m = problem.contacts, columns.shape[1]
    sets = np.zeros((n, 4))
    sets[:, 0], sets[:, 1], sets[:, 2] = problem.mu, problem.normal_min / unit, problem.normal_max / unit
    points, duals, H = np.zeros((5, 3 * n)), np.zeros((5, m)), np.zeros((m, m))
    forces = np.zeros((n, 3)) if warm_start is None else warm_start.copy()
    best, best_residual, iterations, stop = forces, np.inf, 0, Status.MAX_ITERATIONS
    limit = float(settings.max_iterations if settings.max_iterations is not None else 10_000)
    fixed = -unit * problem.g
    tol = (0.1 * settings.tol * float(np.linalg.norm(problem.g)) / (largest * unit)) ** 2
    duals[DUAL] = -(columns.T @ (forces.ravel() / unit))
    for turn in range(ROUNDS):
        points[CENTRE] = fixed + (proximal / weight) * forces.ravel() / unit
        duals[TARGET] = 0.0
        warm = turn > 0 or warm_start is not None
        _, _, used = minimise(columns, sets, points, duals, H, warm, tol, min(NEWTON_LIMIT, limit))
        iterations += used
        forces = (points[VALUE] * unit).reshape(n, 3)
        residual = residuals(problem, forces).natural_map
        if not np.isfinite(residual):
            stop = Status.STALLED
            break
        if residual < best_residual:
            best, best_residual = forces, residual
        if best_residual <= settings.tol or proximal == 0.0 or iterations >= limit:
            break
        if time.perf_counter() - start > settings.max_time:
            stop = Status.MAX_TIME
            break
    return Answer(best, iterations, stop)
