"""The convex law by Newton's method on its dual: what `ForceDistributor` does, for any Delassus operator.

G is split into low rank plus diagonal, G = Bᵀ B + δ I with δ its smallest eigenvalue. Where that is
(almost) zero a proximal term takes its place and the solve is repeated around its own answer, with a
smaller and smaller term (the proximal point method [1]_); every round starts from the last.

References
----------
.. [1] R. T. Rockafellar, "Monotone operators and the proximal point algorithm", SIAM Journal on Control
   and Optimization 14(5), 1976.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.residuals import residuals
from surefoot.contact.solution import Status
from surefoot.contact.solvers.dual_newton.dense import CENTRE, DUAL, VALUE, minimise
from surefoot.contact.solvers.solver import Answer, SolverSettings, register

WELL_CONDITIONED = 1e-7  # smallest over largest eigenvalue from which no proximal term is needed
PROXIMAL, LEAST_PROXIMAL, SHRINK = 1e-5, 1e-13, 0.1  # proximal weight over the largest eigenvalue
ROUNDS, NEWTON_LIMIT = 100, 200.0


@register("distribution", laws=("convex",))
def solve_distribution(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve the convex law with exact cones, from a (n, 3) warm start.

    Meant for up to some tens of contacts: an iteration factorises a matrix of the rank of G.
    """
    start = working_time()
    values, vectors = np.linalg.eigh(0.5 * (problem.G + problem.G.T))
    largest = float(values[-1]) if values[-1] > 0.0 else 1.0
    own = max(float(values[0]), 0.0)
    share = 0.0 if own >= WELL_CONDITIONED * largest else PROXIMAL
    kept = values - own > 1e-15 * largest
    # G = root rootᵀ + own I: the identity goes into the forces' own term, what is left has the rank of G
    root = np.ascontiguousarray(vectors[:, kept] * np.sqrt(values[kept] - own))
    n, m = problem.contacts, root.shape[1]
    sets, points = np.zeros((n, 4)), np.zeros((5, 3 * n))
    duals, H = np.zeros((5, m)), np.zeros((m, m))
    forces = np.zeros((n, 3)) if warm_start is None else warm_start.copy()
    best, best_residual, iterations, stop = forces, np.inf, 0, Status.MAX_ITERATIONS
    limit = float(settings.max_iterations if settings.max_iterations is not None else 10_000)
    duals[DUAL] = -(root.T @ forces.ravel())
    for turn in range(ROUNDS):
        weight = own + share * largest
        unit = 1.0 / np.sqrt(weight)
        sets[:, 0], sets[:, 1], sets[:, 2] = problem.mu, problem.normal_min / unit, problem.normal_max / unit
        points[CENTRE] = unit * (share * largest * forces.ravel() - problem.g)
        # ||F||² of the scaled dual against a tenth of the wanted velocity, over G's largest eigenvalue:
        # velocities are G times what the forces are wrong by
        tol = (0.1 * settings.tol * float(np.linalg.norm(problem.g)) / (largest * unit)) ** 2
        warm = turn > 0 or warm_start is not None
        error, floor, used = minimise(
            root * unit, sets, points, duals, H, warm, tol, min(NEWTON_LIMIT, limit - iterations)
        )
        iterations += used
        last, forces = forces, (points[VALUE] * unit).reshape(n, 3)
        # the velocity that the proximal term still adds: the residual hardly sees soft directions
        drift = share * largest * float(np.linalg.norm(forces - last))
        residual = residuals(problem, forces).worst
        if not np.isfinite(residual):
            stop = Status.STALLED
            break
        if residual < best_residual:
            best, best_residual = forces, residual
        if share == 0.0 or iterations >= limit:
            break
        if best_residual <= settings.tol and drift <= settings.tol * float(np.linalg.norm(problem.g)):
            break
        if working_time() - start > settings.max_time:
            stop = Status.MAX_TIME
            break
        # the smaller the weight the fewer the rounds, as long as Newton can follow
        share = max(SHRINK * share, LEAST_PROXIMAL) if error <= max(tol, floor) else min(share / SHRINK, 1.0)
    return Answer(best, iterations, stop)
