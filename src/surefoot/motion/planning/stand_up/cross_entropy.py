"""The cross-entropy method: a normal distribution that moves to where the best of its samples are.

R. Y. Rubinstein, "The cross-entropy method for combinatorial and continuous optimization", Methodology and
Computing in Applied Probability 1, 1999. Each coordinate has its own deviation; the new mean and deviation
are mixed with the old ones, so that one lucky round does not end the search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray

KEPT = 0.2
"""Share of the old mean and deviation in the new ones."""


@dataclass(frozen=True)
class CrossEntropyResult:
    """What a search found.

    Attributes
    ----------
    point, cost
        The best sample (d,) and its cost.
    evaluations
        How many.
    reached
        Whether its cost is as low as was asked for.
    """

    point: FloatArray
    cost: float
    evaluations: int
    reached: bool


def cross_entropy(
    cost: Callable[[FloatArray], float],
    mean: FloatArray,
    deviation: FloatArray,
    *,
    samples: int = 48,
    elites: int = 8,
    rounds: int = 20,
    enough: float = -np.inf,
    seed: int = 0,
    tell: Callable[[int, float], None] | None = None,
) -> CrossEntropyResult:
    """Return the best of the points that were tried.

    The mean itself is the first sample, so that a good first guess is never lost. A `KeyboardInterrupt` ends
    the search with the best so far.

    Parameters
    ----------
    cost
        Of a point (d,); infinite or NaN where there is none.
    mean, deviation
        (d,) of the first samples.
    samples, elites
        Points in a round, and how many of them make the next distribution.
    rounds
        Most of them.
    enough
        A cost that ends the search.
    seed
        Of the samples.
    tell
        Called after every round with its number and the best cost so far.

    Examples
    --------
    >>> wide = np.full(2, 4.0)
    >>> found = cross_entropy(lambda x: float(((x - 3.0) ** 2).sum()), np.zeros(2), wide, rounds=40)
    >>> found.point.round(2)
    array([3., 3.])
    """
    generator = np.random.default_rng(seed)
    best, least, tried = mean, np.inf, 0
    try:
        for number in range(1, rounds + 1):
            points = mean + deviation * generator.normal(size=(samples, len(mean)))
            points[0] = mean
            costs = np.empty(samples)
            for k, point in enumerate(points):
                value = cost(point)
                costs[k] = value if np.isfinite(value) else np.inf
                tried += 1
                if costs[k] < least:
                    best, least = point.copy(), float(costs[k])
                if least <= enough:
                    break
            if tell is not None:
                tell(number, least)
            if least <= enough:
                break
            chosen = points[np.argsort(costs, kind="stable")[:elites]]
            mean = KEPT * mean + (1.0 - KEPT) * chosen.mean(axis=0)
            deviation = KEPT * deviation + (1.0 - KEPT) * chosen.std(axis=0)
    except KeyboardInterrupt:
        pass
    return CrossEntropyResult(best, least, tried, least <= enough)
