"""Compiled projection onto one contact's friction pyramid, and its De Saxcé shift, for solvers.

A pyramid is a stack of equal sectors. The bearing of a point picks the face nearest to it; its foot on that
face's plane is the answer unless it passes an edge (then the edge is nearest) or the apex. Bounds on the
normal force cut a polygon, which the same sector rule handles.
"""

from __future__ import annotations

import math

from surefoot.base.kernels import inline_kernel
from surefoot.base.numerics.projection import project_truncated


@inline_kernel
def sector(
    x: float, y: float, mu: float, facets: int, inner: bool
) -> tuple[float, float, float, float, float, float]:
    """Return the face nearest to a point's bearing, and where the point is in its axes.

    The cosine and sine of the bearing of the face's middle; the face's slope and half its width at z = 1; the
    point's coordinates along the face's normal and along the face.
    """
    half = math.pi / facets
    middle = half if inner else 0.0
    turn = middle + 2.0 * half * math.floor((math.atan2(y, x) - middle) / (2.0 * half) + 0.5)
    c, s = math.cos(turn), math.sin(turn)
    slope = mu * math.cos(half) if inner else mu
    return c, s, slope, slope * math.tan(half), c * x + s * y, c * y - s * x


@inline_kernel
def project_any(
    x: float, y: float, z: float, mu: float, low: float, high: float, facets: int, inner: bool
) -> tuple[float, float, float]:
    """Return the nearest admissible force; facets = 0 is the exact cone, low = -inf a bilateral contact."""
    if low == -math.inf:
        return x, y, z
    if facets == 0 or mu == 0.0:
        return project_truncated(x, y, z, mu, low, high)
    # in the axes of the nearest face, and by symmetry in its upper half, the nearest point is on that face
    c, s, slope, corner, out, side = sector(x, y, mu, facets, inner)
    sign = 1.0 if side >= 0.0 else -1.0
    side = abs(side)
    a, b, h = out, side, z
    if out > slope * z:
        over = (out - slope * z) / (1.0 + slope * slope)  # onto the plane out = slope z
        a, h = out - over, z + slope * over
        if b > corner * h:  # beyond the edge (slope, corner, 1)
            h = (slope * out + corner * side + z) / (slope * slope + corner * corner + 1.0)
            a, b = slope * h, corner * h
        # the foot lies below the apex: the point is in the polar cone
        if h <= 0.0:
            a = b = h = 0.0
    if h < low or h > high:
        # the section is a convex polygon: where a bound is broken it holds at the answer, and what is left is
        # the nearest point of the polygon in the plane
        h = min(max(h, low), high)
        a, b = min(out, slope * h), min(side, corner * h)
    return c * a - s * sign * b, s * a + c * sign * b, h


@inline_kernel
def shift_any(p: float, q: float, mu: float, facets: int, inner: bool) -> float:
    """Return the De Saxcé shift: the largest -f_t . u_t over the section f_z = 1; mu ||u_t|| for a cone."""
    speed = math.sqrt(p * p + q * q)
    if facets == 0 or speed == 0.0:
        return mu * speed
    half = math.pi / facets
    # the support function of the section in the direction -u_t: that of the corner nearest in bearing. An
    # outer pyramid has its corners beyond the cone, at mu / cos(half)
    first = 0.0 if inner else half  # bearing of a corner
    bearing = math.atan2(-q, -p)
    off = bearing - first - 2.0 * half * math.floor((bearing - first) / (2.0 * half) + 0.5)
    return (mu if inner else mu / math.cos(half)) * speed * math.cos(off)
