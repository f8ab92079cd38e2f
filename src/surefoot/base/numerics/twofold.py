"""Arithmetic in twice the digits of a double: numbers as unevaluated sums (high, low) of two.

About 32 digits, for the few systems of a few unknowns whose condition leaves a double none.

T. J. Dekker, "A floating-point technique for extending the available precision", Numerische Mathematik 18,
1971, for the product; D. E. Knuth, "The Art of Computer Programming", volume 2, section 4.2.2, for the sum.

Limits: sizes between 1e-140 and 1e140, beyond which a product's low part is lost or its split overflows.
"""

from __future__ import annotations

from surefoot.base.kernels import inline_kernel

SPLIT = 134217729.0
"""2^27 + 1 [-]: it parts a double of 53 bits into two of 26 (Dekker)."""

Twofold = tuple[float, float]


@inline_kernel
def _sum(a: float, b: float) -> Twofold:
    """Return a + b and its rounding error, exactly, for |a| >= |b| or a = 0."""
    total = a + b
    return total, b - (total - a)


@inline_kernel
def plus(a: Twofold, b: Twofold) -> Twofold:
    """Return a + b."""
    high = a[0] + b[0]
    part = high - a[0]
    low = (a[0] - (high - part)) + (b[0] - part)
    tail = a[1] + b[1]
    more = tail - a[1]
    rest = (a[1] - (tail - more)) + (b[1] - more)
    high, low = _sum(high, low + tail)
    return _sum(high, low + rest)


@inline_kernel
def minus(a: Twofold, b: Twofold) -> Twofold:
    """Return a - b."""
    return plus(a, (-b[0], -b[1]))


@inline_kernel
def times(a: Twofold, b: Twofold) -> Twofold:
    """Return a b."""
    high = a[0] * b[0]
    c, d = SPLIT * a[0], SPLIT * b[0]
    a_high, b_high = c - (c - a[0]), d - (d - b[0])
    a_low, b_low = a[0] - a_high, b[0] - b_high
    low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low
    return _sum(high, low + (a[0] * b[1] + a[1] * b[0]))


@inline_kernel
def over(a: Twofold, b: Twofold) -> Twofold:
    """Return a / b, by long division."""
    first = a[0] / b[0]
    rest = minus(a, times(b, (first, 0.0)))
    second = rest[0] / b[0]
    rest = minus(rest, times(b, (second, 0.0)))
    return plus(_sum(first, second), (rest[0] / b[0], 0.0))
