"""The optimal forces to thirty digits, in decimal arithmetic: a judge between solvers that disagree.

With e = w - A f the wrench that is left, the optimum is the only zero of ``F(e) = e + A P(AᵀW e / r) - w``,
where P projects every contact's force onto its truncated cone. Newton's method from any solver's answer
finds it; here with fifty digits, so that rounding and conditioning do not matter.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.base.arrays import FloatArray

DIGITS = 50
SMALL = Decimal("1e-30")
"""||F|| [N] at which the answer counts as found."""
STEPS = 200

Decimals = Any
"""An array of `Decimal`."""


def exactly(values: FloatArray) -> Decimals:
    """Return doubles as decimals, without rounding."""
    out = np.empty(np.shape(values), dtype=object)
    out.ravel()[:] = [Decimal(v) for v in np.ravel(values).tolist()]
    return out


def length(v: Decimals) -> Decimal:
    """Return the Euclidean norm."""
    return Decimal(sum(x * x for x in v)).sqrt()


def project(point: Decimals, mu: Decimal, low: Decimal, high: Decimal) -> tuple[Decimals, Decimals]:
    """Return the nearest point of a truncated cone and the projection's Jacobian (3, 3)."""
    x, y, z = point
    t, zero = length(point[:2]), Decimal(0)
    inside = t <= mu * z
    height = z if inside else max((mu * t + z) / (1 + mu * mu), zero)
    cut = min(max(height, low), high)
    J = exactly(np.zeros((3, 3)))
    if cut == height:
        if inside:
            return point, exactly(np.eye(3))
        if height == 0:
            return exactly(np.zeros(3)), J
        along = np.array([mu * x / t, mu * y / t, Decimal(1)])
        J = J + np.outer(along, along) / (1 + mu * mu)
    elif t <= mu * cut:
        J[0, 0] = J[1, 1] = Decimal(1)
        return np.array([x, y, cut]), J
    share = mu * cut / t
    across = np.array([-y / t, x / t, zero])
    return np.array([share * x, share * y, cut]), J + share * np.outer(across, across)


def solve_exactly(matrix: Decimals, right: Decimals) -> Decimals:
    """Return the solution of a square system, by elimination with pivots."""
    H, x = matrix.copy(), right.copy()
    n = len(x)
    for a in range(n):
        p = max(range(a, n), key=lambda i: abs(H[i, a]))
        H[[a, p]], x[[a, p]] = H[[p, a]], x[[p, a]]
        for i in range(a + 1, n):
            factor = H[i, a] / H[a, a]
            H[i, a:] = H[i, a:] - factor * H[a, a:]
            x[i] -= factor * x[a]
    for a in range(n - 1, -1, -1):
        x[a] = (x[a] - H[a, a + 1 :] @ x[a + 1 :]) / H[a, a] if a < n - 1 else x[a] / H[a, a]
    return x


def exact_forces(instance: Instance, start: FloatArray, force_weight: float = FORCE_WEIGHT) -> FloatArray:
    """Return the optimal forces, rounded to doubles: (n, 3) [N].

    Parameters
    ----------
    instance
        The allocation.
    start
        (n, 3) where Newton's method starts; any solver's forces. The answer does not depend on it.
    force_weight
        r, as a double.

    Raises
    ------
    RuntimeError
        If Newton's method stops short.
    """
    with localcontext(prec=DIGITS):
        A, w, W = (exactly(v) for v in (instance.grasp_map, instance.wrench, WRENCH_WEIGHTS))
        r = Decimal(float(force_weight))
        cones = list(
            zip(*(exactly(v) for v in (instance.mu, instance.normal_min, instance.normal_max)), strict=True)
        )
        pull = (A.T * W) / r

        def evaluate(e: Decimals) -> tuple[Decimals, Decimals, list[Decimals]]:
            parts = [project(p, *cone) for p, cone in zip((pull @ e).reshape(-1, 3), cones, strict=True)]
            f = np.concatenate([part[0] for part in parts])
            return e + A @ f - w, f, [part[1] for part in parts]

        e = w - A @ exactly(start.ravel())
        F, f, jacobians = evaluate(e)
        for _ in range(STEPS):
            if length(F) <= SMALL:
                return np.asarray(f, dtype=np.float64).reshape(-1, 3)
            H = exactly(np.eye(6))
            for k, J in enumerate(jacobians):
                H = H + A[:, 3 * k : 3 * k + 3] @ J @ pull[3 * k : 3 * k + 3]
            step, share = solve_exactly(H, -F), Decimal(1)
            trial = evaluate(e + step)
            while length(trial[0]) >= length(F) and share > Decimal("1e-6"):
                share /= 2
                trial = evaluate(e + share * step)
            e = e + share * step
            F, f, jacobians = trial
    raise RuntimeError(f"{STEPS} steps did not find the optimum to {DIGITS} digits")
