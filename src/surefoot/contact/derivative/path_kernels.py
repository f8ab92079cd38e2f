"""The equations of the smoothed law's path at a point, compiled: for `derivative_path` and for batches.

With y = u + Γ(u) + κ / (high - λ_n) - κ / (λ_n - low) along the normal, every contact's path is::

    c = (mu² λ_n y_t + y_n λ_t, λ·y - κ) = 0,    P = ∂c/∂λ,  Q = ∂c/∂y,  U = ∂y/∂u,  B = ∂y/∂λ

A bilateral contact has u = 0 in its place, one that is off λ = 0. See `derivative_path` for the rest.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel


@inline_kernel
def fill_epsilon(scales: FloatArray, kappa: float, convex: bool, out: FloatArray) -> None:
    """Fill out (n,) with ε, by which Γ is rounded: κ w / s, at most sqrt(κ w); scales are (4, n)."""
    for k in range(out.size):
        # of the order of the velocity errors that κ makes elsewhere (κ / λ_n with λ_n about s / w), and at a
        # kink, where those are sqrt(κ w), no more than that
        w, s = scales[0, k], scales[1, k]
        out[k] = 0.0 if convex else math.sqrt(kappa * w)
        if s > 0.0 and not convex:
            out[k] = min(out[k], kappa * w / s)


@inline_kernel
def _normal_slack(
    laws: FloatArray,
    epsilon: FloatArray,
    kappa: float,
    convex: bool,
    k: int,
    forces: FloatArray,
    u: FloatArray,
) -> tuple[float, float, float, float, float, float]:
    """Return y_n, the speed and slope of Γ (∂Γ/∂u_t = slope u_t), ∂y_n/∂λ_n, and one over both distances."""
    h, mu, low, high = 3 * k, laws[0, k], laws[1, k], laws[2, k]
    speed = slope = above = below = 0.0
    if not convex:
        speed = math.sqrt(u[h] * u[h] + u[h + 1] * u[h + 1] + epsilon[k] * epsilon[k])
        slope = mu / speed if speed > 0.0 else 0.0
    # barriers of the bounds, κ / distance each: they push λ_n off its bounds. A lower bound of zero is the
    # apex, which the cone's own barrier keeps away from
    if low > 0.0:
        above = 1.0 / (forces[h + 2] - low)
    if high < np.inf:
        below = 1.0 / (high - forces[h + 2])
    normal = u[h + 2] + mu * speed + kappa * (below - above)
    return normal, speed, slope, kappa * (above * above + below * below), above, below


@kernel
def fill_slacks(
    laws: FloatArray, epsilon: FloatArray, kappa: float, convex: bool, forces: FloatArray, u: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (3n,) with what the slacks y of forces and velocities (3n,) are to be; else u.

    The laws are (3, n): mu, normal_min (-inf for a bilateral contact) and normal_max; epsilon (n,) is what
    `fill_epsilon` filled.
    """
    for i in range(u.size):
        out[i] = u[i]
    for k in range(epsilon.size):
        if laws[1, k] > -np.inf and laws[2, k] > 0.0:
            out[3 * k + 2] = _normal_slack(laws, epsilon, kappa, convex, k, forces, u)[0]


@kernel
def fill_slack_rates(
    laws: FloatArray, epsilon: FloatArray, kappa: float, convex: bool, forces: FloatArray, u: FloatArray,
    step: FloatArray, du: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (3n,) with U du + B step, how the slacks move with velocities and forces (3n,)."""
    for i in range(u.size):
        out[i] = du[i]
    for k in range(epsilon.size):
        if laws[1, k] > -np.inf and laws[2, k] > 0.0:
            h = 3 * k
            _, _, slope, by_force, _, _ = _normal_slack(laws, epsilon, kappa, convex, k, forces, u)
            out[h + 2] += slope * (u[h] * du[h] + u[h + 1] * du[h + 1]) + by_force * step[h + 2]


@inline_kernel
def _cone_parts(
    laws: FloatArray, epsilon: FloatArray, kappa: float, convex: bool, k: int, forces: FloatArray,
    u: FloatArray, slacks: FloatArray, part: FloatArray, lag: FloatArray, own: FloatArray,
) -> float:  # fmt: skip
    """Fill Q U (3, 3), -(c + Q lag) (3,), ∂c by mu and both bounds (3, 3) of contact k; return ∂y_n/∂λ_n."""
    h, mu = 3 * k, laws[0, k]
    square = mu * mu
    x, y, z = slacks[h], slacks[h + 1], slacks[h + 2]
    fx, fy, fz = forces[h], forces[h + 1], forces[h + 2]
    normal, speed, slope, by_force, above, below = _normal_slack(laws, epsilon, kappa, convex, k, forces, u)
    # Q U by rows
    # ∂y/∂u is the identity but for the normal row, (slope u_t, 1): Γ lets the tangents into y_n
    p, q = slope * u[h], slope * u[h + 1]
    part[0, 0], part[0, 1], part[0, 2] = square * fz + fx * p, fx * q, fx
    part[1, 0], part[1, 1], part[1, 2] = fy * p, square * fz + fy * q, fy
    part[2, 0], part[2, 1], part[2, 2] = fx + fz * p, fy + fz * q, fz
    # c, and what it moves by when the slacks catch up
    # slacks are unknowns of their own on the way, so that they can stay inside their cones while u does not
    p, q, r = u[h] - x, u[h + 1] - y, normal - z
    lag[0] = -(square * fz * x + z * fx + (square * fz * p + fx * r))
    lag[1] = -(square * fz * y + z * fy + (square * fz * q + fy * r))
    lag[2] = -(fx * x + fy * y + fz * z - kappa + (fx * p + fy * q + fz * r))
    # by mu through the shift and the cone's own metric, by the bounds through their terms
    low, high = -kappa * above * above, -kappa * below * below
    for a in range(3):
        f = (fx, fy, fz)[a]
        own[a, 0] = f * speed + 2.0 * mu * fz * (x, y, 0.0)[a]
        own[a, 1], own[a, 2] = f * low, f * high
    return by_force


@inline_kernel
def _fill_right(
    k: int, n: int, part: FloatArray, lag: FloatArray, own: FloatArray, A: FloatArray, right: FloatArray
) -> None:
    """Fill the rows of contact k on the right, and divide them and those of A by the largest entry of A's."""
    h, m = 3 * k, 3 * n
    wide = right.shape[1] > 1
    for a in range(3):
        # rows of stiff and soft contacts, and of u = 0 and λ = 0, differ by the
        # units of G: each is made of size one
        size = 0.0
        for j in range(m):
            size = max(size, abs(A[h + a, j]))
        size = 1.0 / size if size > 0.0 else 1.0
        for j in range(m):
            A[h + a, j] *= size
        for j in range(right.shape[1]):
            right[h + a, j] = 0.0 if wide else size * lag[a]
        if wide:
            for b in range(3):
                right[h + a, h + b] = -size * part[a, b]
                if m + b * n < right.shape[1]:
                    right[h + a, m + b * n + k] = -size * own[a, b]


@kernel
def path_system(
    G: FloatArray, laws: FloatArray, epsilon: FloatArray, kappa: float, convex: bool, forces: FloatArray,
    u: FloatArray, slacks: FloatArray, A: FloatArray, right: FloatArray,
) -> None:  # fmt: skip
    """Fill A (3n, 3n) with P + Q (U G + B), and right with -(c + Q lag), the lag what slacks have yet to go.

    A right of more columns than one is filled with -Q U (3n) and with minus the derivatives by mu (n) and, if
    there are so many columns, by normal_min and normal_max (n each). Rows are divided by their largest entry:
    contacts of any stiffness count alike. Forces, u and slacks are (3n,); the rest as for `fill_slacks`.
    """
    n, m = epsilon.size, u.size
    part, lag, own = np.zeros((3, 3)), np.empty(3), np.zeros((3, 3))
    for k in range(n):
        h, square = 3 * k, laws[0, k] * laws[0, k]
        held, off = laws[1, k] == -np.inf, laws[2, k] == 0.0
        x, y, z = slacks[h], slacks[h + 1], slacks[h + 2]
        by_force = 0.0
        if held or off:
            # u = 0, or λ = 0
            for a in range(3):
                lag[a] = -u[h + a] if held else -forces[h + a]
                for b in range(3):
                    part[a, b], own[a, b] = 1.0 if held and a == b else 0.0, 0.0
        else:
            by_force = _cone_parts(laws, epsilon, kappa, convex, k, forces, u, slacks, part, lag, own)
        for a in range(3):
            # Q U G: velocities follow the forces
            for j in range(m):
                A[h + a, j] = part[a, 0] * G[h, j] + part[a, 1] * G[h + 1, j] + part[a, 2] * G[h + 2, j]
            if off:
                A[h + a, h + a] = 1.0
        # + P, the derivative of c by λ with y held, and Q B
        if not (held or off):
            for a in range(2):
                A[h + a, h + a] += z
                A[h + a, h + 2] += square * slacks[h + a] + forces[h + a] * by_force
            A[h + 2, h] += x
            A[h + 2, h + 1] += y
            A[h + 2, h + 2] += z + forces[h + 2] * by_force
        _fill_right(k, n, part, lag, own, A, right)
