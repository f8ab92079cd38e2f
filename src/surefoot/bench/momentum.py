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

LINKS = (10, 20, 50, 100, 200, 500, 1000)
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
        Way to medians, one per length.
    disagreement
        Largest relative difference between the three matrices.
    """

    links: tuple[int, ...]
    seconds: dict[str, tuple[float, ...]]
    disagreement: float

    def growth(self, way: str) -> float:
        """Return the exponent p of time ~ links^p over the longer half of the chains."""
        half = len(self.links) // 2
        slope = np.polyfit(np.log(self.links[half:]), np.log(self.seconds[way][half:]), 1)[0]
        return float(slope)


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
    import pinocchio

    medians: dict[str, list[float]] = {way: [] for way in WAYS}
    worst = 0.0
    with one_core():
        for count in links:
            model = chain(count)
            data = model.createData()
            tangent = np.random.default_rng(count).normal(size=model.nv)
            q = pinocchio.integrate(model, pinocchio.neutral(model), tangent)
            calls: dict[str, Callable[[Any], Any]] = {
                "pinocchio": partial(pinocchio.computeCentroidalMap, model, data),
                "composite": partial(_first, composite_momentum_matrix, model),
                "summed": partial(summed_momentum_matrix, model),
            }
            reference = np.array(calls["pinocchio"](q))
            for way, call in calls.items():
                gap = np.abs(call(q) - reference).max() / np.abs(reference).max()
                worst = max(worst, float(gap))
                once = time_calls(call, [q], warm_up=1).median
                repeats = min(2000, max(3, math.ceil(budget / once)))
                medians[way].append(time_calls(call, [q] * repeats, warm_up=1).median)
    return MomentumTiming(tuple(links), {way: tuple(t) for way, t in medians.items()}, worst)


def _first(function: Callable[..., Any], *arguments: Any) -> Any:
    return function(*arguments)[0]
