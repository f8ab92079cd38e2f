"""The programs of the force benchmark, with exact cones or facets, and how an answer to one is judged."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.cones.cone import Fit
from surefoot.contact.solvers.backends import ConeProgram


@dataclass(frozen=True)
class Program:
    """min 1/2 xᵀHx + hᵀx over the feet that carry: exact cones, or rows C x <= 0 and bounds on x.

    Attributes
    ----------
    instance
        Where it comes from.
    H, h
        (3a, 3a) and (3a,) for the a active feet.
    C
        Rows of the facets, or None for exact cones.
    low, high
        (3a,) bounds on x, infinite for tangential components.
    """

    instance: Instance
    H: FloatArray
    h: FloatArray
    C: FloatArray | None
    low: FloatArray
    high: FloatArray
    mu: FloatArray
    columns: Any = field(repr=False)

    def forces(self, x: FloatArray | None) -> FloatArray:
        """Return the (n, 3) forces of a solution; NaN where there is none."""
        out = np.zeros(self.instance.grasp_map.shape[1])
        out[self.columns] = np.nan if x is None else x
        return out.reshape(-1, 3)


def program(
    instance: Instance, facets: int | None = None, fit: Fit = "inner", force_weight: float = FORCE_WEIGHT
) -> Program:
    """Return the program of an instance, exact or with facets."""
    on = np.flatnonzero(instance.active)
    columns = (3 * on[:, None] + np.arange(3)).ravel()
    A = instance.grasp_map[:, columns]
    H = A.T @ (WRENCH_WEIGHTS[:, None] * A) + force_weight * np.eye(columns.size)
    low, high = np.full(columns.size, -np.inf), np.full(columns.size, np.inf)
    low[2::3], high[2::3] = instance.normal_min[on], instance.normal_max[on]
    C = None
    if facets is not None:
        rows = [FrictionPyramid(float(m), facets, fit) for m in instance.mu[on]]
        C = np.zeros((facets * on.size, columns.size))
        for k, pyramid in enumerate(rows):
            C[facets * k : facets * (k + 1), 3 * k : 3 * k + 3] = pyramid.halfspaces[:facets]
    h = -A.T @ (WRENCH_WEIGHTS * instance.wrench)
    return Program(instance, 0.5 * (H + H.T), h, C, low, high, instance.mu[on], columns)


def cone_rows(p: Program) -> tuple[FloatArray, FloatArray]:
    """Return M and b with b - M x in (non-negative, then one second-order cone per foot)."""
    a = p.mu.size
    Z = np.zeros((a, 3 * a))
    Z[np.arange(a), 3 * np.arange(a) + 2] = 1.0
    S = np.zeros((3 * a, 3 * a))
    for k in range(a):
        S[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = [[0.0, 0.0, p.mu[k]], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    return np.vstack([-Z, Z, -S]), np.concatenate([-p.low[2::3], p.high[2::3], np.zeros(3 * a)])


def cone_program(p: Program) -> ConeProgram:
    """Return the program for outside solvers: bounds and facets, or bounds and second-order cones."""
    a = p.mu.size
    if p.C is None:
        M, b = cone_rows(p)
        return ConeProgram.of(
            p.H, p.h, nonneg=(M[: 2 * a], b[: 2 * a]), second_order=(M[2 * a :], b[2 * a :])
        )
    Z = np.eye(3 * a)[2::3]
    right = np.concatenate([np.zeros(len(p.C)), p.high[2::3], -p.low[2::3]])
    return ConeProgram.of(p.H, p.h, nonneg=(np.vstack([p.C, Z, -Z]), right))


def objective(p: Program, x: FloatArray) -> float:
    """Return ||A f - w||²_W + r ||f||² [N²] for x (m,), the forces that are on: zero at best."""
    w = p.instance.wrench
    return float(x @ p.H @ x + 2.0 * p.h @ x + w @ (WRENCH_WEIGHTS * w))


def facet_violation(p: Program, x: FloatArray) -> float:
    """Return by how much x (m,) breaks the program's own facets and bounds [N]."""
    worst = max(float((p.low - x).max()), float((x - p.high).max()), 0.0)
    return worst if p.C is None else max(worst, float((p.C @ x).max()))


def cone_violation(instance: Instance, forces: FloatArray) -> float:
    """Return the largest distance of (n, 3) forces to their exact truncated cones [N]; NaN for a NaN."""
    f = forces[instance.active]
    mu, low, high = (v[instance.active] for v in (instance.mu, instance.normal_min, instance.normal_max))
    t = np.hypot(f[:, 0], f[:, 1])
    over = np.maximum(t - mu * f[:, 2], 0.0) / np.sqrt(1.0 + mu**2)
    return float(np.max([over, low - f[:, 2], f[:, 2] - high, np.zeros(mu.size)]))


def shortfall(instance: Instance, forces: FloatArray) -> float:
    """Return the weighted wrench error ||A f - w||_W [N] of (n, 3) forces."""
    e = instance.grasp_map @ forces.ravel() - instance.wrench
    return math.sqrt(float(e @ (WRENCH_WEIGHTS * e)))
