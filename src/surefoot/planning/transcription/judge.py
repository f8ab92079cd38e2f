"""One definition of solved for every way to soften: the laws, read from the motion and from nothing else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.planning.transcription.problem import Motion, SmallProblem
from surefoot.planning.transcription.program import pairs_at

COMPLEMENTARITY, DEFECT = 1e-6, 1e-8
"""What a solved problem may miss: min(a, b) of every pair, and the dynamics, in SI units."""


@dataclass(frozen=True)
class Outcome:
    """How far a motion is from the laws and from its goal.

    Attributes
    ----------
    complementarity
        max |min(a, b)| over all pairs of all knots: gap [m] and impulse [N s], sliding [m/s] and friction,
        cone [N s] and sliding.
    product
        max |gap · normal impulse| [m N s].
    penetration
        Deepest overlap at the end of a knot [m].
    defect
        Largest error of the dynamics and of q⁺ = q + dt v⁺ [N s, m].
    beyond
        How far a bound of coordinates or motors is broken.
    cost
        Σ effort u² dt.
    reached
        Whether the goal is.
    """

    complementarity: float
    product: float
    penetration: float
    defect: float
    beyond: float
    cost: float
    reached: bool

    @property
    def error(self) -> float:
        """The largest error of laws, dynamics and bounds."""
        return max(self.complementarity, self.defect, self.beyond)

    @property
    def solved(self) -> bool:
        """Whether the laws hold and the goal is reached."""
        lawful = self.complementarity < COMPLEMENTARITY and self.defect < DEFECT and self.beyond < DEFECT
        return lawful and self.reached


def judge(problem: SmallProblem, motion: Motion) -> Outcome:
    """Return how far a motion is from the laws: friction's sliding speed is that of the motion."""
    system, dt = problem.system, problem.dt
    worst = product = depth = defect = 0.0
    for k in range(problem.knots):
        a, b = pairs_at(problem, motion, k)
        p = len(system.touches)
        worst = max(worst, _size(np.minimum(a, b)))
        product = max(product, _size(a[:p] * b[:p]))
        depth = max(depth, -float(a[:p].min()))
        q, v, after = motion.q[k], motion.v[k], motion.v[k + 1]
        force = dt * (system.selection @ motion.u[k] - np.array(system.bias(q, v)).ravel())
        force = force + np.array(system.normal(q)).T @ motion.normal[k]
        force = force + np.array(system.tangent(q)).T @ motion.friction[k]
        moved = motion.q[k + 1] - q - dt * after
        defect = max(defect, _size(np.array(system.mass(q)) @ (after - v) - force), _size(moved))
    beyond = max(
        float(np.max(problem.low - motion.q[1:], initial=0.0)),
        float(np.max(motion.q[1:] - problem.high, initial=0.0)),
        float(np.max(np.abs(motion.u) - problem.limit, initial=0.0)),
    )
    cost = problem.effort * dt * float((motion.u**2).sum())
    return Outcome(worst, product, depth, defect, beyond, cost, problem.reached(motion))


def _size(x: np.ndarray) -> float:
    """Return the largest magnitude, infinite where an entry is not a number."""
    return float(np.abs(x).max(initial=0.0)) if np.isfinite(x).all() else np.inf
