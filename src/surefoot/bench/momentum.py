"""What the centroidal momentum matrix costs: three ways, against the number of links."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from surefoot.bench.timing import one_core, time_calls
from surefoot.robot.ccrba import composite_momentum_matrix, summed_momentum_matrix

LINKS = (10, 20, 50, 100, 200, 300, 500, 1000)
PINOCCHIO_LINKS = 300
"""Longest chain given to Pinocchio: its Data takes memory like n³ (0.5 GB for 200 links, 8 GB for 500)."""
WAYS = ("pinocchio", "composite", "summed")
"""Pinocchio's sweep, our readable sweep (`ccrba.composite_momentum_matrix`), and the sum link by link."""


@dataclass(frozen=True)
class MomentumTiming:
    """Median time of each way [s] at every chain length, and the fitted growth.

    Attributes
    ----------
    links
        Chain lengths.
    seconds
        Way to medians, one per length; NaN where it was not run.
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
        longer = ran[len(ran) // 2 :]
        return float(np.polyfit(np.log(links[longer]), np.log(seconds[longer]), 1)[0])


def chain(links: int) -> Any:
    """Return a Pinocchio model of a floating chain of `links` bodies on joints about x and y by turns."""
    import pinocchio

    model = pinocchio.Model()
    body = pinocchio.Inertia.FromCylinder(0.5, 0.03, 0.1)
    joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "base")
    model.appendBodyToJoint(joint, body, pinocchio.SE3.Identity())
    hinges = (pinocchio.JointModelRX(), pinocchio.JointModelRY())
    step = pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, 0.1]))
    for k in range(links - 1):
        joint = model.addJoint(joint, hinges[k % 2], step, f"joint{k}")
        model.appendBodyToJoint(joint, body, pinocchio.SE3.Identity())
    return model


def time_momentum(links: Sequence[int] = LINKS, budget: float = 0.5) -> MomentumTiming:
    """Time the three ways on chains of each length, about `budget` seconds for each measurement."""
    medians: dict[str, list[float]] = {way: [] for way in WAYS}
    worst = 0.0
    with one_core():
        for count in links:
            calls, q = _ways(count)
            reference = composite_momentum_matrix(chain(count), q)[0]
            for way in WAYS:
                if way not in calls:
                    medians[way].append(math.nan)
                    continue
                gap = np.abs(calls[way](q) - reference).max() / np.abs(reference).max()
                worst = max(worst, float(gap))
                once = time_calls(calls[way], [q], warm_up=1).median
                repeats = min(2000, max(3, math.ceil(budget / once)))
                medians[way].append(time_calls(calls[way], [q] * repeats, warm_up=1).median)
    return MomentumTiming(tuple(links), {way: tuple(t) for way, t in medians.items()}, worst)


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
