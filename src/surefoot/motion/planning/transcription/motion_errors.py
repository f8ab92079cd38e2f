"""One judge for all methods: how far a motion is from windows, laws and another motion; its cost."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.planning.trajectory import Trajectory
from surefoot.motion.planning.transcription.initial_guess import Guess

if TYPE_CHECKING:
    from surefoot.mechanics import Robot
    from surefoot.motion.planning.transcription.direct_problem import DirectProblem

Motion: TypeAlias = Trajectory | Guess
"""States q and v of knots, and their torques."""
REACH = 1e-3
"""How far the exact motion may be outside a window that it was to reach [m, rad; ten times as many m/s]."""


def window_miss(problem: DirectProblem, motion: Motion) -> float:
    """Return how far a motion is outside the windows of a problem: [m, rad], or in tenths of m/s."""
    nq, nv = motion.q.shape[1], motion.v.shape[1]
    worst = 0.0
    scale = np.concatenate([np.ones(nq), np.full(nv, 0.1)])
    for k, window in [*problem.windows.items(), (problem.knots, problem.end)]:
        state, high = np.concatenate([motion.q[k], motion.v[k]]), np.full(nq + nv, np.inf)
        low = -high
        window.narrow(low, high, nq, k)
        if not np.isfinite(state).all():
            return np.inf
        worst = max(worst, float((scale * np.maximum(low - state, state - high)).max()))
    return worst


def departure(robot: Robot, motion: Motion, trajectory: Trajectory) -> float:
    """Return the largest entry of q ⊖ q between a motion and a trajectory [m, rad], infinite if lost."""
    import pinocchio

    if not np.isfinite(trajectory.q).all():
        return np.inf
    pairs = zip(motion.q, trajectory.q, strict=True)
    return max(float(np.abs(pinocchio.difference(robot.model, a, b)).max()) for a, b in pairs)


def complementarity(impulses: FloatArray, gaps: FloatArray, sliding: FloatArray, mu: FloatArray) -> float:
    """Return max |min(a, b)| over the pairs of the laws, in SI units; infinite where one is not a number.

    Gap and normal impulse, sliding speed and what is left of the cone, and friction against the sliding.

    Parameters
    ----------
    impulses
        (N, p, 3) in contact axes [N s].
    gaps
        (N, p) at the ends of the knots as their velocities predict them [m].
    sliding
        (N, p, 1) tangential velocities [m/s].
    mu
        (p,) friction.
    """
    normal, friction, slide = impulses[..., 2], impulses[..., 0], sliding[..., 0]
    speed, spare = np.abs(slide), mu * normal - np.abs(friction)
    against = np.maximum(friction * np.sign(slide), 0.0)
    pairs = (np.minimum(gaps, normal), np.minimum(speed, spare), np.minimum(speed, against))
    if not all(np.isfinite(pair).all() for pair in pairs):
        return np.inf
    return float(max(np.abs(pair).max(initial=0.0) for pair in pairs))


def exact_cost(problem: DirectProblem, trajectory: Trajectory) -> float:
    """Return the cost of a trajectory under a problem's weights."""
    w, dt, t = problem.weights, problem.dt, trajectory
    off, change = t.q[1:] - problem.references[1:], np.diff(t.ways, axis=0)
    running = w.torque * np.sum(t.torques**2) + w.velocity * np.sum(t.ways[1:] ** 2)
    running += w.posture * np.sum(off**2)
    end = np.sum(off[-1] ** 2) + np.sum(t.ways[-1] ** 2)
    return float(dt * running + w.change / dt * np.sum(change**2) + w.end * end)
