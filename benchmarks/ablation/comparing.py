"""Paired comparisons: what is lost beyond noise between trials with the same tasks and seeds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

MEASURES = {
    "error": "velocity error",
    "cost": "cost of transport",
    "friction": "friction used",
    "load": "largest force",
    "hits": "hits",
}
"""Measures by their names in a record; less of each is better."""
SIGNIFICANT = 0.05
"""Probability under which a difference of survivals is none of chance."""
WORTH = {"error": 0.02, "cost": 0.02, "friction": 0.05, "load": 0.15, "hits": 0.02}
"""Difference that matters: of the error in m/s, of hits in steps with one, of the others as a share."""
ABSOLUTE = ("error", "hits")
"""Measures whose differences are not put over the measure itself."""

Records = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Difference:
    """A measure of the trials that were done both ways.

    Attributes
    ----------
    measure
        See `MEASURES`.
    before, after
        Means with everything, and with the change.
    low, high
        95 % interval of the mean of the differences, after less before.
    """

    measure: str
    before: float
    after: float
    low: float
    high: float

    @property
    def size(self) -> float:
        """How much is lost, see `WORTH`; 0 where it may be noise."""
        if self.low <= 0.0 <= self.high:
            return 0.0
        change = self.after - self.before
        return change if self.measure in ABSOLUTE else change / max(self.before, 1e-9)

    @property
    def worse(self) -> bool:
        """Whether more is lost than noise, and enough to matter."""
        return self.size > WORTH[self.measure]

    @property
    def better(self) -> bool:
        """Whether it is better by as much."""
        return self.size < -WORTH[self.measure]


@dataclass(frozen=True)
class Comparison:
    """A task with a change and without it, over the same seeds.

    Attributes
    ----------
    task
        Its name.
    trials, before, after
        How many there are; how many were done with everything, and with the change.
    chance
        Probability of so unequal a split if the change does nothing (exact sign test).
    differences
        Of the measures.
    """

    task: str
    trials: int
    before: int
    after: int
    chance: float
    differences: tuple[Difference, ...]

    @property
    def worse(self) -> bool:
        """Whether anything is worse beyond noise."""
        fewer = self.after < self.before and self.chance < SIGNIFICANT
        return fewer or any(one.worse for one in self.differences)

    @property
    def better(self) -> bool:
        """Whether anything is better beyond noise."""
        more = self.after > self.before and self.chance < SIGNIFICANT
        return more or any(one.better for one in self.differences)


def compare(task: str, before: Records, after: Records) -> Comparison:
    """Return the comparison of a task's trials, paired by their seeds."""
    first = {one["seed"]: one for one in before if one["task"] == task}
    second = {one["seed"]: one for one in after if one["task"] == task}
    seeds = sorted(first.keys() & second.keys())
    done = [(bool(first[s]["done"]), bool(second[s]["done"])) for s in seeds]
    lost, won = done.count((True, False)), done.count((False, True))
    both = [s for s, pair in zip(seeds, done, strict=True) if all(pair)]
    found = (difference(m, [first[s][m] for s in both], [second[s][m] for s in both]) for m in MEASURES)
    return Comparison(
        task, len(seeds), sum(a for a, _ in done), sum(b for _, b in done), sign_test(lost, won),
        tuple(one for one in found if one is not None),
    )  # fmt: skip


def sign_test(lost: int, won: int) -> float:
    """Return the two-sided probability of a split at least so unequal by a fair coin.

    Examples
    --------
    >>> sign_test(6, 0), sign_test(1, 1)
    (0.03125, 1.0)
    """
    n, less = lost + won, min(lost, won)
    return min(1.0, 2.0 * sum(math.comb(n, k) for k in range(less + 1)) / 2.0**n)


def difference(
    measure: str, before: Sequence[float | None], after: Sequence[float | None]
) -> Difference | None:
    """Return the difference of paired values with Student's interval; None for fewer than three pairs."""
    from scipy.stats import t

    pairs = np.array([(a, b) for a, b in zip(before, after, strict=True) if a is not None and b is not None])
    if len(pairs) < 3:
        return None
    change = pairs[:, 1] - pairs[:, 0]
    spread = float(t.ppf(0.975, len(change) - 1)) * float(change.std(ddof=1)) / math.sqrt(len(change))
    mean = float(change.mean())
    return Difference(
        measure, float(pairs[:, 0].mean()), float(pairs[:, 1].mean()), mean - spread, mean + spread
    )
