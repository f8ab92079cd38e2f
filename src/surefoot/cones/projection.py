"""Compiled projections onto one contact's admissible set, shared by every solver.

The set is the truncated friction cone {f : ||(f_x, f_y)|| <= mu f_z, low <= f_z <= high}.
"""

from __future__ import annotations

import math

from surefoot.kernels import inline_kernel


@inline_kernel
def project_cone(x: float, y: float, z: float, mu: float) -> tuple[float, float, float]:
    """Return the nearest point of the friction cone of `mu` (finite)."""
    t = math.sqrt(x * x + y * y)
    if t <= mu * z:
        return x, y, z
    s = mu * t + z
    if s <= 0.0:
        return 0.0, 0.0, 0.0
    z_new = s / (1.0 + mu * mu)
    ratio = mu * z_new / t
    return ratio * x, ratio * y, z_new


@inline_kernel
def project_truncated(
    x: float, y: float, z: float, mu: float, low: float, high: float
) -> tuple[float, float, float]:
    """Return the nearest point of the friction cone cut to low <= f_z <= high.

    If the nearest point of the whole cone violates a bound on f_z, that bound is active at the
    answer (the section is convex), which is then the nearest point of a disc.
    """
    a, b, c = project_cone(x, y, z, mu)
    if c < low:
        c = low
    elif c > high:
        c = high
    else:
        return a, b, c
    t = math.sqrt(x * x + y * y)
    limit = mu * c
    if t <= limit:
        return x, y, c
    ratio = limit / t
    return ratio * x, ratio * y, c
