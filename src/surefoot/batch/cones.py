"""Friction cones in any framework's arrays, with gradients that are never NaN: for rewards and penalties.

Written in the few operations that `jax.numpy` and `torch` share; `xp` is either, and `hold` makes a
constant of an array (`stop_gradient`, `detach`). Lengths are taken where
they are not zero, so that neither value nor gradient at the apex or on the axis is 0/0; the length's
gradient there is taken as zero, which is one of its subgradients.
"""

from __future__ import annotations

from typing import Any

LEAST_NORMAL = 1e-3
"""Normal force [N] below which `friction_needed` divides by this instead."""


def length(xp: Any, hold: Any, vectors: Any) -> Any:
    """Return the lengths of (..., m) vectors, with gradient zero where they vanish."""
    return polar(xp, hold, vectors)[0]


def polar(xp: Any, hold: Any, vectors: Any) -> tuple[Any, Any]:
    """Return the lengths (...) and directions (..., m) of vectors, both zero where they vanish."""
    sizes = abs(vectors)
    largest = sizes[..., 0]
    for a in range(1, vectors.shape[-1]):
        largest = xp.maximum(largest, sizes[..., a])
    there = largest >= float(xp.finfo(vectors.dtype).tiny)
    unit = hold(xp.where(there, largest, xp.ones_like(largest)))  # no square overflows or vanishes
    shares = vectors / unit[..., None]
    square = (shares * shares).sum(-1)
    safe = xp.where(there, square, xp.ones_like(square))
    root = xp.sqrt(safe)
    directions = xp.where(there[..., None], shares / root[..., None], xp.zeros_like(shares))
    return xp.where(there, unit * root, xp.zeros_like(square)), directions


def margin(xp: Any, hold: Any, forces: Any, mu: Any) -> Any:
    """Return the signed distance of (..., 3) forces [N] to the cone's boundary; see `FrictionCone.margin`."""
    normal, radius = forces[..., 2], length(xp, hold, forces[..., :2])
    below = mu * radius + normal <= 0.0  # the apex is nearest
    return xp.where(below, -length(xp, hold, forces), (mu * normal - radius) / (1.0 + mu * mu) ** 0.5)


def friction_needed(xp: Any, hold: Any, forces: Any, least_normal: float = LEAST_NORMAL) -> Any:
    """Return ||f_t|| / f_n of (..., 3) forces; the divisor is never below `least_normal` [N]."""
    normal = forces[..., 2]
    floor = xp.full_like(normal, least_normal)
    return length(xp, hold, forces[..., :2]) / xp.where(normal > floor, normal, floor)


def project(xp: Any, hold: Any, forces: Any, mu: Any) -> Any:
    """Return the nearest points of the friction cone to (..., 3) forces [N]."""
    normal = forces[..., 2]
    radius, direction = polar(xp, hold, forces[..., :2])
    inside, below = (radius <= mu * normal) & (normal >= 0.0), mu * radius + normal <= 0.0
    height = (mu * radius + normal) / (1.0 + mu * mu)
    zero = xp.zeros_like(normal)
    height = xp.where(inside, normal, xp.where(below, zero, height))
    reach = xp.where(inside, radius, mu * height)
    return xp.stack([reach * direction[..., 0], reach * direction[..., 1], height], -1)
