"""The natural map as solvers use it to stop; the certificate is another: `contact.residuals`."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.cones.projection import project_truncated
from surefoot.kernels import inline_kernel


@inline_kernel
def project(x: float, y: float, z: float, mu: float, low: float, high: float) -> tuple[float, float, float]:
    """Return the nearest admissible force of one contact; low = -inf marks a bilateral one."""
    if low == -math.inf:
        return x, y, z
    return project_truncated(x, y, z, mu, low, high)


NOTHING_DONE = 0.1
"""Share of step ||g|| above which a gap is measured by that alone: the forces have done nothing yet."""


@inline_kernel
def reach(g: FloatArray, step: float) -> float:
    """Return step ||g||, what the free velocity amounts to in forces: the least scale of a gap."""
    total = 0.0
    for i in range(g.size):
        total += g[i] * g[i]
    return step * math.sqrt(total)


@inline_kernel
def relative_gap(gap: float, size: float, free: float) -> float:
    """Return a gap over max(||λ||, free), free = step ||g||; over free if it exceeds a tenth of that."""
    if free > 0.0:
        if gap > NOTHING_DONE * free or 4e-16 * size > NOTHING_DONE * free:
            return max(gap / free, NOTHING_DONE)
        return gap / max(size, free)
    return gap / size if size > 0.0 else gap


@inline_kernel
def natural_gap(
    forces: FloatArray, velocities: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray,
    step: float, convex: bool,
) -> tuple[float, float]:  # fmt: skip
    """Return ||λ - P_K(λ - step (u + Γ(u)))|| and ||λ|| for flat (3n,) forces and velocities."""
    gap = size = 0.0
    for k in range(mu.size):
        i = 3 * k
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        p, q, r = velocities[i], velocities[i + 1], velocities[i + 2]
        if not convex and low[k] > -np.inf:
            r += mu[k] * math.sqrt(p * p + q * q)
        a, b, c = project(x - step * p, y - step * q, z - step * r, mu[k], low[k], high[k])
        gap += (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
        size += x * x + y * y + z * z
    return math.sqrt(gap), math.sqrt(size)
