"""Clarabel's forces to about 1e-7 N: its answer refined around itself, written so that nothing cancels.

Asked once, in the forces alone, Clarabel at 1e-10 leaves up to 1e-2 N in the forces, for three reasons:
the matrix AᵀWA + r I squares the grasp map's conditioning; its gap counts against the objective, of which
a small force weight makes the forces a tiny part; and a force on its cone's side has the slack
(mu f_z)² - ||f_t||², a difference of large numbers. Hence here

- the wrench's residual is an unknown of its own, the Hessian is the identity and A appears in equality rows;
- the unknown is the change from the last answer, in a smaller and smaller unit, so that the same
  tolerance counts for fewer and fewer newtons;
- the cone is written as a 2x2 matrix that must be positive semidefinite, turned to the last answer:
  with p, q the parts of f_t along and across it, ``[[mu f_z - p, q], [q, mu f_z + p]]``. Its small entry is
  small by itself and not by subtraction.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from benchmarks.problems.allocation_program import cone_rows, program
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.arrays import FloatArray
from surefoot.numerics.projection import project_truncated
from surefoot.solvers.backends import ConeProgram, Options, backend

UNITS = (1.0, 0.1, 0.01, 1e-3, 0.1, 0.01, 1e-3)
"""Of the change from one round to the next."""
TOLERANCE, GOOD = 1e-10, 1e-7
"""Clarabel's own, and the fixed-point residual [N] from which no further round is made."""
REGULARISATION = 1e-12
"""Clarabel's own of 1e-8 is for problems of worse scale than these."""


def fixed_point_residual(instance: Instance, forces: FloatArray, force_weight: float) -> float:
    """Return ||f - P(AᵀW(w - A f) / r)|| [N], which is zero at the optimum only.

    About the distance to the optimum, since the force weight r is the objective's least curvature.
    """
    missing = instance.wrench - instance.grasp_map @ forces.ravel()
    pulled = instance.grasp_map.T @ (WRENCH_WEIGHTS * missing) / force_weight
    cones = zip(instance.mu, instance.normal_min, instance.normal_max, strict=True)
    nearest = [
        project_truncated(x, y, z, mu, low, high)
        for (x, y, z), (mu, low, high) in zip(pulled.reshape(-1, 3), cones, strict=True)
    ]
    return float(np.linalg.norm(np.asarray(nearest) - forces))


def turned_cones(forces: FloatArray, mu: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return T (3a, 3a) and t (3a,): the entries of the cones' 2x2 matrices are T df + t at forces + df.

    Column by column of the upper triangle, off-diagonal entries times √2, as Clarabel wants them.
    """
    a = mu.size
    T, t = np.zeros((3 * a, 3 * a)), np.zeros(3 * a)
    for k, (x, y, z) in enumerate(forces):
        length = np.hypot(x, y)
        u, v = (x / length, y / length) if length > 0.0 else (1.0, 0.0)
        across = np.sqrt(2.0) * np.array([-v, u, 0.0])
        T[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = [[-u, -v, mu[k]], across, [u, v, mu[k]]]
        t[3 * k : 3 * k + 3] = mu[k] * z - length, 0.0, mu[k] * z + length
    return T, t


def refined_clarabel(instance: Instance, force_weight: float = FORCE_WEIGHT) -> FloatArray:
    """Return Clarabel's forces at a tolerance of 1e-10, refined around its own answer: (n, 3) [N].

    Of all rounds the one with the least `fixed_point_residual` counts.
    """
    p = program(instance, force_weight=force_weight)
    a, root = p.mu.size, np.sqrt(force_weight)
    weights = np.sqrt(WRENCH_WEIGHTS)
    A, w = weights[:, None] * instance.grasp_map[:, p.columns], weights * instance.wrench
    M, b = cone_rows(p)
    clarabel = backend("clarabel", Options(TOLERANCE, own={"static_regularization_constant": REGULARISATION}))
    identity, best, x = sp.identity(3 * a + 6, format="csc"), np.inf, np.zeros(3 * a)
    for turn, unit in enumerate(UNITS):
        T, t = turned_cones(x.reshape(-1, 3), p.mu)
        if turn == 0:  # no answer to turn to yet
            rows, slack, cones = M, b, {"second_order": (3,) * a}
        else:
            rows, slack = np.vstack([M[: 2 * a], -T]), np.concatenate([b[: 2 * a] - M[: 2 * a] @ x, t])
            cones = {"semidefinite": (2,) * a}
        left, right = _scaled(A / root, rows / root), np.concatenate([np.zeros(6), slack / unit])
        slope = np.concatenate([root * x, A @ x - w]) / unit
        change = clarabel.solve(ConeProgram(identity, slope, left, right, 6, 2 * a, **cones)).x
        assert change is not None
        tried = x + unit / root * change[: 3 * a]
        residual = fixed_point_residual(instance, p.forces(tried), force_weight)
        if residual < best:
            best, x = residual, tried
        if best <= GOOD:
            break
    return p.forces(x)


def _scaled(A: FloatArray, rows: FloatArray) -> Any:
    """Return the rows of ``A df - ds = 0`` and of the cones as one sparse matrix."""
    return sp.csc_matrix(np.block([[A, -np.eye(6)], [rows, np.zeros((len(rows), 6))]]))
