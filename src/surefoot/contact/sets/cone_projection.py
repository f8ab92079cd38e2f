"""Projection onto a friction cone or pyramid for the residuals of a solution, and its De Saxcé shift.

Written apart from those of the solvers (`contact/solvers/`), which do not import it: a certificate is an
independent opinion.
"""

from __future__ import annotations

import math

from surefoot.base.kernels import inline_kernel


@inline_kernel
def _face_mu(mu: float, facets: int, inner: bool) -> float:
    """Return the slope of a pyramid's faces (of the cone itself for facets = 0)."""
    return mu * math.cos(math.pi / facets) if facets > 0 and inner else mu


@inline_kernel
def length(x: float, y: float) -> float:
    """Return hypot(x, y); its own care for overflow is slow, and seldom needed."""
    square = x * x + y * y
    return math.sqrt(square) if 1e-250 < square < 1e250 else math.hypot(x, y)


@inline_kernel
def _nearest_round(
    x: float, y: float, z: float, mu: float, low: float, high: float
) -> tuple[float, float, float]:
    """Return the nearest admissible force of one contact on an exact cone."""
    radius = length(x, y)
    p, r = radius, z
    if radius > mu * z:
        along = mu * radius + z
        p, r = 0.0, 0.0
        # in the polar cone the apex is nearest; "not <=" lets a NaN through to be seen
        if not along <= 0.0:
            r = along / (1.0 + mu * mu)
            p = mu * r
    # the section is convex: a bound that the nearest point breaks holds at the answer
    if r < low or r > high:
        r = low if r < low else high
        p = min(radius, mu * r)
    if p == radius:
        return x, y, r
    share = p / radius
    return x * share, y * share, r


@inline_kernel
def nearest(
    x: float, y: float, z: float, mu: float, low: float, high: float, facets: int, inner: bool
) -> tuple[float, float, float]:
    """Return the nearest admissible force of one contact, in the unit of x, y, z and the bounds.

    Works in the half-plane through the normal and the force; for a pyramid in the chamber between a
    face's middle and its edge, which a projection onto a set with the same mirrors never leaves.
    """
    if facets == 0:
        return _nearest_round(x, y, z, mu, low, high)
    slope = _face_mu(mu, facets, inner)
    radius = math.hypot(x, y)
    bearing = math.atan2(y, x)
    sector = 2.0 * math.pi / facets
    start = 0.5 * sector if inner else 0.0  # direction of the first face's middle
    turn = start + sector * math.floor((bearing - start) / sector + 0.5)
    side = 1.0 if bearing >= turn else -1.0
    # by mirrors into one chamber, a the coordinate along the face's normal, b along the face
    a, b = radius * math.cos(bearing - turn), radius * abs(math.sin(bearing - turn))
    widen = math.tan(0.5 * sector)
    p, q, r = a, b, z
    if a > slope * z:
        r = (slope * a + z) / (1.0 + slope * slope)
        p = slope * r
        edge = slope * widen
        # the foot on the face's plane lies beyond its edge: onto the edge's ray instead
        if b > edge * r:
            r = (slope * a + edge * b + z) / (1.0 + slope * slope + edge * edge)
            p, q = slope * r, edge * r
        if r <= 0.0:
            p, q, r = 0.0, 0.0, 0.0
    if r < low or r > high:
        r = low if r < low else high
        p = min(a, slope * r)
        q = min(b, widen * slope * r)
    cosine, sine = math.cos(turn), math.sin(turn)
    return p * cosine - side * q * sine, p * sine + side * q * cosine, r


@inline_kernel
def dissipation_limit(ut_x: float, ut_y: float, mu: float, facets: int, inner: bool) -> float:
    """Return the largest -f_t . u_t over the section f_z = 1: mu ||u_t|| for the exact cone [m/s]."""
    speed = length(ut_x, ut_y)
    if facets == 0 or speed == 0.0:
        return mu * speed
    sector = 2.0 * math.pi / facets
    start = 0.0 if inner else 0.5 * sector  # direction of the first ray
    bearing = math.atan2(-ut_y, -ut_x)
    off = bearing - (start + sector * math.floor((bearing - start) / sector + 0.5))
    ray_mu = mu if inner else mu / math.cos(0.5 * sector)
    return ray_mu * speed * math.cos(off)
