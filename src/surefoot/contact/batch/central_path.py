"""The smoothed law of a contact problem, compiled: a point on the central path, and its derivative.

The path and its derivative are those of `derivative.central_path`, on the same `derivative.path_kernels`, for
exact cones without normal bounds. That one comes down from far inside; here Newton's method starts at the
solution of the law itself and ends in a few steps. In the scaled unknowns y = (λ_t / mu, λ_n) / d and slacks
s = d (mu u_t, u_n + mu ||u_t||) of every contact the path is y ∘ s = κ e in the cones' Jordan algebra, or
with their smoothed projection::

    F(y) = y - p_κ(y - s(y)) = 0,    p_κ(z) = (z + sqrt(z ∘ z + 4 κ e)) / 2

defined everywhere, so that no step has to stay inside. Near the path the steps are those of λ ∘ (u + Γ) = κ e
itself, which loses no digits where κ is small.

Source: M. Fukushima, Z.-Q. Luo, P. Tseng, "Smoothing functions for second-order-cone complementarity
problems", SIOPT 12(2), 2002.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.elimination import lu_solve, lu_solve_many
from surefoot.contact.derivative.path_kernels import fill_epsilon, fill_slacks, path_system
from surefoot.contact.problem.scales import scales_dense
from surefoot.contact.solvers.nsgs import refresh_dense

STEPS, HALVINGS = 60, 12
"""Newton steps to the path, and how often one is halved."""
CLOSE, EXACT, NEAR = 1e-4, 1e-13, 1e-8
"""Newton steps, relative to the largest force, after which the path's own equations take over; after which
the point is exact; and good enough where rounding keeps them from shrinking."""


@inline_kernel
def _rounding(G: FloatArray, g: FloatArray, kappa: float, convex: bool, out: FloatArray) -> None:
    """Fill out (2, n): ε of every contact, and d that scales its block of G to a trace of 3."""
    n = out.shape[1]
    scales, low, high = np.empty((4, n)), np.zeros(n), np.full(n, np.inf)
    scales_dense(G, g, low, high, scales)
    fill_epsilon(scales, kappa, convex, out[0])
    for k in range(n):
        out[1, k] = math.sqrt(3.0 / scales[2, k]) if scales[2, k] > 0.0 else 1.0


@inline_kernel
def _without_bounds(mu: FloatArray) -> FloatArray:
    """Return the laws (3, n) of unilateral contacts, as `contact.derivative.path_kernels` takes them."""
    laws = np.zeros((3, mu.size))
    for k in range(mu.size):
        laws[0, k], laws[2, k] = mu[k], np.inf
    return laws


@inline_kernel
def _half(value: float, root: float, kappa: float) -> float:
    """Return (value + root) / 2 with root² = value² + 4 κ, without cancelling."""
    return 0.5 * (value + root) if value > 0.0 else 2.0 * kappa / (root - value)


@inline_kernel
def _misses(
    mu: FloatArray, scale: FloatArray, kappa: float, convex: bool, forces: FloatArray, u: FloatArray,
    J: FloatArray, F: FloatArray,
) -> float:  # fmt: skip
    """Fill F (3n,) and J (3n, 3), the Jacobian of p_κ by contact; return F·F.

    `scale` (2, n) is what `_rounding` fills.
    """
    square = 0.0
    for k in range(mu.size):
        h, d = 3 * k, scale[1, k]
        p, q = u[h], u[h + 1]
        speed = 0.0 if convex else math.sqrt(p * p + q * q + scale[0, k] * scale[0, k])
        # without friction the cone is a ray, and its tangential unknowns stay zero
        over = 1.0 / (mu[k] * d) if mu[k] > 0.0 else 0.0
        # the cone made ||·|| <= z by y = λ / (mu, mu, 1), in units of d
        yx, yy, yz = forces[h] * over, forces[h + 1] * over, forces[h + 2] / d
        x, y, z = yx - mu[k] * d * p, yy - mu[k] * d * q, yz - d * (u[h + 2] + mu[k] * speed)
        radius = math.sqrt(x * x + y * y)
        ex, ey = (x / radius, y / radius) if radius > 0.0 else (1.0, 0.0)
        # its two eigenvalues; p_κ takes each to (a + sqrt(a² + 4 κ)) / 2 (Fukushima, Luo and Tseng 2002)
        a, b = z + radius, z - radius
        up, down = math.sqrt(a * a + 4.0 * kappa), math.sqrt(b * b + 4.0 * kappa)
        # (p_κ(a) - p_κ(b)) / (a - b), the roots' difference rationalised: nothing
        # cancels, or divides by a small radius
        across = 0.5 + z / (up + down)
        # slopes of the smooth plus at both
        sa, sb = 0.5 * (1.0 + a / up), 0.5 * (1.0 + b / down)
        mean, skew = 0.5 * (sa + sb), 0.5 * (sa - sb)
        turned = mean - across
        J[h, 0], J[h, 1], J[h, 2] = across + turned * ex * ex, turned * ex * ey, skew * ex
        J[h + 1, 0], J[h + 1, 1], J[h + 1, 2] = turned * ex * ey, across + turned * ey * ey, skew * ey
        J[h + 2, 0], J[h + 2, 1], J[h + 2, 2] = skew * ex, skew * ey, mean
        # F = y - p_κ(y - s): zero on the path
        F[h], F[h + 1] = yx - across * x, yy - across * y
        F[h + 2] = yz - 0.5 * (_half(a, up, kappa) + _half(b, down, kappa))
        square += F[h] * F[h] + F[h + 1] * F[h + 1] + F[h + 2] * F[h + 2]
    return square


@inline_kernel
def _slope(
    G: FloatArray, mu: FloatArray, scale: FloatArray, convex: bool, u: FloatArray, J: FloatArray,
    A: FloatArray,
) -> None:  # fmt: skip
    """Fill A with the derivative of F by y: 1 - J + J S G T, with s = S u and λ = T y."""
    m = u.size
    row = np.empty((3, m))
    for k in range(mu.size):
        h, d = 3 * k, scale[1, k]
        speed = math.sqrt(u[h] * u[h] + u[h + 1] * u[h + 1] + scale[0, k] * scale[0, k])
        # ∂Γ/∂u of the rounded shift
        lean = 0.0 if convex or speed == 0.0 else mu[k] / speed
        for j in range(m):
            # G T: λ = T y with T = d (mu, mu, 1); s = d (mu u_t, u_n + mu
            # ||u_t||) is linear in u but for the shift
            own = scale[1, j // 3] * (1.0 if j % 3 == 2 else mu[j // 3])
            x, y, z = G[h, j], G[h + 1, j], G[h + 2, j]
            row[0, j], row[1, j] = own * mu[k] * d * x, own * mu[k] * d * y
            row[2, j] = own * d * (z + lean * (u[h] * x + u[h + 1] * y))
        for a in range(3):
            for j in range(m):
                A[h + a, j] = J[h + a, 0] * row[0, j] + J[h + a, 1] * row[1, j] + J[h + a, 2] * row[2, j]
            for b in range(3):
                A[h + a, h + b] += (1.0 if a == b else 0.0) - J[h + a, b]


@kernel
def follow_path(
    G: FloatArray, g: FloatArray, mu: FloatArray, convex: bool, kappa: float, forces: FloatArray
) -> bool:
    """Bring forces (n, 3) from the solution of the law to the point of its central path with λ·y = κ.

    Parameters
    ----------
    G, g, mu
        (3n, 3n), (3n,) and (n,) of the contact problem; no bounds but normal forces >= 0.
    convex
        Whether the law is convex; else Coulomb's.
    kappa
        Normal force times normal velocity on the path.
    forces
        (n, 3) to start from, and filled.

    Returns
    -------
    bool
        Whether the point was reached; `contact.derivative.central_path` may do it where this did not.
    """
    n, m = mu.size, g.size
    scale = np.empty((2, n))
    _rounding(G, g, kappa, convex, scale)
    f, tried, u, F, J = forces.reshape(-1), np.empty(m), np.empty(m), np.empty(m), np.empty((m, 3))
    A, b, column = np.empty((m, m)), np.empty(m), np.empty((m, 1))
    laws, slacks = _without_bounds(mu), np.empty(m)
    for k in range(n):
        # a frictionless contact has no tangential force to start with
        if mu[k] == 0.0:
            f[3 * k] = f[3 * k + 1] = 0.0
    refresh_dense(G, g, f, u)
    square = _misses(mu, scale, kappa, convex, f, u, J, F)
    moved, last, share = np.inf, np.inf, 0.0
    for _ in range(STEPS):
        # far away Newton's method on the smooth projection, near the point on the equations themselves
        own = moved <= CLOSE and _inside(mu, scale, convex, f, u)
        if own:
            fill_slacks(laws, scale[0], kappa, convex, f, u, slacks)
            path_system(G, laws, scale[0], kappa, convex, f, u, slacks, A, column)
            for i in range(m):
                b[i] = column[i, 0]
        else:
            _slope(G, mu, scale, convex, u, J, A)
            for i in range(m):
                b[i] = -F[i]
        if not lu_solve(A, b, m):
            return False
        if not own:
            for i in range(m):
                # from y to forces
                b[i] *= scale[1, i // 3] * (1.0 if i % 3 == 2 else mu[i // 3])
        # Armijo's line search on ||F||²
        share = 1.0
        for _ in range(HALVINGS):
            for i in range(m):
                # a step of the path's own equations is taken whole: ||F|| loses the
                # digits that it gains where κ is small
                tried[i] = f[i] + share * b[i] if mu[i // 3] > 0.0 or i % 3 == 2 else 0.0
            refresh_dense(G, g, tried, u)
            now = _misses(mu, scale, kappa, convex, tried, u, J, F)
            if own or now <= (1.0 - 1e-4 * share) * square:
                break
            share *= 0.5
        square, size, way = now, 0.0, 0.0
        for i in range(m):
            f[i] = tried[i]
            size, way = max(size, abs(f[i])), max(way, abs(share * b[i]))
        if not size < np.inf:
            return False
        last, moved = moved, way / size if size > 0.0 else 0.0
        # exact, or as near as rounding lets it come: the step no longer halves
        if own and (moved <= EXACT or NEAR >= moved >= 0.5 * last):
            return _inside(mu, scale, convex, f, u)
    return False


@inline_kernel
def _inside(mu: FloatArray, scale: FloatArray, convex: bool, f: FloatArray, u: FloatArray) -> bool:
    """Return whether forces and slacks lie inside their cones."""
    inside = True
    for k in range(mu.size):
        h = 3 * k
        slip = math.sqrt(u[h] * u[h] + u[h + 1] * u[h + 1])
        lift = u[h + 2] if convex else u[h + 2] + mu[k] * math.sqrt(slip * slip + scale[0, k] * scale[0, k])
        side = math.sqrt(f[h] * f[h] + f[h + 1] * f[h + 1])
        inside = (
            inside and side <= mu[k] * f[h + 2] and f[h + 2] > 0.0 and lift > 0.0 and mu[k] * slip <= lift
        )
    return inside


@kernel
def path_blocks(
    G: FloatArray, g: FloatArray, mu: FloatArray, convex: bool, kappa: float, forces: FloatArray,
    out: FloatArray,
) -> bool:  # fmt: skip
    """Fill out (3n, 4n) with the derivatives of the path's forces by g (3n,) and by every contact's mu (n,).

    The arguments are those of `follow_path`, after it. False where the system is singular.
    """
    n, m = mu.size, g.size
    scale, u, A = np.empty((2, n)), np.empty(m), np.empty((m, m))
    _rounding(G, g, kappa, convex, scale)
    f = forces.reshape(-1)
    refresh_dense(G, g, f, u)
    laws, slacks = _without_bounds(mu), np.empty(m)
    # at a point of the path the slacks are what they should be, and the lag vanishes
    fill_slacks(laws, scale[0], kappa, convex, f, u, slacks)
    path_system(G, laws, scale[0], kappa, convex, f, u, slacks, A, out)
    return bool(lu_solve_many(A, out, m))
