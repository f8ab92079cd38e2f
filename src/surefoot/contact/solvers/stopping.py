"""The velocity error as solvers use it to stop; the certificate is another: `contact.problem.residuals`."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.pyramid_projection import project_any


@inline_kernel
def fill_measure(scales: FloatArray, measure: FloatArray) -> None:
    """Fill the last two columns of `measure` (n, ...): the step 1 / w_k, and (w_k / s_k)².

    They turn the natural map of contact k, a force, into a velocity over s_k (`problem.scales`). Contacts
    without speed (s_k = 0) count nothing: their forces are known, see `settle`.
    """
    at = measure.shape[1] - 2
    for k in range(measure.shape[0]):
        w, s = scales[0, k], scales[1, k]
        # a contact that its own force does not move: λ and u have no common scale but the problem's speed
        if not w > 0.0:
            w = s if s > 0.0 else 1.0
        measure[k, at] = 1.0 / w
        measure[k, at + 1] = (w / s) ** 2 if s > 0.0 else 0.0


@inline_kernel
def settle(low: FloatArray, scales: FloatArray, forces: FloatArray) -> None:
    """Set the flat (3n,) forces of contacts without speed to those nearest to zero, their solution."""
    for k in range(low.size):
        if scales[1, k] == 0.0:
            forces[3 * k] = forces[3 * k + 1] = 0.0
            forces[3 * k + 2] = max(low[k], 0.0)


@inline_kernel
def _natural_square(
    forces: FloatArray, velocities: FloatArray, k: int, step: float, mu: float, low: float, high: float,
    convex: bool,
) -> float:  # fmt: skip
    """Return ||λ_k - P_K(λ_k - step (u_k + Γ(u_k)))||² of contact k, at least half its approach squared.

    The approach, step times -u_n below the upper bound, is what ε shows little of where mu is large.
    """
    i = 3 * k
    x, y, z = forces[i], forces[i + 1], forces[i + 2]
    p, q, r = velocities[i], velocities[i + 1], velocities[i + 2]
    # Γ(u) on the normal row: u + Γ(u) is what is complementary to λ, for Coulomb's law; a bilateral
    # contact has all of space for K and no Γ
    approach = min(-step * r, high - z) if low > -np.inf else 0.0
    if not convex and low > -np.inf:
        r += mu * math.sqrt(p * p + q * q)
    a, b, c = project_any(x - step * p, y - step * q, z - step * r, mu, low, high, 0, True)
    square = (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
    return 0.5 * approach * approach if approach > 0.0 and 0.5 * approach * approach > square else square


@inline_kernel
def velocity_error(
    forces: FloatArray, velocities: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray,
    measure: FloatArray, convex: bool,
) -> float:  # fmt: skip
    """Return max_k w_k ||λ_k - P_K(λ_k - (u_k + Γ(u_k)) / w_k)|| / s_k for flat (3n,) forces and velocities.

    As in `contact.problem.residuals` at least `APPROACH` times the speed of approach over s_k.

    `measure` is what `fill_measure` filled. A sum that is not a number is returned as infinite.
    """
    worst = total = 0.0
    at = measure.shape[1] - 2
    for k in range(mu.size):
        gap = measure[k, at + 1] * _natural_square(
            forces, velocities, k, measure[k, at], mu[k], low[k], high[k], convex
        )
        worst = max(worst, gap)
        total += gap
    return math.sqrt(worst) if total >= 0.0 else np.inf


@kernel
def force_error(
    forces: FloatArray, velocities: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray,
    high: FloatArray, measure: FloatArray, convex: bool,
) -> float:  # fmt: skip
    """Return the natural map over the forces, both weighted by w_k: how far there is to go.

    What globalises Newton's method (its proximal term, its patience) wants a number that falls as the forces
    approach; velocities of a high stack stay large until its last force is right. No verdict rests on it.
    """
    gap = size = reach = 0.0
    at = measure.shape[1] - 2
    for k in range(mu.size):
        i, step = 3 * k, measure[k, at]
        gap += _natural_square(forces, velocities, k, step, mu[k], low[k], high[k], convex) / step
        size += (forces[i] ** 2 + forces[i + 1] ** 2 + forces[i + 2] ** 2) / step
        reach += step * (g[i] ** 2 + g[i + 1] ** 2 + g[i + 2] ** 2)
    # near zero forces the map over the forces says nothing: Σ ||g_k||² / w_k is what they will have to be
    scale = max(size, reach)
    if not gap >= 0.0:
        return np.inf
    return math.sqrt(gap / scale) if scale > 0.0 else math.sqrt(gap)
