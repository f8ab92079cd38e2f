"""A small problem through contact: a system, where it starts, where it is to end, and what it costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.transcription.forms import import_casadi
from surefoot.planning.transcription.systems import System

CLOSE = 1e-6
"""A goal is reached where it is missed by no more than this [m, m/s, rad, rad/s]."""
Expressions = Callable[[Any, Any], Any]
"""(q, v) to a CasADi column."""


@dataclass(frozen=True)
class Motion:
    """States and inputs of N knots, in the coordinates of a `System`.

    Attributes
    ----------
    q, v
        (N + 1, n).
    u
        (N, m) of the motors [N, N m].
    normal
        (N, p) normal impulses [N s].
    friction
        (N, p) tangential impulses [N s].
    """

    q: FloatArray
    v: FloatArray
    u: FloatArray
    normal: FloatArray
    friction: FloatArray


@dataclass(frozen=True)
class SmallProblem:
    """What is to be found.

    Attributes
    ----------
    name, meaning
        For tables.
    system
        Who moves.
    q, v
        (n,) the start.
    knots, dt
        Their number and length [s].
    goal
        (q, v) at the end to a column that is to be zero; None for a motion without inputs, which the laws
        alone determine.
    done
        Whether a motion does what was asked for; None where that is to meet the goal.
    low, high
        (n,) bounds of the coordinates.
    limit
        (m,) bound of each motor [N, N m].
    effort
        Weight of u² dt in the cost.
    spread
        (n,) standard deviation of a random start about the straight line from q to `towards` [m, rad].
    towards
        (n,) where a random start ends on average.
    """

    name: str
    meaning: str
    system: System
    q: FloatArray
    v: FloatArray
    knots: int
    dt: float
    towards: FloatArray
    spread: FloatArray
    done: Callable[[Motion], bool] | None = None
    goal: Expressions | None = None
    low: FloatArray = field(default_factory=lambda: np.array(-np.inf))
    high: FloatArray = field(default_factory=lambda: np.array(np.inf))
    limit: FloatArray = field(default_factory=lambda: np.zeros(0))
    effort: float = 1.0

    def reached(self, motion: Motion) -> bool:
        """Return whether a motion does what was asked for; asked of every method's answer alike."""
        if self.done is not None:
            return self.done(motion)
        assert self.goal is not None
        casadi = import_casadi()
        missed = np.array(self.goal(casadi.DM(motion.q[-1]), casadi.DM(motion.v[-1])))
        return bool(np.abs(missed).max() < CLOSE)

    def guess(self, seed: int) -> Motion:
        """Return a random start: a noisy line, velocities of 1 m/s, and impulses of the size of the weight's.

        The same for every method. Impulses are uniform between 0 and twice what gravity gives in a knot, also
        where the line is in the air.
        """
        random = np.random.default_rng(seed)
        system, N = self.system, self.knots
        share = np.linspace(0.0, 1.0, N + 1)[:, None]
        q = self.q + share * (self.towards - self.q) + self.spread * random.normal(size=(N + 1, system.size))
        v = random.normal(size=(N + 1, system.size))
        q[0], v[0] = self.q, self.v
        bound = np.where(np.isfinite(self.limit), self.limit, 10.0)
        u = 0.3 * bound * random.uniform(-1.0, 1.0, size=(N, bound.size))
        weight = self.dt * float(np.abs(np.array(system.bias(self.q, 0.0 * self.v))).max())
        p = len(system.touches)
        normal = 2.0 * weight * random.uniform(size=(N, p))
        return Motion(q, v, u, normal, 0.5 * system.mu * normal * random.uniform(-1.0, 1.0, size=(N, p)))
