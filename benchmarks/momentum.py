"""What the centroidal momentum matrix costs: three ways, against the number of links."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.problems.chains import chain
from benchmarks.timing import one_core
from surefoot.robot.ccrba import composite_momentum_matrix, summed_momentum_matrix

LINKS = (10, 20, 50, 100, 200, 300, 500, 1000)
PINOCCHIO_LINKS = 300
"""Longest chain given to Pinocchio: its Data takes memory like n³ (0.5 GB for 200 links, 8 GB for 500)."""
WAYS = ("pinocchio", "composite", "summed")
"""Pinocchio's sweep, our readable sweep (`ccrba.composite_momentum_matrix`), and the sum link by link."""


@dataclass(frozen=True)
class MomentumTiming:
    """Time of each way [s] at every chain length, the fastest of many calls, and the fitted growth.

    A law of growth is about the work, so other programs' share of the core is kept out: the fastest
    call, not the median.

    Attributes
    ----------
    links
        Chain lengths.
    seconds
        Way to times, one per length; NaN where it was not run.
    disagreement
        Largest relative difference between the three matrices.
    """

    links: tuple[int, ...]
    seconds: dict[str, tuple[float, ...]]
    disagreement: float

    def growth(self, way: str) -> float:
        """Return the exponent p of time ~ links^p over the longer half of the chains."""
        links, seconds = np.array(self.links, dtype=np.float64), np.array(self.seconds[way])
        ran = np.flatnonzero(np.isfinite(seconds))
        longer = ran[-max(2, len(ran) // 2) :]
        return float(np.polyfit(np.log(links[longer]), np.log(seconds[longer]), 1)[0])


def time_momentum(links: Sequence[int] = LINKS, budget: float = 0.5) -> MomentumTiming:
    """Time the three ways on chains of each length, about `budget` seconds for each measurement."""
    best: dict[str, list[float]] = {way: [] for way in WAYS}
    worst = 0.0
    with one_core():
        for count in links:
            calls, q = _ways(count)
            reference = composite_momentum_matrix(chain(count), q)[0]
            for way in WAYS:
                if way not in calls:
                    best[way].append(math.nan)
                    continue
                gap = np.abs(calls[way](q) - reference).max() / np.abs(reference).max()
                worst = max(worst, float(gap))
                best[way].append(_fastest(calls[way], q, budget))
    return MomentumTiming(tuple(links), {way: tuple(t) for way, t in best.items()}, worst)


def _ways(links: int) -> tuple[dict[str, Callable[[Any], Any]], Any]:
    """Return the functions of q to time on a chain, and a random q."""
    import pinocchio

    model = chain(links)
    tangent = np.random.default_rng(links).normal(size=model.nv)
    q = pinocchio.integrate(model, pinocchio.neutral(model), tangent)
    calls: dict[str, Callable[[Any], Any]] = {
        "composite": lambda at: composite_momentum_matrix(model, at)[0],
        "summed": lambda at: summed_momentum_matrix(model, at),
    }
    if links <= PINOCCHIO_LINKS:
        calls["pinocchio"] = partial(pinocchio.computeCentroidalMap, model, model.createData())
    return calls, q


def _fastest(call: Callable[[Any], Any], q: Any, budget: float) -> float:
    """Return the wall time of the fastest of at least 5 calls within about `budget` seconds."""
    clock, best, begin, calls = time.perf_counter, math.inf, time.perf_counter(), 0
    while calls < 5 or (clock() - begin < budget and calls < 5000):
        start = clock()
        call(q)
        best, calls = min(best, clock() - start), calls + 1
    return best
