"""Small systems with contacts, stepped exactly or with springs in place of contacts.

A step solves M (v⁺ - v) = h f + Jᵀ λ with the exact contact problem of λ and J v⁺ + gap / h (Stewart and
Trinkle), then q⁺ = q + h v⁺. The same system with springs (penalty) takes many small explicit steps.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import surefoot as sf
from surefoot.base.arrays import FloatArray

SOFT_SPEED, SLIP = 0.5, 0.01
"""Speed at which an opening spring's force vanishes, and that at which friction is regularised [m/s]."""


class Scene(NamedTuple):
    """The contacts at a configuration.

    Attributes
    ----------
    gaps, mu
        (k,) [m] and friction.
    J
        (3k, n) Jacobian, normal last.
    slopes
        (k, n) of the gaps by q.
    """

    gaps: FloatArray
    J: FloatArray
    mu: FloatArray
    slopes: FloatArray


@dataclass(frozen=True)
class System(ABC):
    """What is simulated, and the range of its parameter theta.

    Attributes
    ----------
    name
        What it is called.
    masses
        (n,) along q [kg].
    dt, steps
        Length of a step [s], and how many there are.
    low, high
        Least and greatest theta.
    """

    name: str
    masses: FloatArray
    dt: float
    steps: int
    low: float
    high: float

    @abstractmethod
    def start(self, theta: float) -> tuple[FloatArray, FloatArray]:
        """Return q and v (n,) at the start."""

    @abstractmethod
    def force(self, q: FloatArray, v: FloatArray, time: float, theta: float) -> FloatArray:
        """Return the applied forces (n,), linear in q, v and theta [N]."""

    @abstractmethod
    def scene(self, q: FloatArray, theta: float) -> Scene:
        """Return the contacts at q."""

    @abstractmethod
    def loss(self, q: FloatArray, v: FloatArray) -> float:
        """Return what is to be small at the end."""


@dataclass(frozen=True)
class Path:
    """A rollout: (steps + 1, n) configurations, the loss, and its derivative (NaN if not asked for)."""

    q: FloatArray
    loss: float
    slope: float


def _numeric(call: Callable[[float], FloatArray], step: float = 1e-6) -> FloatArray:
    """Return the central difference of call(e) at 0: exact up to rounding for what is linear or quadratic."""
    return np.asarray((call(step) - call(-step)) / (2.0 * step))


def _force_rate(
    system: System, at: tuple[FloatArray, FloatArray, float, float], rates: tuple[FloatArray, FloatArray]
) -> FloatArray:
    (q, v, time, theta), (dq, dv) = at, rates
    return _numeric(lambda e: system.force(q + e * dq, v + e * dv, time, theta + e))


def _friction_rate(system: System, q: FloatArray, theta: float) -> FloatArray:
    return _numeric(lambda e: system.scene(q, theta + e).mu)


def rollout(system: System, theta: float, derivative: bool = False, smoothing: float = 0.0) -> Path:
    """Simulate with exact contacts; the derivative by theta is implicit, exact or smoothed.

    Parameters
    ----------
    system, theta
        What, and its parameter.
    derivative
        Whether to carry the derivative along.
    smoothing
        Of the derivative [W], see `ContactSolution.derivative`; the motion is always the exact one.
    """
    h, m = system.dt, system.masses
    q, v = system.start(theta)
    dq = _numeric(lambda e: system.start(theta + e)[0])
    dv = _numeric(lambda e: system.start(theta + e)[1])
    path = [q]
    for k in range(system.steps):
        time = k * h
        free = v + h * system.force(q, v, time, theta) / m
        here = system.scene(q, theta)
        G, g = here.J @ (here.J / m).T, here.J @ free
        g[2::3] += here.gaps / h
        solution = sf.solve(sf.ContactProblem(G, g, mu=here.mu), tol=1e-10)
        if derivative:
            rate = _force_rate(system, (q, v, time, theta), (dq, dv))
            dfree = dv + h * rate / m
            dg = here.J @ dfree
            dg[2::3] += here.slopes @ dq / h
            dmu = _friction_rate(system, q, theta)
            found = solution.derivative(smoothing=smoothing).jvp(g=dg, mu=dmu)
            dv = dfree + here.J.T @ found.forces.ravel() / m
        v = free + here.J.T @ solution.forces.ravel() / m
        q, dq = q + h * v, dq + h * dv
        path.append(q)
    slope = float("nan")
    if derivative:
        slope = float(_numeric(lambda e: np.array(system.loss(q + e * dq, v + e * dv))))
    return Path(np.array(path), system.loss(q, v), slope)


def penalty(system: System, theta: float, stiffness: float, refine: int = 20) -> float:
    """Return the loss with springs in place of contacts: f_n = max(0, -k gap (1 - v_n / v_0)).

    Friction is mu f_n tanh(v_t / v_s); semi-implicit Euler, `refine` steps in one, more for stiff springs.
    """
    m = system.masses
    parts = max(refine, int(np.ceil(system.dt * np.sqrt(stiffness / m.min()) * 4.0)))
    h = system.dt / parts
    q, v = system.start(theta)
    for k in range(system.steps * parts):
        f = system.force(q, v, k * h, theta)
        here = system.scene(q, theta)
        u = (here.J @ v).reshape(-1, 3)
        normal = np.maximum(0.0, -stiffness * here.gaps * (1.0 - u[:, 2] / SOFT_SPEED)) * (here.gaps < 0.0)
        speed = np.linalg.norm(u[:, :2], axis=1)
        share = here.mu * normal * np.tanh(speed / SLIP) / np.maximum(speed, 1e-12)
        f = f + here.J.T @ np.column_stack([-share[:, None] * u[:, :2], normal]).ravel()
        v = v + h * f / m
        q = q + h * v
    return system.loss(q, v)
