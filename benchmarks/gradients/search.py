"""Each method's gradients put to use: the same descent from the same starts, and who arrives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from benchmarks.gradients.estimators import Grid, Task

STEP, DECAY = 0.08, 0.88
"""First step of the descent, as a share of the range, and by how much it shrinks from one to the next."""
SAMPLES = 4
"""Of randomised gradients."""
CLOSE = 0.02
"""A search arrives if its loss is above the least by less than this share of the range of losses."""
FLAT = 1e-9
"""A slope below this is none."""
SMOOTHING, STIFFNESS = 1e-2, 1e4
"""[W] and [N/m]."""

Slope = Callable[[float, np.random.Generator], float]


class Outcome(NamedTuple):
    """How a method's searches ended: arrivals, starts, median distance from the best parameter, rollouts.

    The distance is a share of the range; rollouts are those of one search, a derivative counted as one more.
    """

    method: str
    arrived: int
    starts: int
    off: float
    rollouts: int


def methods(task: Task) -> dict[str, tuple[Slope, int]]:
    """Return each method's gradient, and how many rollouts it takes."""

    def first(theta: float, random: np.random.Generator) -> float:
        return float(np.mean([task.exact(theta + task.sigma * w) for w in random.normal(size=SAMPLES)]))

    def zeroth(theta: float, random: np.random.Generator) -> float:
        here, noise = task.loss(theta), random.normal(size=SAMPLES)
        ahead = np.array([task.loss(theta + task.sigma * w) for w in noise])
        return float(np.mean((ahead - here) * noise) / task.sigma)

    return {
        f"penalty, k = {STIFFNESS:g} N/m": (lambda theta, _: task.penalty_slope(theta, STIFFNESS), 2),
        "implicit, exact": (lambda theta, _: task.exact(theta), 2),
        f"implicit, smoothed {SMOOTHING:g} W": (lambda theta, _: task.smooth(theta, SMOOTHING), 2),
        f"randomised, first order, {SAMPLES} samples": (first, 2 * SAMPLES),
        f"randomised, zeroth order, {SAMPLES} samples": (zeroth, 1 + SAMPLES),
    }


def descend(task: Task, slope: Slope, start: float, iterations: int, seed: int) -> float:
    """Return where a descent by the slope's sign ends, with steps that shrink.

    The sign alone: slopes of penalty and of jumps differ by orders of magnitude, and no step would suit all.
    A slope of zero stays where it is.
    """
    random, theta, step = np.random.default_rng(seed), start, STEP * (task.high - task.low)
    for _ in range(iterations):
        d = slope(theta, random)
        theta = float(np.clip(theta - step * np.sign(d) * (abs(d) > FLAT), task.low, task.high))
        step *= DECAY
    return theta


def race(grid: Grid, starts: int, iterations: int) -> Iterator[Outcome]:
    """Yield how the searches of every method end."""
    task = grid.task
    inside = grid.loss[grid.inside]
    least, most = float(inside.min()), float(inside.max())
    best = float(grid.theta[grid.inside][int(np.argmin(inside))])
    begin = np.linspace(task.low, task.high, starts + 2)[1:-1]
    for name, (slope, rollouts) in methods(task).items():
        ends = np.array([descend(task, slope, s, iterations, seed) for seed, s in enumerate(begin)])
        above = np.array([task.loss(theta) for theta in ends]) - least
        arrived = int(np.count_nonzero(above <= CLOSE * (most - least)))
        off = float(np.median(np.abs(ends - best))) / (task.high - task.low)
        yield Outcome(name, arrived, starts, off, rollouts * iterations)
