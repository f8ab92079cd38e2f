"""The nearest point of one contact's admissible set, shared by every solver, and how it moves with the point.

The set is the truncated friction cone {f : ||(f_x, f_y)|| <= mu f_z, low <= f_z <= high}.
"""

from __future__ import annotations

import math

from surefoot.base.kernels import inline_kernel


@inline_kernel
def project_cone(x: float, y: float, z: float, mu: float) -> tuple[float, float, float]:
    """Return the nearest point of the friction cone of `mu` (finite)."""
    t = math.sqrt(x * x + y * y)
    if t <= mu * z and z >= 0.0:  # without friction 0 <= mu z holds below the ray, too
        return x, y, z
    # s <= 0: in the polar cone, ||f_t|| mu <= -f_z, whose nearest point is the apex
    s = mu * t + z
    if s <= 0.0:
        return 0.0, 0.0, 0.0
    # onto the generator (mu e, 1) through the point's own bearing
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


@inline_kernel
def face(
    x: float, y: float, z: float, mu: float, low: float, high: float
) -> tuple[bool, bool, float, float, float, float]:
    """Return the generalised Jacobian of `project_truncated` at a point whose projection has the height z.

    A sum of v vᵀ over orthogonal v, named by (sticks, free, p, q, across, along): where the tangential force
    sticks, v are the tangents and, if the height is free between its bounds, the normal; on the cone's side
    (-q, p, 0) `across` and (mu p, mu q, 1) `along`, with the point's direction (p, q). `across` squared is
    mu z / ||(x, y)||: how much a sideways move of the point moves the force. Zeros at the apex.
    """
    limit, t = mu * z, math.sqrt(x * x + y * y)
    free = low < z < high
    if t <= limit and limit > 0.0:
        return True, free, 0.0, 0.0, 0.0, 0.0
    # at the apex the projection is constant: no direction moves it
    if not z > 0.0:
        return False, False, 0.0, 0.0, 0.0, 0.0
    p, q = (x / t, y / t) if t > 0.0 else (0.0, 0.0)
    # the rim turns with the point: a sideways move at distance t is one of mu z / t on the rim
    across = math.sqrt(limit / t) if limit > 0.0 else 0.0
    return False, free, p, q, across, 1.0 / math.sqrt(1.0 + mu * mu) if free else 0.0


@inline_kernel
def differential(
    x: float, y: float, z: float, mu: float, low: float, high: float, dx: float, dy: float, dz: float
) -> tuple[float, float, float]:
    """Return `face` times (dx, dy, dz): how the projection moves with its point, in first order."""
    sticks, free, p, q, across, along = face(x, y, z, mu, low, high)
    if sticks:
        return dx, dy, dz if free else 0.0
    # Π' d = Σ v (v·d), with e⊥ = (-q, p, 0)
    side = across * across * (p * dy - q * dx)
    up = along * along * (mu * (p * dx + q * dy) + dz)
    return p * mu * up - q * side, q * mu * up + p * side, up
