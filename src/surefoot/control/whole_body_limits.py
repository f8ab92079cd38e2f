"""Contact forces under torque limits: the cone program that whole-body control falls back on.

    minimise ½ ||A f - w||² + ½ r ||f - f_ref||²
    subject to every f_k in its truncated friction cone and low <= T f <= high

by ADMM [1]_ on the splitting f = y (cones), T f = z (box), with the penalty adapted to the ratio of the
two residuals [2]_. The force that is returned is y: it lies in every cone exactly, whatever the
iteration has reached, and the box is met as far as it can be.

References
----------
.. [1] S. Boyd et al., "Distributed optimization and statistical learning via ADMM", 2011.
.. [2] B. Stellato et al., "OSQP: an operator splitting solver for quadratic programs", 2020.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.cones.projection import project_truncated
from surefoot.control.whole_body_kernels import cholesky, cholesky_solve
from surefoot.kernels import kernel

RELAXATION = 1.6
CHECK_EVERY = 10


@kernel
def _factor(P: FloatArray, T: FloatArray, rho: float, out: FloatArray) -> None:
    """Set out to the Cholesky factor of P + rho (I + TᵀT)."""
    n, m = P.shape[0], T.shape[0]
    for i in range(n):
        for j in range(i + 1):
            s = P[i, j]
            for k in range(m):
                s += rho * T[k, i] * T[k, j]
            out[i, j] = s
        out[i, i] += rho
    cholesky(out)


@kernel
def limited_forces(
    A: FloatArray,
    w: FloatArray,
    weight: float,
    reference: FloatArray,
    mu: FloatArray,
    low: FloatArray,
    high: FloatArray,
    T: FloatArray,
    floor: FloatArray,
    ceiling: FloatArray,
    start: FloatArray,
    tolerance: float,
    limit: int,
    out: FloatArray,
) -> tuple[int, float]:
    """Fill out (p, 3) with the forces; return the iterations used and the worst violation of the box.

    Parameters
    ----------
    A, w
        (6, 3p), (6,) quadratic cost.
    weight, reference
        r and (p, 3) wanted forces [N].
    mu, low, high
        (p,) friction and bounds on the normal forces; high = 0 switches a point off.
    T, floor, ceiling
        (m, 3p), (m,), (m,) box rows, scaled so that T f is of the size of f.
    start
        (p, 3) where to begin.
    tolerance
        Largest primal and dual residual at which to stop [N].
    limit
        Bound on the iterations.
    """
    n, m = A.shape[1], T.shape[0]
    P, g = np.zeros((n, n)), np.zeros(n)
    trace = 0.0
    for i in range(n):
        for j in range(n):
            for k in range(6):
                P[i, j] += A[k, i] * A[k, j]
        P[i, i] += weight
        trace += P[i, i]
        g[i] = weight * reference[i // 3, i % 3]
        for k in range(6):
            g[i] += A[k, i] * w[k]
    rho = 0.1 * trace / n
    L = np.zeros((n, n))
    _factor(P, T, rho, L)
    y, z = np.empty(n), np.zeros(m)
    for i in range(n):
        y[i] = start[i // 3, i % 3]
    for k in range(m):
        for i in range(n):
            z[k] += T[k, i] * y[i]
        z[k] = min(max(z[k], floor[k]), ceiling[k])
    s, t = np.zeros(n), np.zeros(m)  # scaled duals
    f, Tf = np.zeros((n, 1)), np.zeros(m)
    used = limit
    for iteration in range(limit):
        for i in range(n):
            f[i, 0] = g[i] + rho * (y[i] - s[i])
        for k in range(m):
            d = rho * (z[k] - t[k])
            for i in range(n):
                f[i, 0] += T[k, i] * d
        cholesky_solve(L, f)
        primal = dual = 0.0
        for k in range(m):
            Tf[k] = 0.0
            for i in range(n):
                Tf[k] += T[k, i] * f[i, 0]
        for c in range(n // 3):
            b = np.empty(3)
            for i in range(3):
                b[i] = RELAXATION * f[3 * c + i, 0] + (1.0 - RELAXATION) * y[3 * c + i] + s[3 * c + i]
            p, q, r = project_truncated(b[0], b[1], b[2], mu[c], low[c], high[c])
            for i, value in enumerate((p, q, r)):
                dual = max(dual, abs(value - y[3 * c + i]))
                primal = max(primal, abs(value - f[3 * c + i, 0]))
                y[3 * c + i] = value
                s[3 * c + i] = b[i] - value
        for k in range(m):
            b0 = RELAXATION * Tf[k] + (1.0 - RELAXATION) * z[k] + t[k]
            value0 = min(max(b0, floor[k]), ceiling[k])
            dual = max(dual, abs(value0 - z[k]))
            primal = max(primal, abs(value0 - Tf[k]))
            z[k] = value0
            t[k] = b0 - value0
        if primal < tolerance and dual < tolerance:
            used = iteration + 1
            break
        if iteration % CHECK_EVERY == CHECK_EVERY - 1:
            ratio = math.sqrt(primal / max(dual, 1e-300))
            if ratio > 3.0 or ratio < 1.0 / 3.0:
                ratio = min(max(ratio, 0.2), 5.0)
                rho *= ratio
                for i in range(n):
                    s[i] /= ratio
                for k in range(m):
                    t[k] /= ratio
                _factor(P, T, rho, L)
    worst = 0.0
    for k in range(m):
        value1 = 0.0
        for i in range(n):
            value1 += T[k, i] * y[i]
        worst = max(worst, value1 - ceiling[k], floor[k] - value1)
    for i in range(n):
        out[i // 3, i % 3] = y[i]
    return used, worst
