"""The certificate of a batch in a framework's arrays (`xp`, a `Framework`): scales, velocity error, status.

The definitions are those of `problem.scales` and `problem.residuals`, for exact cones with normal_min = 0
and normal_max = 0 or infinity. In single precision the roundings are single precision's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.contact.batch.answers import ALMOST, INVALID, SOLVED, STALLED
from surefoot.contact.problem.scales import LENT, REST
from surefoot.contact.sets.contact import APPROACH
from surefoot.contact.solvers.solver import ALMOST_FACTOR

NOISE = 68.0
"""Share of sqrt(trace G_kk trace G_jj), in machine epsilons, up to which entries of G_kj are rounding."""


class Scales(NamedTuple):
    """w_k, s_k and the energy of the part, all (..., n); see `contact.problem.scales`."""

    weight: Any
    speed: Any
    energy: Any


def blocks_of(xp: Any, G: Any) -> Any:
    """Return the (..., n, n, 3, 3) blocks of G."""
    n = G.shape[-1] // 3
    return xp.swapaxes(xp.reshape(G, (*G.shape[:-2], n, 3, n, 3)), -3, -2)


def diagonal_of(xp: Any, blocks: Any) -> Any:
    """Return the diagonal blocks (..., n, 3, 3) of (..., n, n, 3, 3)."""
    return xp.moveaxis(xp.diagonal(blocks, 0, -4, -3), -1, -3)


def symmetric_norm(xp: Any, B: Any) -> Any:
    """Return the spectral norms of symmetric (..., 3, 3) matrices, in closed form (O. K. Smith, 1961)."""
    top = xp.amax(abs(B), (-2, -1))
    unit = xp.where(top > 0.0, top, xp.ones_like(top))
    B = B / unit[..., None, None]
    mean = (B[..., 0, 0] + B[..., 1, 1] + B[..., 2, 2]) / 3.0
    a, b, c = (B[..., i, i] - mean for i in range(3))
    d, e, f = B[..., 0, 1], B[..., 0, 2], B[..., 1, 2]
    half = (a * a + b * b + c * c) / 6.0 + (d * d + e * e + f * f) / 3.0
    radius = xp.sqrt(half)
    volume = xp.where(half > 0.0, 2.0 * half * radius, xp.ones_like(half))
    cosine = (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / volume
    # the trigonometric root of the characteristic cubic, and of that of -B: the end farther out
    angle = xp.arccos(xp.clip(cosine, -1.0, 1.0)) / 3.0
    low = xp.arccos(xp.clip(-cosine, -1.0, 1.0)) / 3.0
    high = mean + 2.0 * radius * xp.cos(angle)
    return xp.maximum(high, 2.0 * radius * xp.cos(low) - mean) * top


def lawful(xp: Any, G: Any, g: Any, mu: Any) -> tuple[Any, Any, Any, Any]:
    """Return the symmetric part of G, g and mu, and which problems are problems; others are made zero."""
    good = xp.isfinite(G).all(-1).all(-1) & xp.isfinite(g).all(-1) & (xp.isfinite(mu) & (mu >= 0.0)).all(-1)
    G = xp.where(good[..., None, None], 0.5 * G + 0.5 * xp.swapaxes(G, -1, -2), 0.0)
    return G, xp.where(good[..., None], g, 0.0), xp.where(good[..., None], mu, 0.0), good


def velocities_of(xp: Any, G: Any, g: Any, forces: Any) -> Any:
    """Return G λ + g, (..., n, 3)."""
    flat = xp.reshape(forces, g.shape)
    return xp.reshape((G @ flat[..., None])[..., 0] + g, forces.shape)


def scales(xp: Any, G: Any, g: Any, on: Any) -> Scales:
    """Return the scales of problems (..., 3n, 3n), (..., 3n) with contacts on or off (..., n)."""
    blocks = blocks_of(xp, G)
    n = on.shape[-1]
    diagonal = diagonal_of(xp, blocks)
    weight = symmetric_norm(xp, diagonal)
    trace = abs(xp.einsum("...kaa->...k", diagonal))
    entry = xp.amax(abs(blocks), (-2, -1))
    noise = NOISE * float(xp.finfo(G.dtype).eps)
    both = on[..., :, None] & on[..., None, :]
    free = xp.reshape(g, (*g.shape[:-1], n, 3))
    top = xp.amax(abs(free), -1)
    unit = xp.where(top > 0.0, top, xp.ones_like(top))
    size = top * xp.sqrt(((free / unit[..., None]) ** 2).sum(-1))
    size = xp.where(on & (size > REST), size, xp.zeros_like(size))
    root = xp.sqrt(trace)
    speed = xp.zeros_like(size)
    # the wide parts first, joined by any entry, lend a little; `most` and
    # `part` of the proper ones are left last
    for share, bound in ((LENT, 0.0), (1.0, noise)):
        joined = (entry > bound * root[..., :, None] * root[..., None, :]) & both
        part = _closure(xp, joined | (xp.eye(n, size) > 0.0))
        most = xp.amax(xp.where(part, size[..., None, :], 0.0), -1)
        speed = xp.maximum(speed, share * most)
    own = xp.where(on & (weight > 0.0), most / xp.where(weight > 0.0, weight, 1.0) * most, 0.0)
    energy = xp.where(part, own[..., None, :], 0.0).sum(-1)
    return Scales(weight, xp.where(on, speed, xp.zeros_like(speed)), energy)


def _closure(xp: Any, joined: Any) -> Any:
    """Return which contacts are joined through others: the transitive closure of (..., n, n)."""
    reach, n = 1, joined.shape[-1]
    while reach < n - 1:
        # squaring the graph doubles the length of the ways that it knows: log n products
        joined = (joined[..., :, :, None] & joined[..., None, :, :]).any(-2)
        reach *= 2
    return joined


def velocity_errors(xp: Any, forces: Any, velocities: Any, mu: Any, s: Scales, on: Any, convex: bool) -> Any:
    """Return ε_k / s_k (..., n) of forces and velocities (..., n, 3)."""
    rest = ~(s.speed > 0.0)
    weight = xp.where(s.weight > 0.0, s.weight, xp.ones_like(s.weight))
    unit = 1.0 / xp.where(rest, xp.ones_like(s.speed), s.speed)
    slip = xp.hypot(velocities[..., 0], velocities[..., 1])
    lift = velocities[..., 2] if convex else velocities[..., 2] + mu * slip
    v = xp.stack([velocities[..., 0], velocities[..., 1], lift], -1) * unit[..., None]
    own = (weight * unit)[..., None] * forces
    p = own - v
    near = nearest(xp, p, mu)
    # w λ where a huge Γ would drown it, see `contact.problem.residuals`
    gap = xp.where((abs(v).sum(-1) > abs(own).sum(-1))[..., None], own - near, v - (near - p))
    size = xp.maximum(xp.sqrt((gap * gap).sum(-1)), -APPROACH * unit * velocities[..., 2])
    idle = xp.where((forces == 0.0).all(-1), xp.zeros_like(size), xp.full_like(size, xp.inf))
    return xp.where(on & ~rest, size, idle)


def nearest(xp: Any, p: Any, mu: Any) -> Any:
    """Return p projected to the friction cones."""
    radius, z = xp.hypot(p[..., 0], p[..., 1]), p[..., 2]
    length = xp.hypot(xp.ones_like(mu), mu)  # its square overflows in single precision from 1e19 on
    height = xp.clip(mu * radius + z, 0.0) / length / length
    outside = (radius > mu * z) | (z < 0.0)  # without friction the cone is a ray, with nothing below
    share = xp.where(outside, mu * height / xp.where(radius > 0.0, radius, 1.0), 1.0)
    return xp.stack([p[..., 0] * share, p[..., 1] * share, xp.where(outside, height, z)], -1)


def judge(
    xp: Any, G: Any, forces: Any, velocities: Any, mu: Any, s: Scales, on: Any, convex: bool, tol: float
) -> tuple[Any, Any]:
    """Return status codes and velocity errors (...) as `contact.problem.residuals` would give them."""
    error = xp.amax(velocity_errors(xp, forces, velocities, mu, s, on, convex), -1)
    sizes = xp.sqrt((forces * forces).sum(-1))
    norms = xp.sqrt((blocks_of(xp, G) ** 2).sum(-1)).sum(-1)  # at least the block's norm
    open_ = 4.0 * float(xp.finfo(G.dtype).eps) * (norms * sizes[..., None, :]).sum(-1)
    if not convex:  # Γ = mu ||u_t|| grows what rounding does to a velocity
        open_ = open_ * xp.clip(mu, 1.0)
    moving = s.speed > 0.0
    rest = xp.amax(xp.where(moving, open_ / xp.where(moving, s.speed, 1.0), 0.0), -1)
    if convex:
        power = abs((forces * velocities).sum(-1))
        some = s.energy > 0.0
        # normal_min = 0: the least of λ·u over the cone is zero, so λ·u itself is the gap
        gap = xp.where(some, power / xp.where(some, s.energy, 1.0), xp.where(power > 0.0, xp.inf, 0.0))
        rest = xp.maximum(rest, xp.amax(gap, -1))
    near = xp.where(error <= tol, SOLVED, xp.where(error <= ALMOST_FACTOR * tol, ALMOST, STALLED))
    status = xp.where(rest <= tol, near, STALLED)
    lost = ~(xp.isfinite(error) | (error == xp.inf))
    return xp.where(lost, INVALID, status), xp.where(lost, xp.inf, error)
