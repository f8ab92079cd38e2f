"""Bias and spread of gradients: what each method says about the slope of a loss, and what is true.

A task's loss and exact slope are computed once on a fine grid. Randomised smoothing with Gaussian noise of
deviation sigma then has its mean and variance by quadrature on that grid, not by sampling:

    zeroth order   (f(θ + σ w) - f(θ)) w / σ        unbiased for the smoothed loss, whatever f does
    first order    f'(θ + σ w)                      unbiased only where f has no jumps

H. J. T. Suh, M. Simchowitz, K. Zhang, R. Tedrake, "Do differentiable simulators give better policy
gradients?", ICML 2022.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from benchmarks.gradients.landing import Landing
from benchmarks.gradients.systems import Path, System, penalty, rollout
from surefoot.base.arrays import FloatArray, IntArray

SIGMA = 0.04
"""Noise of randomised smoothing, as a share of the range."""
REACH = 4.0
"""The noise is cut off at so many deviations."""
MATTERS = 0.02
"""A slope below this share of the slopes' size has no sign to be wrong about."""


@dataclass(frozen=True)
class Task:
    """A loss of one parameter, by every method.

    Attributes
    ----------
    name, low, high
        What it is called and the range of the parameter.
    loss
        The exact loss.
    exact, smooth
        Its implicit derivative, and the smoothed one for a smoothing [W].
    penalty
        The loss on springs of a stiffness [N/m].
    """

    name: str
    low: float
    high: float
    loss: Callable[[float], float]
    exact: Callable[[float], float]
    smooth: Callable[[float, float], float]
    penalty: Callable[[float, float], float]

    def penalty_slope(self, theta: float, stiffness: float) -> float:
        """Return the derivative of the loss on springs, by differences."""
        e = 1e-4 * (self.high - self.low)
        return (self.penalty(theta + e, stiffness) - self.penalty(theta - e, stiffness)) / (2.0 * e)

    @property
    def sigma(self) -> float:
        """Deviation of the noise, in the parameter's unit."""
        return SIGMA * (self.high - self.low)


def of_system(system: System) -> Task:
    """Return the task of a small system."""
    return _task(system, partial(rollout, system), partial(penalty, system))


def of_landing(landing: Landing) -> Task:
    """Return the task of the robot."""
    return _task(landing, landing.run, landing.soft)


def _task(what: System | Landing, run: Callable[..., Path], soft: Callable[[float, float], float]) -> Task:
    """Return the task of what is run exactly, with its derivative, and on springs."""
    return Task(
        what.name, what.low, what.high,
        lambda theta: run(theta).loss,
        lambda theta: run(theta, derivative=True).slope,
        lambda theta, smoothing: run(theta, derivative=True, smoothing=smoothing).slope,
        soft,
    )  # fmt: skip


class Moments(NamedTuple):
    """Mean and standard deviation of one sample; the zeroth order's mean is the smoothed loss' slope."""

    zeroth: float
    zeroth_spread: float
    first: float
    first_spread: float


class Grid:
    """Loss and exact slope of a task on (n,) points of its range and a little beyond."""

    def __init__(self, task: Task, points: int, tick: Callable[[], None] = lambda: None) -> None:
        self.task = task
        reach = REACH * task.sigma
        self.theta = np.linspace(task.low - reach, task.high + reach, points)
        rows = []
        for theta in self.theta:
            rows.append((task.loss(theta), task.exact(theta)))
            tick()
        self.loss, self.slope = np.array(rows).T
        self.inside = np.flatnonzero((self.theta >= task.low) & (self.theta <= task.high))

    def density(self, theta: float) -> FloatArray:
        """Return the (n,) weights of the noise around theta on the grid."""
        w = (self.theta - theta) / self.task.sigma
        density = np.where(np.abs(w) <= REACH, np.exp(-0.5 * w * w), 0.0)
        return np.asarray(density / density.sum())

    def moments(self, theta: float) -> Moments:
        """Return mean and deviation of one sample of both randomised gradients at theta."""
        density, w = self.density(theta), (self.theta - theta) / self.task.sigma
        here = float(np.interp(theta, self.theta, self.loss))
        zeroth = (self.loss - here) * w / self.task.sigma
        return Moments(*_moments(density, zeroth), *_moments(density, self.slope))

    def some(self, count: int) -> IntArray:
        """Return points of the grid in the range, evenly spread."""
        return np.asarray(self.inside[np.linspace(0, self.inside.size - 1, count).round().astype(int)])


def _moments(density: FloatArray, values: FloatArray) -> tuple[float, float]:
    mean = float(density @ values)
    return mean, float(np.sqrt(density @ (values - mean) ** 2))


class Row(NamedTuple):
    """A line of the table: a method's bias and the spread of one sample, as shares of the slopes' size."""

    method: str
    bias_exact: float
    bias_smoothed: float
    spread: float
    wrong_way: float


def compare(grid: Grid, points: int, smoothings: FloatArray, stiffnesses: FloatArray) -> Iterator[Row]:
    """Yield how far each method's mean slope is from the exact one and from the smoothed loss'.

    Biases are root mean squares over points of mean - reference, over that of the reference; `wrong_way` is
    the share of points at which the mean points uphill of the smoothed loss, or is zero where that is not.
    """
    task, at = grid.task, grid.some(points)
    thetas, exact = grid.theta[at], grid.slope[at]
    moments = [grid.moments(t) for t in thetas]
    smoothed = np.array([m.zeroth for m in moments])
    size = float(np.sqrt(np.mean(smoothed**2)))
    matters = np.abs(smoothed) > MATTERS * size

    def row(method: str, means: FloatArray, spread: float = 0.0) -> Row:
        of_exact, of_smoothed = (
            float(np.sqrt(np.mean((means - r) ** 2) / np.mean(r**2))) for r in (exact, smoothed)
        )
        downhill = means * np.sign(smoothed) > MATTERS**2 * size
        return Row(method, of_exact, of_smoothed, spread / size, float(np.mean(~downhill[matters])))

    for k in stiffnesses:
        yield row(f"penalty, k = {k:g} N/m", np.array([task.penalty_slope(t, k) for t in thetas]))
    yield row("implicit, exact", exact)
    for s in smoothings:
        yield row(f"implicit, smoothed {s:g} W", np.array([task.smooth(t, s) for t in thetas]))
    spreads = np.median([m.first_spread for m in moments]), np.median([m.zeroth_spread for m in moments])
    yield row("randomised, first order", np.array([m.first for m in moments]), float(spreads[0]))
    yield row("randomised, zeroth order", smoothed, float(spreads[1]))
