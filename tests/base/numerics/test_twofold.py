"""Sums, products and quotients of pairs of doubles, against exact fractions."""

from fractions import Fraction

import numpy as np

from surefoot.base.kernels import kernel
from surefoot.base.numerics.twofold import minus, over, plus, times


@kernel
def answers(a, b):
    return plus(a, b), minus(a, b), times(a, b), over(a, b)


def test_pairs_carry_thirty_digits():
    rng = np.random.default_rng(0)
    for _ in range(300):
        high = rng.normal(size=2) * 10.0 ** rng.uniform(-30, 30, 2)
        a, b = ((h, h * rng.uniform(-1, 1) * 2.0**-53) for h in high)
        x, y = (Fraction(p[0]) + Fraction(p[1]) for p in (a, b))
        exact = (x + y, x - y, x * y, x / y)
        for told, true in zip(answers(a, b), exact, strict=True):
            assert abs(Fraction(told[0]) + Fraction(told[1]) - true) <= abs(true) * Fraction(1, 10**30)
            assert told[0] + told[1] == told[0]


def test_what_cancels_is_left_exactly():
    third = over((1.0, 0.0), (3.0, 0.0))
    rest = minus((1.0, 0.0), times(third, (3.0, 0.0)))
    assert abs(rest[0]) < 1e-31
    assert plus((1.0, 1e-20), (-1.0, 0.0)) == (1e-20, 0.0)
