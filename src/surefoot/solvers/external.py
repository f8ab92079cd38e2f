"""Backends of other projects: Clarabel (exact cones) and QP solvers through qpsolvers (pyramids).

Both take the convex law. Contacts that are switched off (normal_max = 0) are left out of the
program, so that their force is exactly zero.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray, IntArray
from surefoot.cones import FrictionPyramid
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.errors import MissingExtra, SolverNotFound
from surefoot.solvers.solver import Answer, Settings, register

QP_SOLVERS = ("daqp", "quadprog", "proxqp", "osqp", "piqp", "highs")


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


def _selector(count: int, component: int) -> Any:
    """Return the sparse (count, 3 count) matrix that picks one component of every contact's force."""
    return sp.csc_matrix(
        (np.ones(count), (np.arange(count), 3 * np.arange(count) + component)), (count, 3 * count)
    )


@register("clarabel", laws=("convex",))
def solve_clarabel(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve the convex law with exact second-order cones by Clarabel's interior-point method.

    References
    ----------
    .. [1] P. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic
       objectives", 2024.
    """
    try:
        import clarabel
    except ImportError as error:
        raise MissingExtra("clarabel", "qp") from error
    on, G, g = _active(problem)
    n = on.size
    if n == 0:
        return Answer(_spread(problem, on, []), 0)
    size, length = problem.norm or 1.0, float(np.linalg.norm(g)) or 1.0
    unit = length / size  # tolerances are absolute: hand over a problem of size one
    G, g = G / size, g / length
    low, high, mu = problem.normal_min[on] / unit, problem.normal_max[on] / unit, problem.mu[on]
    blocks, bounds, cones = [], [], []
    # without friction the second-order cone says nothing of the sign of f_z
    lower, upper = np.flatnonzero((low > 0.0) | (mu == 0.0)), np.flatnonzero(np.isfinite(high))
    pick_z = _selector(n, 2)
    if lower.size + upper.size:
        blocks.append(sp.vstack([-pick_z[lower], pick_z[upper]]))
        bounds.append(np.concatenate([-low[lower], high[upper]]))
        cones.append(clarabel.NonnegativeConeT(int(lower.size + upper.size)))
    order = (np.arange(3)[None, :] * n + np.arange(n)[:, None]).ravel()  # (mu z, x, y) per contact
    stack = sp.vstack([sp.diags(mu) @ pick_z, _selector(n, 0), _selector(n, 1)]).tocsr()
    blocks.append(-stack[order])
    bounds.append(np.zeros(3 * n))
    cones += [clarabel.SecondOrderConeT(3)] * n
    options = clarabel.DefaultSettings()
    options.verbose = False
    # its stopping test is not ours: on a cone's boundary the velocity error is about the root of its gap
    options.tol_gap_abs = options.tol_gap_rel = max(settings.tol**2, 1e-16)
    options.tol_feas = max(1e-3 * settings.tol, 1e-14)
    if settings.max_iterations is not None:
        options.max_iter = settings.max_iterations
    if np.isfinite(settings.max_time):
        options.time_limit = settings.max_time
    solver = clarabel.DefaultSolver(
        sp.csc_matrix(np.triu(G)), g, sp.csc_matrix(sp.vstack(blocks)), np.concatenate(bounds), cones, options
    )
    found = solver.solve()
    forces = unit * np.asarray(found.x)
    return Answer(_spread(problem, on, forces), int(found.iterations), _clarabel_status(str(found.status)))


def _clarabel_status(text: str) -> Status:
    if "Infeasible" in text:
        return Status.INFEASIBLE
    return {"MaxIterations": Status.MAX_ITERATIONS, "MaxTime": Status.MAX_TIME}.get(text, Status.STALLED)


def pyramid_rows(problem: ContactProblem, on: IntArray) -> tuple[Any, FloatArray]:
    """Return sparse C and d so that C @ forces <= d are the pyramids and normal bounds of contacts `on`."""
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


def _tolerances(name: str, settings: Settings) -> dict[str, Any]:
    """Return each backend's own words for the tolerance and the bound on its iterations."""
    tight = max(1e-2 * settings.tol, 1e-12)
    table: dict[str, dict[str, Any]] = {
        "daqp": {"dual_tol": tight, "primal_tol": tight},
        # no polishing: where no constraint is active OSQP says so on stdout, whatever verbose is
        "osqp": {"eps_abs": tight, "eps_rel": tight, "polishing": False, "max_iter": 50_000},
        "highs": {
            "primal_feasibility_tolerance": max(tight, 1e-10),
            "dual_feasibility_tolerance": max(tight, 1e-10),
            "qp_regularization_value": 1e-11,  # its default is what would be seen of the answer
        },
        "proxqp": {"eps_abs": tight, "eps_rel": 0.0},
        "piqp": {"eps_abs": 0.01 * tight, "eps_rel": 0.01 * tight},
    }
    options = table.get(name, {})
    if settings.max_iterations is not None and name in ("osqp", "proxqp", "piqp"):
        options["max_iter"] = settings.max_iterations
    return options


def _solve_qp(
    name: str, problem: ContactProblem, settings: Settings, warm_start: FloatArray | None
) -> Answer:
    """Solve the convex law on pyramids with one QP backend."""
    try:
        import qpsolvers
    except ImportError as error:
        raise MissingExtra("qpsolvers", "qp") from error
    if name not in qpsolvers.available_solvers:
        raise SolverNotFound(f"{name} is not installed; run: pip install 'surefoot[qp]'")
    on, G, g = _active(problem)
    if on.size == 0:
        return Answer(_spread(problem, on, []), 0)
    C, d = pyramid_rows(problem, on)
    size, length = problem.norm or 1.0, float(np.linalg.norm(g)) or 1.0
    unit = length / size  # tolerances are absolute: hand over a problem of size one
    G, g, d = G / size, g / length, d / unit
    if name == "quadprog":  # its Cholesky factorisation needs a positive definite matrix
        G = G + 1e-12 * np.eye(G.shape[0])
    sparse = name in ("osqp", "highs")
    program = qpsolvers.Problem(sp.csc_matrix(G) if sparse else G, g, C if sparse else C.toarray(), d)
    start = None if warm_start is None else warm_start[on].ravel() / unit
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # backends warn through Python; our status says it
            found = qpsolvers.solve_problem(program, name, initvals=start, **_tolerances(name, settings))
    except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError):
        return Answer(_spread(problem, on, None), 0, Status.STALLED)
    forces = None if found.x is None else unit * np.asarray(found.x)
    return Answer(_spread(problem, on, forces), int(found.extras.get("iter", 0) or 0), Status.STALLED)


def _register_qp(name: str) -> None:
    @register(name, laws=("convex",), exact=False, polyhedral=True)
    def solve_with(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
        return _solve_qp(name, problem, settings, warm_start)


for _name in QP_SOLVERS:
    _register_qp(_name)
