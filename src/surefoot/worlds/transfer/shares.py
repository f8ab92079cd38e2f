"""What a count of successes says of their share, and of the difference of two shares.

References
----------
.. [1] R. G. Newcombe, "Interval estimation for the difference between independent proportions: comparison of
   eleven methods", Statistics in Medicine 17 (1998), method 10.
"""

from __future__ import annotations

import math

NORMAL_95 = 1.959963984540054
"""Two-sided quantile of the normal distribution for 95 %."""


def share_interval(count: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share.

    >>> low, high = share_interval(10, 10)
    >>> round(low, 3), high
    (0.722, 1.0)
    """
    if of == 0:
        return 0.0, 1.0
    z, p = NORMAL_95, count / of
    middle = (p + z * z / (2 * of)) / (1.0 + z * z / of)
    half = z / (1.0 + z * z / of) * math.sqrt(p * (1.0 - p) / of + z * z / (4.0 * of * of))
    low = 0.0 if count == 0 else max(middle - half, 0.0)
    return low, 1.0 if count == of else min(middle + half, 1.0)


def difference_interval(one: tuple[int, int], other: tuple[int, int]) -> tuple[float, float]:
    """Return the 95 % interval of the first share less the other, of counts (successes, of) [1]_.

    >>> low, high = difference_interval((0, 10), (10, 10))
    >>> high < 0.0
    True
    """
    (p, q), (a, b) = ((n / m if m else 0.5 for n, m in (one, other)), (one, other))
    (low, high), (least, most) = share_interval(*a), share_interval(*b)
    d = p - q
    return (
        max(d - math.hypot(p - low, most - q), -1.0),
        min(d + math.hypot(high - p, q - least), 1.0),
    )


def chance_of(one: tuple[int, int], other: tuple[int, int]) -> float:
    """Return with what chance two counts (successes, of) of one and the same share differ as much: Fisher's.

    The sum over all tables with the same sums that are no likelier. Newcombe's interval alone leaves out zero
    too often where counts are small: at 1 of 4 and 4 of 4, of which this says 0.14.

    >>> round(chance_of((1, 4), (4, 4)), 3), round(chance_of((0, 4), (4, 4)), 3)
    (0.143, 0.029)
    """
    (a, n), (b, m) = one, other
    total = a + b

    def likelihood(k: int) -> int:
        return math.comb(n, k) * math.comb(m, total - k)

    seen = likelihood(a)
    tables = range(max(0, total - m), min(n, total) + 1)
    return sum(x for x in map(likelihood, tables) if x <= seen) / math.comb(n + m, total)
