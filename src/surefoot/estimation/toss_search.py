"""The search for the parameters of a simulator of tosses: boxes that shrink to what the data can tell.

The loss of a toss is the mean distance of its corners in sides, e, made robust as sqrt(c² + e²) - c with the
median error for c: a square for tosses that fit, the distance itself for those that end on another face. In
a box a few points (Sobol) carry a `ResponseSurface`; its minimum is the next centre. A box stops
shrinking where its half-width is a few standard errors, from the bootstrap over tosses: inside it there is
nothing left to find. A few dozen tosses lead the way, all of them finish. The model is a black box: every
simulator gets the same search.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.estimation.response import ResponseSurface, coefficients
from surefoot.estimation.toss_errors import resample, toss_errors
from surefoot.estimation.toss_model import TossModel, TossScene
from surefoot.estimation.tosses import Tosses

FEW = 96
"""Tosses that lead the way."""
FIRST = 6
"""Points of the first look per parameter and one more."""
FIRST_HALF, SHRINK = 0.2, 0.4
"""Half-width of the first box, as a share of the range, and by how much it shrinks at most."""
REACH, CLOSE = 3.5, 2.0
"""Half-width of the last box in standard errors, and by how much more it may be."""
FINEST, AT_BOUND = 5e-4, 0.05
"""Least half-width, and that of a parameter at the end of its range."""
EDGE = 0.9
"""A minimum farther out than this share of the box is at its edge: the box moves and keeps its size."""
ROUNDS = 14
"""Boxes that are tried in a row."""
LOOKS, NARROW, LOOK_SEED = 3, 5e-3, 1000
"""Looks around for another minimum, the least half-width of the coordinate that is held, and their seed."""
FLOOR = 1e-3
"""Least median error [sides] that the robust loss takes."""
TRIAL_RESAMPLES = 200


class SearchResult(NamedTuple):
    """What a search found.

    Attributes
    ----------
    values
        (d,) the parameters.
    draws
        (S, d) the same for each bootstrap sample.
    evaluations
        How often tosses were simulated, in units of all tosses.
    settled
        Whether the last box was a few standard errors wide, the minimum inside.
    """

    values: FloatArray
    draws: FloatArray
    evaluations: float
    settled: bool


class Trials:
    """Points that were tried on a set of tosses, and the corner errors there."""

    def __init__(self, model: TossModel, tosses: Tosses, scene: TossScene) -> None:
        self._model, self._tosses, self._scene = model, tosses, scene
        self.points: FloatArray = np.empty((0, len(model.parameters)))
        self.errors: FloatArray = np.empty((0, len(tosses)))
        self.simulated = 0

    def add(self, points: FloatArray, tick: Callable[[float], None]) -> None:
        """Simulate all tosses at (n, d) points, each number a share of its range."""
        for point in points:
            poses = self._model.rollout(values_of(self._model, point), self._scene)
            self.errors = np.vstack([self.errors, toss_errors(self._tosses, poses).corners])
            self.simulated += len(self._tosses)
            tick(float(len(self._tosses)))
        self.points = np.vstack([self.points, points])

    def losses(self, use: BoolArray) -> FloatArray:
        """Return (n, B) the robust losses [-] of the points in use."""
        means = np.median(self.errors, axis=1)
        c = max(float(means.min()), FLOOR)
        return np.asarray(np.sqrt(c * c + self.errors[use] ** 2) - c)

    def surface(self, centre: FloatArray, half: FloatArray) -> ResponseSurface:
        """Return the response surface over a box, centre and half sides (d,), from points in or near it."""
        use = self._near(centre, half)
        return ResponseSurface(self.points[use], self.losses(use), centre, half)

    def _near(self, centre: FloatArray, half: FloatArray) -> BoolArray:
        return np.asarray(np.all(np.abs(self.points - centre) <= 1.25 * half, axis=1))

    def best(self) -> FloatArray:
        """Return the point (d,) of least mean loss."""
        return np.asarray(
            self.points[int(np.argmin(self.losses(np.ones(len(self.points), bool)).mean(axis=1)))]
        )


def values_of(model: TossModel, share: FloatArray) -> FloatArray:
    """Return the (..., d) values at shares of the parameters' ranges."""
    return np.stack([p.value(share[..., k]) for k, p in enumerate(model.parameters)], axis=-1)


def _design(centre: FloatArray, half: FloatArray, count: int, seed: int) -> FloatArray:
    """Return (count, d) points of the box, inside the ranges."""
    low, high = np.maximum(centre - half, 0.0), np.minimum(centre + half, 1.0)
    power = int(np.ceil(np.log2(count)))
    unit = qmc.Sobol(centre.size, rng=np.random.default_rng(seed)).random_base2(power)[:count]
    return np.asarray(low + (high - low) * unit)


def spread_evenly(tosses: Tosses, count: int) -> IntArray:
    """Return the indices (count,) of so many tosses, evenly spread, or of all."""
    return np.unique(np.linspace(0, len(tosses) - 1, min(count, len(tosses))).round().astype(np.int64))


def search(
    model: TossModel,
    tosses: Tosses,
    scene: TossScene,
    draws: FloatArray,
    seed: int,
    tick: Callable[[float], None],
) -> SearchResult:
    """Fit a model's parameters.

    Parameters
    ----------
    model, tosses, scene
        What is fitted, and to what.
    draws
        (S, B) weights of the tosses in each bootstrap sample.
    seed
        Of the points that are tried.
    tick
        Told how many tosses have been simulated, after each point.
    """
    d = len(model.parameters)
    few = spread_evenly(tosses, FEW)
    trials = Trials(model, tosses.subset(few), scene.subset(few))
    trials.add(_design(np.full(d, 0.5), np.full(d, 0.5), FIRST * (d + 1), seed), tick)
    box = SearchBox(trials.best(), np.full(d, FIRST_HALF))
    leading = few.size < len(tosses)
    weights = resample(few.size, TRIAL_RESAMPLES, seed) if leading else draws
    led = _settle(trials, box, weights, seed, tick, coefficients(d) + 3)
    led = _look_around(trials, led, weights, seed, tick)
    box = SearchBox(led.least, led.target)
    if leading:
        narrower = led.target * np.sqrt(few.size / len(tosses)) * 1.3
        box = SearchBox(led.least, np.maximum(narrower, FINEST) / SHRINK)
        simulated, weights = trials.simulated, draws
        trials = Trials(model, tosses, scene)
        trials.simulated = simulated
    found = _settle(trials, box, weights, seed + ROUNDS, tick, coefficients(d) + 6)
    return SearchResult(
        values_of(model, found.least),
        values_of(model, found.surface.minimisers(weights, seed)),
        trials.simulated / len(tosses),
        found.settled,
    )


class SearchBox(NamedTuple):
    """Where points are tried: (d,) centre and half-width, as shares of the ranges."""

    centre: FloatArray
    half: FloatArray


class Settled(NamedTuple):
    """The last box of a search: its surface and minimum, the box it would like, whether it settled."""

    surface: ResponseSurface
    least: FloatArray
    target: FloatArray
    settled: bool


def _look_around(
    trials: Trials, led: Settled, weights: FloatArray, seed: int, tick: Callable[[float], None]
) -> Settled:
    """Return the best of the minima that a look at the whole ranges leads to.

    The loss is a narrow valley: only near its best-known coordinate (friction, as a rule) do the others show
    at all. That one is held within its interval, the others are tried from end to end.
    """
    d = led.least.size
    for number in range(LOOKS):
        half, known = np.ones(d), int(np.argmin(led.target))
        half[known] = max(2.0 * led.target[known], NARROW)
        trials.add(_design(led.least, half, FIRST * (d + 1), seed + LOOK_SEED + number), tick)
        best = trials.best()
        if (np.abs(best - led.least) <= CLOSE * led.target).all():
            break
        start = SearchBox(best, np.where(np.arange(d) == known, 2.0 * half, FIRST_HALF))
        other = _settle(trials, start, weights, seed + LOOK_SEED + ROUNDS, tick, coefficients(d) + 3)
        trials.add(np.stack([led.least, other.least]), tick)
        here, there = trials.losses(np.arange(len(trials.points)) >= len(trials.points) - 2).mean(axis=1)
        if here <= there:
            break
        led = other
    return led


def _settle(
    trials: Trials, box: SearchBox, weights: FloatArray, seed: int, tick: Callable[[float], None], count: int
) -> Settled:
    """Move and shrink a box over one set of tosses until it holds the minimum and little else."""
    for number in range(ROUNDS):
        trials.add(_design(*box, count, seed + number + 1), tick)
        surface = trials.surface(*box)
        least = surface.minimisers(np.ones((1, weights.shape[1])))[0]
        bound = (least <= 1e-9) | (least >= 1.0 - 1e-9)
        edge = (np.abs(least - box.centre) > EDGE * box.half) & ~bound
        spread = REACH * _spread(surface.minimisers(weights, seed))
        target = np.maximum(spread, np.where(bound, AT_BOUND, FINEST))
        settled = not (edge | (box.half > CLOSE * target)).any()
        if settled:
            break
        narrower = np.clip(target, SHRINK * box.half, box.half)
        box = SearchBox(least, np.where(edge, box.half, narrower))
    return Settled(surface, least, target, settled)


def _spread(points: FloatArray) -> FloatArray:
    """Return (d,) half the width that two thirds of (S, d) points take."""
    low, high = np.percentile(points, [16.0, 84.0], axis=0)
    return np.asarray(0.5 * (high - low))
