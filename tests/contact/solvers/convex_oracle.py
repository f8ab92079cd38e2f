"""The convex law by Clarabel: the cone program that it is."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.contact.solvers.backends import ConeProgram, Options, backend


def convex_forces(problem: sf.ContactProblem, tol: float) -> FloatArray:
    """Return the (n, 3) forces of the convex law, within the bounds on normal forces."""
    n, size, length = problem.contacts, np.abs(problem.G).max(), np.linalg.norm(problem.g)
    pick = sp.identity(3 * n, format="csr")[2::3]
    unit = length / size
    bounds = sp.vstack([-pick, pick]), np.concatenate([-problem.normal_min, problem.normal_max]) / unit
    cones = sp.block_diag([[[0.0, 0.0, -m], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] for m in problem.mu])
    program = ConeProgram.of(
        problem.G / size, problem.g / length, nonneg=bounds, second_order=(cones.tocsr(), np.zeros(3 * n))
    )
    gap = max(tol**2, 1e-16)  # on a cone's boundary the velocity error is about the root of its gap
    own = {"tol_gap_abs": gap, "tol_gap_rel": gap, "tol_feas": max(1e-3 * tol, 1e-14)}
    found = backend("clarabel", Options(own=own)).solve(program)
    assert found.x is not None
    return np.asarray(unit * found.x).reshape(-1, 3)
