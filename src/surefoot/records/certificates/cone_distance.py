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
from surefoot.base.numerics.projection import face, project_cone

STAGES = np.array([1e-2, 1e-4, 1e-6, 1e-8])
"""eps of the stages, for vectors and forces of order one [-]."""
MOST_STEPS = 40
"""Newton steps of a stage at most."""


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
        u[k, 0] = u[k, 1] = 0.0  # a ray has no tangents
        for a in range(first, 3):
            total = 0.0
            for i in range(d):
                total += maps[k, a, i] * r[i]
            u[k, a] = total
        forces[k, 0], forces[k, 1], forces[k, 2] = project_cone(u[k, 0], u[k, 1], u[k, 2], mu[k])
        for a in range(first, 3):
            forces[k, a] /= eps
            for i in range(d):
                out[i] += maps[k, a, i] * forces[k, a]


@inline_kernel
def _bend(
    maps: FloatArray, mu: FloatArray, count: int, d: int, eps: float, u: FloatArray, H: FloatArray,
    w: FloatArray,
) -> None:  # fmt: skip
    """Fill the lower half of a generalised Hessian (d, d): 1 + sum G D G^T / eps; w (d,) is room.

    D is that of the projection: v v^T over the orthogonal vectors v of `face`.
    """
    for i in range(d):
        for j in range(i + 1):
            H[i, j] = 1.0 if i == j else 0.0
    for k in range(count):
        x, y, z = u[k, 0], u[k, 1], u[k, 2]
        height = project_cone(x, y, z, mu[k])[2]
        sticks, _, p, q, across, along = face(x, y, height, mu[k], -np.inf, np.inf)
        if sticks:
            for a in range(3):
                _add_outer(maps[k, a], d, eps, H)
            continue
        if across > 0.0:
            for i in range(d):
                w[i] = across * (p * maps[k, 1, i] - q * maps[k, 0, i])
            _add_outer(w, d, eps, H)
        if along > 0.0:
            for i in range(d):
                w[i] = along * (mu[k] * (p * maps[k, 0, i] + q * maps[k, 1, i]) + maps[k, 2, i])
            _add_outer(w, d, eps, H)


@inline_kernel
def _add_outer(w: FloatArray, d: int, eps: float, H: FloatArray) -> None:
    """Add w w^T / eps to the lower half of H."""
    for i in range(d):
        one = w[i] / eps
        for j in range(i + 1):
            H[i, j] += one * w[j]


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
            _bend(maps, mu, count, d, eps, u, H, trial)
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
