"""Where one contact's force may lie, in decimals: projections that try every face, edge and corner."""

from __future__ import annotations

import math
from decimal import Decimal

Vector = tuple[Decimal, Decimal, Decimal]
ZERO, ONE = Decimal(0), Decimal(1)


def rays(mu: Decimal, facets: int, inner: bool) -> list[tuple[Decimal, Decimal]]:
    """The corners of a pyramid's section at height 1; the inner one has a corner on the first tangent."""
    if mu == 0:
        return [(ZERO, ZERO)]
    start = 0.0 if inner else math.pi / facets
    size = mu if inner else mu / Decimal(math.cos(math.pi / facets))
    angles = [start + 2.0 * math.pi * i / facets for i in range(facets)]
    return [(size * Decimal(math.cos(a)), size * Decimal(math.sin(a))) for a in angles]


def norm(v: tuple[Decimal, ...]) -> Decimal:
    return sum((x * x for x in v), ZERO).sqrt()


def nearest(p: Vector, mu: Decimal, low: Decimal, high: Decimal | None, corners: list | None) -> Vector:
    """The admissible force nearest to p: every piece of the boundary is tried."""
    if corners is None or mu == 0:
        return _nearest_round(p, mu, low, high)
    return _nearest_pyramid(p, low, high, corners)


def _clamp(t: Decimal, low: Decimal, high: Decimal | None) -> Decimal:
    t = max(t, low)
    return t if high is None else min(t, high)


def _nearest_round(p: Vector, mu: Decimal, low: Decimal, high: Decimal | None) -> Vector:
    r, z = norm(p[:2]), p[2]
    if r <= mu * z and low <= z and (high is None or z <= high):
        return p
    t = _clamp((mu * r + z) / (1 + mu * mu), low, high)
    found = [(mu * t, t)]
    found += [(r, h) for h in (low, high) if h is not None and r <= mu * h]
    a, h = min(found, key=lambda q: (q[0] - r) ** 2 + (q[1] - z) ** 2)
    share = ZERO if r == 0 else a / r
    return p[0] * share, p[1] * share, h


def _nearest_pyramid(p: Vector, low: Decimal, high: Decimal | None, corners: list) -> Vector:
    pairs = list(zip(corners, corners[1:] + corners[:1], strict=True))
    planes = [(a[1] - b[1], b[0] - a[0], a[0] * b[1] - a[1] * b[0]) for a, b in pairs]  # a x b, inwards
    loose = Decimal("1e-60") * (1 + max(abs(x) for x in p))

    def inside(q: Vector) -> bool:
        walls = all(m[0] * q[0] + m[1] * q[1] + m[2] * q[2] >= -loose * norm(m) for m in planes)
        return walls and q[2] >= low - loose and (high is None or q[2] <= high + loose)

    if inside(p):
        return p
    found: list[Vector] = []
    for m in planes:
        over = (m[0] * p[0] + m[1] * p[1] + m[2] * p[2]) / (m[0] ** 2 + m[1] ** 2 + m[2] ** 2)
        foot = (p[0] - over * m[0], p[1] - over * m[1], p[2] - over * m[2])
        if inside(foot):
            found.append(foot)
    for c in corners:
        t = _clamp((c[0] * p[0] + c[1] * p[1] + p[2]) / (c[0] ** 2 + c[1] ** 2 + 1), low, high)
        found.append((c[0] * t, c[1] * t, t))
    for h in (low, high):
        if h is None:
            continue
        if inside((p[0], p[1], h)):
            found.append((p[0], p[1], h))
        for a, b in pairs:
            e = (h * (b[0] - a[0]), h * (b[1] - a[1]))
            square = e[0] ** 2 + e[1] ** 2
            if square > 0:
                t = _clamp(((p[0] - h * a[0]) * e[0] + (p[1] - h * a[1]) * e[1]) / square, ZERO, ONE)
                found.append((h * a[0] + t * e[0], h * a[1] + t * e[1], h))
    return min(found, key=lambda q: sum((x - y) ** 2 for x, y in zip(p, q, strict=True)))
