"""Friction cones in any framework's arrays, with gradients that are never NaN: for rewards and penalties.

Written in the few operations that `jax.numpy` and `torch` share; `xp` is either. Lengths are taken where
they are not zero, so that neither value nor gradient at the apex or on the axis is 0/0; the length's
gradient there is taken as zero, which is one of its subgradients.
"""

from __future__ import annotations

from typing import Any

LEAST_NORMAL = 1e-3
"""Normal force [N] below which `friction_needed` divides by this instead."""


def length(xp: Any, vectors: Any) -> Any:
    """Return the lengths of (..., m) vectors, with gradient zero where they vanish."""
    sizes = abs(vectors)
    largest = sizes[..., 0]
    for a in range(1, vectors.shape[-1]):
        largest = xp.maximum(largest, sizes[..., a])
    there = largest > 0.0
    unit = xp.where(there, largest, xp.ones_like(largest))  # no square overflows or vanishes
    shares = vectors / unit[..., None]
    square = (shares * shares).sum(-1)
    safe = xp.where(there, square, xp.ones_like(square))
    return xp.where(there, unit * xp.sqrt(safe), xp.zeros_like(square))


def margin(xp: Any, forces: Any, mu: Any) -> Any:
    """Return the signed distance of (..., 3) forces [N] to the cone's boundary; see `FrictionCone.margin`."""
    normal, radius = forces[..., 2], length(xp, forces[..., :2])
    below = mu * radius + normal <= 0.0  # the apex is nearest
    return xp.where(below, -length(xp, forces), (mu * normal - radius) / (1.0 + mu * mu) ** 0.5)


def friction_needed(xp: Any, forces: Any, least_normal: float = LEAST_NORMAL) -> Any:
    """Return ||f_t|| / f_n of (..., 3) forces; the divisor is never below `least_normal` [N]."""
    normal = forces[..., 2]
    floor = xp.full_like(normal, least_normal)
    return length(xp, forces[..., :2]) / xp.where(normal > floor, normal, floor)


def project(xp: Any, forces: Any, mu: Any) -> Any:
    """Return the nearest points of the friction cone to (..., 3) forces [N]."""
    normal = forces[..., 2]
    radius = length(xp, forces[..., :2])
    mu = mu + xp.zeros_like(normal)
    inside, polar = radius <= mu * normal, (mu * radius + normal <= 0.0)
    height = (mu * radius + normal) / (1.0 + mu * mu)
    safe = xp.where(radius > 0.0, radius, xp.ones_like(radius))
    share = xp.where(inside, xp.ones_like(radius), mu * height / safe)
    zero = xp.zeros_like(radius)
    share = xp.where(polar & ~inside, zero, share)
    height = xp.where(inside, normal, xp.where(polar, zero, height))
    return xp.stack([share * forces[..., 0], share * forces[..., 1], height], -1)
