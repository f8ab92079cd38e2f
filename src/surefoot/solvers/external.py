"""Solvers of other projects for contact problems: Clarabel (exact cones) and QP solvers (pyramids).

Each is driven by its file in `backends/`. Both take the convex law. Contacts that are switched off
(normal_max = 0) are left out of the program, so that their force is exactly zero.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray, IntArray
from surefoot.cones import FrictionPyramid
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.solvers.backends import BACKENDS, ConeProgram, End, Options, backend
from surefoot.solvers.solver import Answer, SolverSettings, register

QP_SOLVERS = ("daqp", "quadprog", "proxqp", "osqp", "piqp", "highs")
STATUS_OF = dict.fromkeys(End, Status.STALLED) | {
    End.INFEASIBLE: Status.INFEASIBLE,
    End.ALMOST_INFEASIBLE: Status.INFEASIBLE,
    End.UNBOUNDED: Status.INFEASIBLE,
    End.MAX_ITERATIONS: Status.MAX_ITERATIONS,
    End.MAX_TIME: Status.MAX_TIME,
}
"""What a solver's own word counts for; whether it is SOLVED is for the residuals to say."""


def _active(problem: ContactProblem) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the contacts that may carry force, and G and g on them."""
    on = np.flatnonzero(problem.normal_max > 0.0)
    rows = (3 * on[:, None] + np.arange(3)).ravel()
    G = problem.G[np.ix_(rows, rows)]
    return on, 0.5 * (G + G.T), problem.g[rows]


def _spread(problem: ContactProblem, on: IntArray, active: Any) -> FloatArray:
    """Return (n, 3) forces from those of the active contacts; NaN where the solver gave none."""
    forces = np.zeros((problem.contacts, 3))
    forces[on] = np.nan if active is None else np.asarray(active, dtype=np.float64).reshape(-1, 3)
    return forces


def _scaled(problem: ContactProblem, G: FloatArray, g: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return G and g of size one, and the unit of force [N·s] that goes with it: tolerances are absolute."""
    size, length = problem.norm or 1.0, float(np.linalg.norm(g)) or 1.0
    return G / size, g / length, length / size


@register("clarabel", laws=("convex",))
def solve_clarabel(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve the convex law on exact cones by Clarabel's interior-point method; a (n, 3) start is unused."""
    on, G, g = _active(problem)
    n = on.size
    if n == 0:
        return Answer(_spread(problem, on, []), 0)
    G, g, unit = _scaled(problem, G, g)
    low, high, mu = problem.normal_min[on] / unit, problem.normal_max[on] / unit, problem.mu[on]
    # without friction the second-order cone says nothing of the sign of f_z
    lower = np.flatnonzero((low > 0.0) | (mu == 0.0))
    pick_z = sp.identity(3 * n, format="csr")[2::3]
    bounds = sp.vstack([-pick_z[lower], pick_z], format="csr"), np.concatenate([-low[lower], high])
    cones = sp.block_diag([[[0.0, 0.0, m], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] for m in mu], format="csr")
    program = ConeProgram.of(G, g, nonneg=bounds, second_order=(-cones, np.zeros(3 * n)))
    # its stopping test is not ours: on a cone's boundary the velocity error is about the root of its gap
    gap = max(settings.tol**2, 1e-16)
    own = {"tol_gap_abs": gap, "tol_gap_rel": gap, "tol_feas": max(1e-3 * settings.tol, 1e-14)}
    options = Options(None, settings.max_iterations, settings.max_time, own=own)
    found = backend("clarabel", options).solve(program)
    assert found.x is not None
    return Answer(_spread(problem, on, unit * found.x), found.iterations, STATUS_OF[found.end])


def pyramid_rows(problem: ContactProblem, on: IntArray) -> tuple[Any, FloatArray]:
    """Return sparse C (r, 3 on) and d (r,): C f <= d are the pyramids and normal bounds of contacts `on`."""
    blocks: list[FloatArray] = []
    limits: list[FloatArray] = []
    down_up = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    for k in on:
        rows = FrictionPyramid(float(problem.mu[k]), problem.facets or 8, problem.fit).halfspaces
        keep = np.array([problem.normal_min[k] > 0.0, np.isfinite(problem.normal_max[k])])
        blocks.append(np.vstack([rows, down_up[keep]]))
        ends = np.array([-problem.normal_min[k], problem.normal_max[k]])
        limits.append(np.concatenate([np.zeros(rows.shape[0]), ends[keep]]))
    return sp.block_diag(blocks, format="csc"), np.concatenate(limits)


def _options(name: str, settings: SolverSettings) -> Options:
    """Return how a QP solver is run: to less than the tolerance, and what it needs besides."""
    kind = BACKENDS[name]
    tight = max(kind.sharpness * settings.tol, 1e-10 * kind.sharpness)
    most = settings.max_iterations or kind.iterations or settings.max_iterations
    return Options(tight, most, settings.max_time, own=kind.contact_words)


def _solve_qp(
    name: str, problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve the convex law on pyramids with one QP backend."""
    solver = backend(name, _options(name, settings))
    on, G, g = _active(problem)
    if on.size == 0:
        return Answer(_spread(problem, on, []), 0)
    C, d = pyramid_rows(problem, on)
    G, g, unit = _scaled(problem, G, g)
    if solver.ridge > 0.0:
        G = G + solver.ridge * np.eye(G.shape[0])
    start = None if warm_start is None else warm_start[on].ravel() / unit
    found = solver.solve(ConeProgram.of(G, g, nonneg=(C, d / unit)), start)
    forces = None if found.x is None else unit * found.x
    return Answer(_spread(problem, on, forces), found.iterations, Status.STALLED)


for _name in QP_SOLVERS:
    register(_name, laws=("convex",), exact=False, polyhedral=True)(partial(_solve_qp, _name))
