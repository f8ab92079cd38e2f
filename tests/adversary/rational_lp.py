"""Linear programs in exact arithmetic: the simplex method on fractions, by rules that cannot cycle."""

from __future__ import annotations

import math
from fractions import Fraction

_LARGEST_FIRST = 60
"""Steps that go along the largest cost; Bland's rule afterwards."""


def largest(cost, rows, right):
    """Return the largest cost . x over rows @ x = right, x >= 0: -inf without such x, inf without bound."""
    count, more = len(cost), len(rows)
    table, basis = [], list(range(count, count + more))
    for k, (row, value) in enumerate(zip(rows, right, strict=True)):
        sign = -1 if value < 0 else 1
        line = [sign * Fraction(float(a)) for a in row] + [Fraction(0)] * more
        line[count + k] = Fraction(1)
        table.append([*line, sign * Fraction(float(value))])
    missing = _climb(table, basis, [Fraction(0)] * count + [Fraction(-1)] * more, count)
    if missing < 0:
        return -math.inf
    for k in range(more):
        if basis[k] >= count:
            usable = [j for j in range(count) if table[k][j] != 0]
            if usable:
                _pivot(table, basis, k, usable[0])
    return _climb(table, basis, [Fraction(float(c)) for c in cost] + [Fraction(0)] * more, count)


def _climb(table, basis, cost, usable):
    """Go up from a feasible basis; return the largest value."""
    left = [*cost, Fraction(0)]
    for line, b in zip(table, basis, strict=True):
        if left[b] != 0:
            left = [a - left[b] * t for a, t in zip(left, line, strict=True)]
    steps = 0
    while True:
        better = [j for j in range(usable) if left[j] > 0]
        if not better:
            return -left[-1]
        j = max(better, key=lambda q: left[q]) if steps < _LARGEST_FIRST else better[0]
        bounds = [(line[-1] / line[j], basis[k], k) for k, line in enumerate(table) if line[j] > 0]
        if not bounds:
            return math.inf
        k = min(bounds)[2]
        _pivot(table, basis, k, j)
        left = [a - left[j] * t for a, t in zip(left, table[k], strict=True)]
        steps += 1


def _pivot(table, basis, k, j):
    """Take column j into the basis, in place of row k's."""
    scale = table[k][j]
    table[k] = [a / scale for a in table[k]]
    for i, line in enumerate(table):
        if i != k and line[j] != 0:
            table[i] = [a - line[j] * t for a, t in zip(line, table[k], strict=True)]
    basis[k] = j
