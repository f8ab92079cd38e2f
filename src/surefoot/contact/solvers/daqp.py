"""The convex law on pyramids as a quadratic program, by DAQP's dual active-set method (extra `qp`).

What ADMM leaves within rounding of a pyramid's edges an active set decides: of 434 problems `auto` solves
402 with this stage and 390 without. Contacts that are switched off (normal_max = 0) are left out of the
program, so that their force is exactly zero.

Source: D. Arnström, A. Bemporad, D. Axehill, "A dual active-set solver for embedded quadratic programming
using recursive LDLᵀ updates", IEEE TAC 67(8), 2022.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.backends import ConeProgram, Options, backend
from surefoot.contact.solvers.backends.program import Rows
from surefoot.contact.solvers.solver import Answer, SolverSettings, register


def pyramid_rows(problem: ContactProblem, on: IntArray) -> Rows:
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


@register("daqp", laws=("convex",), exact=False, polyhedral=True)
def solve_daqp(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve the convex law on pyramids; a (n, 3) start is unused."""
    forces = np.zeros((problem.contacts, 3))
    on = np.flatnonzero(problem.normal_max > 0.0)
    if on.size == 0:
        return Answer(forces, 0)
    rows = (3 * on[:, None] + np.arange(3)).ravel()
    # tolerances are absolute: G and g of size one
    size, length = problem.norm or 1.0, float(np.linalg.norm(problem.g[rows])) or 1.0
    G, unit = problem.G[np.ix_(rows, rows)] / size, length / size
    C, d = pyramid_rows(problem, on)
    program = ConeProgram.of(0.5 * (G + G.T), problem.g[rows] / length, nonneg=(C, d / unit))
    tight = max(1e-2 * settings.tol, 1e-12)
    found = backend("daqp", Options(tight, settings.max_iterations, settings.max_time)).solve(program)
    forces[on] = np.nan if found.x is None else unit * found.x.reshape(-1, 3)
    return Answer(forces, found.iterations, Status.STALLED)
