"""What an exact motion is worth to a problem: how far from its goal and from the optimiser's, its cost."""

from __future__ import annotations

import numpy as np

from surefoot.planning.direct.follow import Followed, Motion
from surefoot.planning.direct.problem import DirectProblem
from surefoot.planning.trajectory import Trajectory

REACH = 1e-3
"""How far the exact motion may be outside a window that it was to reach [m, rad; ten times as many m/s]."""


def window_miss(problem: DirectProblem, trajectory: Trajectory) -> float:
    """Return how far a trajectory is outside the windows of a problem: [m, rad], or in tenths of m/s."""
    nq, nv = trajectory.q.shape[1], trajectory.v.shape[1]
    worst = 0.0
    scale = np.concatenate([np.ones(nq), np.full(nv, 0.1)])
    for k, window in [*problem.windows.items(), (problem.knots, problem.end)]:
        state = np.concatenate([trajectory.q[k], trajectory.v[k]])
        sides = [(window.q_low, window.v_low, 1.0), (window.q_high, window.v_high, -1.0)]
        for q, v, sign in sides:
            free = -sign * np.inf
            edge = np.concatenate(
                [np.full(nq, free) if q is None else q, np.full(nv, free) if v is None else v]
            )
            beyond = scale * sign * (edge - state)
            if not np.isfinite(state).all():
                return np.inf
            worst = max(worst, float(beyond.max()))
    return worst


def departure(problem: Followed, motion: Motion, trajectory: Trajectory) -> float:
    """Return the largest entry of q ⊖ q between a motion and a trajectory [m, rad], infinite if lost."""
    import pinocchio

    if not np.isfinite(trajectory.q).all():
        return np.inf
    model = problem.robot.model
    pairs = zip(motion.q, trajectory.q, strict=True)
    return max(float(np.abs(pinocchio.difference(model, a, b)).max()) for a, b in pairs)


def exact_cost(problem: DirectProblem, trajectory: Trajectory) -> float:
    """Return the cost of a trajectory under a problem's weights."""
    w, dt, t = problem.weights, problem.dt, trajectory
    off, change = t.q[1:] - problem.references[1:], np.diff(t.v, axis=0)
    running = w.torque * np.sum(t.torques**2) + w.velocity * np.sum(t.v[1:] ** 2) + w.posture * np.sum(off**2)
    end = np.sum(off[-1] ** 2) + np.sum(t.v[-1] ** 2)
    return float(dt * running + w.change / dt * np.sum(change**2) + w.end * end)
