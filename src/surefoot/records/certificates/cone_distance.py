"""Distance of a vector to a sum of cones, with the proof: Newton's method on the regularised dual.

A vector b in R^d shall be a sum of forces f_k in second-order cones K_k (``|f_t| <= mu f_n``; mu 0 is a ray),
each through its map G_k (d, 3). The nearest sum leaves ``r = b - sum G_k f_k``, and r is its own certificate
(Moreau): ``G_k^T r`` lies in the polar of every K_k, so that for all other forces ``r.b / |r|`` is a lower
bound of what they leave. The dual of the problem with ``eps/2 |f|^2`` added is smooth and convex in r::

    min_r  1/2 |r|^2 - b.r + 1/(2 eps) sum |P_k(G_k^T r)|^2,        f_k = P_k(G_k^T r) / eps

(P_k projects on K_k). Its gradient is piecewise smooth; Newton's steps are damped by the slope along them,
and eps falls in stages. What is returned is proven apart from all of that: forces are in their cones by
construction, and the caller measures both bounds from them and from r.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_lower, solve_upper

STAGES = np.array([1e-2, 1e-4, 1e-6, 1e-8])
"""eps of the stages, for vectors and forces of order one [-]."""
MOST_STEPS = 40
"""Newton steps of a stage at most."""


@inline_kernel
def project_on_cone(u: FloatArray, mu: float, out: FloatArray) -> float:
    """Fill the projection (3,) of (3,) u on ``|f_t| <= mu f_n``; return |u_t|, negative where u is inside."""
    if mu <= 0.0:
        out[0], out[1], out[2] = 0.0, 0.0, max(u[2], 0.0)
        return 0.0
    side: float = np.hypot(u[0], u[1])
    if side <= mu * u[2]:
        out[0], out[1], out[2] = u[0], u[1], u[2]
        return -1.0
    normal = (u[2] + mu * side) / (1.0 + mu * mu)
    if normal <= 0.0:
        out[0], out[1], out[2] = 0.0, 0.0, 0.0
        return side
    out[0], out[1], out[2] = mu * normal * u[0] / side, mu * normal * u[1] / side, normal
    return side


@inline_kernel
def _slope(
    maps: FloatArray, mu: FloatArray, count: int, d: int, b: FloatArray, eps: float, r: FloatArray,
    forces: FloatArray, u: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill the gradient (d,) at r, with the forces (count, 3) and products u (count, 3) there."""
    for i in range(d):
        out[i] = r[i] - b[i]
    for k in range(count):
        first = 2 if mu[k] <= 0.0 else 0
        for a in range(first, 3):
            total = 0.0
            for i in range(d):
                total += maps[k, a, i] * r[i]
            u[k, a] = total
        project_on_cone(u[k], mu[k], forces[k])
        for a in range(first, 3):
            forces[k, a] /= eps
            for i in range(d):
                out[i] += maps[k, a, i] * forces[k, a]


@inline_kernel
def _bend(
    maps: FloatArray, mu: FloatArray, count: int, d: int, eps: float, u: FloatArray, H: FloatArray
) -> None:
    """Fill the lower half of a generalised Hessian (d, d): 1 + sum G D G^T / eps."""
    D = np.zeros((3, 3))
    for i in range(d):
        for j in range(i + 1):
            H[i, j] = 1.0 if i == j else 0.0
    for k in range(count):
        m, n = mu[k], u[k, 2]
        if m <= 0.0:
            if n > 0.0:
                for i in range(d):
                    for j in range(i + 1):
                        H[i, j] += maps[k, 2, i] * maps[k, 2, j] / eps
            continue
        side = np.hypot(u[k, 0], u[k, 1])
        if side <= m * n:
            D[:] = np.eye(3)
        else:
            normal = (n + m * side) / (1.0 + m * m)
            if normal <= 0.0:
                continue
            x, y, q = u[k, 0] / side, u[k, 1] / side, 1.0 / (1.0 + m * m)
            # across the generator the boundary is curved: mu f_n / |u_t|
            curve = m * normal / side
            D[0, 0], D[0, 1], D[0, 2] = (
                q * m * m * x * x + curve * y * y,
                (q * m * m - curve) * x * y,
                q * m * x,
            )
            D[1, 1], D[1, 2], D[2, 2] = q * m * m * y * y + curve * x * x, q * m * y, q
            D[1, 0], D[2, 0], D[2, 1] = D[0, 1], D[0, 2], D[1, 2]
        for i in range(d):
            a0, a1, a2 = maps[k, 0, i], maps[k, 1, i], maps[k, 2, i]
            c0 = (a0 * D[0, 0] + a1 * D[1, 0] + a2 * D[2, 0]) / eps
            c1 = (a0 * D[0, 1] + a1 * D[1, 1] + a2 * D[2, 1]) / eps
            c2 = (a0 * D[0, 2] + a1 * D[1, 2] + a2 * D[2, 2]) / eps
            for j in range(i + 1):
                H[i, j] += c0 * maps[k, 0, j] + c1 * maps[k, 1, j] + c2 * maps[k, 2, j]


@kernel
def nearest_sum(
    maps: FloatArray, mu: FloatArray, count: int, d: int, b: FloatArray, r: FloatArray, forces: FloatArray,
    work: FloatArray,
) -> int:  # fmt: skip
    """Fill the forces whose sum is nearest to b, and r; return the number of Newton steps.

    Parameters
    ----------
    maps
        (>= count, 3, >= d) rows G_k^T [-].
    mu
        (>= count,) friction; 0 for a ray along the third row.
    count, d
        Numbers of cones and of dimensions.
    b
        (>= d,) the vector, of order one [-].
    r
        (>= d,) filled: what is left, to the accuracy of the last stage.
    forces
        (>= count, 3) filled: in their cones exactly [-].
    work
        (>= count + d + 4, >= max(3, d)) memory.
    """
    u, H = work[:count], work[count : count + d]
    slope, step, trial = work[count + d], work[count + d + 1], work[count + d + 2]
    for i in range(d):
        r[i] = b[i]
    steps = 0
    for eps in STAGES:
        _slope(maps, mu, count, d, b, eps, r, forces, u, slope)
        for _ in range(MOST_STEPS):
            size = 0.0
            for i in range(d):
                size = max(size, abs(slope[i]))
                step[i] = -slope[i]
            if size <= 1e-10:
                break
            steps += 1
            _bend(maps, mu, count, d, eps, u, H)
            cholesky(H[:d, :d])
            solve_lower(H[:d, :d], step[:d])
            solve_upper(H[:d, :d], step[:d])
            begin = 0.0
            for i in range(d):
                begin += slope[i] * step[i]
            length = 1.0
            # a convex function along a line: go back while it rises faster than half of what it fell
            for _ in range(30):
                end = 0.0
                for i in range(d):
                    trial[i] = r[i] + length * step[i]
                _slope(maps, mu, count, d, b, eps, trial, forces, u, slope)
                for i in range(d):
                    end += slope[i] * step[i]
                if end <= -0.5 * begin:
                    break
                length *= 0.5
            moved = 0.0
            for i in range(d):
                moved = max(moved, abs(length * step[i]))
                r[i] = trial[i]
            if moved <= 1e-15:
                break
    return steps
