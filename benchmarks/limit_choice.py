"""Whether the value of a limit is chosen again when others are tried, away from it in both directions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.limits import values_away
from surefoot.base.settings import DescribedSetting

FACTORS = (1.5, 2.0, 4.0, 16.0, 64.0)
"""Steps away from a limit's value, each way; of its distance from one, too, where that is small."""


@dataclass(frozen=True)
class Choice:
    """What came of varying one limit.

    Attributes
    ----------
    name, value
        Of the limit.
    score, noise
        With its value, and differences of scores that say nothing.
    low, high
        Least and largest value tried, next to its own, that does no worse.
    tried
        (value, score) of all that were tried, rising.
    """

    name: str
    value: float
    score: float
    noise: float
    low: float
    high: float
    tried: tuple[tuple[float, float], ...]

    @property
    def better(self) -> tuple[float, ...]:
        """Values that do better."""
        return tuple(value for value, score in self.tried if score > self.score + self.noise)

    @property
    def verdict(self) -> str:
        """Whether the choice is repeated, and the values that do as well."""
        if self.better:
            return "better: " + ", ".join(f"{value:.4g}" for value in self.better)
        if all(score >= self.score - self.noise for _, score in self.tried):
            return "not decided: all values tried do as well"
        return f"as good from {self.low:.4g} to {self.high:.4g}"


def vary(one: DescribedSetting, score: Callable[[float], float], noise: float) -> Choice:
    """Return what comes of varying a limit whose values have scores: further until one is worse."""
    value = float(one.value)
    tried = {value: score(value)}
    ends = [value, value]
    for way in (0, 1):
        near = values_away(one.name, value, one.info.whole, bool(way), FACTORS)
        far = () if one.info.whole else (value * (f if way else 1.0 / f) for f in FACTORS)
        for new in sorted({*near, *far}, reverse=not way):
            low, high = one.info.low, one.info.high
            clipped = min(max(new, -math.inf if low is None else low), math.inf if high is None else high)
            if clipped in tried:
                break
            tried[clipped] = score(clipped)
            if tried[clipped] < tried[value] - noise:
                break
            ends[way] = clipped
    return Choice(one.name, value, tried[value], noise, ends[0], ends[1], tuple(sorted(tried.items())))
