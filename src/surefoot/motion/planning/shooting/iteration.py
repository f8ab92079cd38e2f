"""One iteration of the shooting solver: derivatives, Riccati recursion, line search on the exact cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.planning.shooting.cost_terms import cost_slopes
from surefoot.motion.planning.shooting.horizon import FeedbackPolicy, Horizon
from surefoot.motion.planning.shooting.riccati import backward_pass
from surefoot.motion.planning.shooting.shooting_problem import ShootingProblem

ARMIJO = 1e-4
"""Share of the predicted decrease that a step has to bring."""


class ShootingIteration:
    """Keeps a motion and improves it, step by step.

    Parameters
    ----------
    problem
        What to minimise, over which horizon.
    tol
        Of the contact problems of the forward steps.

    Attributes
    ----------
    now
        The current motion.
    tables
        Its costs, which may be written to between iterations.
    gains, steps
        K (N, m, 2nv) and k (N, m) of the last backward pass.
    damping
        Weight of ½ ||du||², relative to the torques' mean weight.
    bounds
        (N, 2, m) on the torques of the last rollout [N m].
    spare
        Knots that the next rollout may write to.
    """

    def __init__(self, problem: ShootingProblem, tol: float = 1e-8) -> None:
        p, N = problem, problem.knots
        self.problem, self.tables = problem, problem.costs.tables(problem.robot, N)
        self.now, self._next, self.spare = (self.horizon(tol) for _ in range(3))
        m, twice = p.robot.joints, 2 * int(p.robot.model.nv)
        self.gains, self.steps = np.zeros((N, m, twice)), np.zeros((N, m))
        self._slopes, self._predicted = np.zeros((N + 1, twice)), np.zeros(2)
        limits = np.asarray(p.limits)
        self.bounds = np.tile(np.array([-limits, limits]), (N, 1, 1))
        self.damping = 0.0
        self._scale = float(np.trace(self.tables.torque[0])) / max(m, 1)

    def horizon(self, tol: float) -> Horizon:
        """Return knots for the problem."""
        p = self.problem
        return Horizon(p.robot, p.knots, p.dt, p.mu, p.terrain, tol, p.momentum)

    def take(self, q: FloatArray, v: FloatArray, torques: FloatArray) -> bool:
        """Start from (N + 1, nq), (N + 1, nv) states and (N, joints) torques [N m] as they are, gaps and all.

        Returns whether every step is solved.
        """
        # Clipped, so that a step of zero lies within the boxes of `backward`.
        torques = np.clip(torques, self.bounds[:, 0], self.bounds[:, 1])
        done = self.now.take(q, v, torques)
        if done:
            self.now.price(self.tables)
        return done

    def differentiate(self, smoothing: float) -> bool:
        """Differentiate the current motion and its cost; return whether the central paths were reached."""
        now = self.now
        done = now.differentiate(smoothing)
        self._cost = cost_slopes(now.floating, now.motion, now.feet, self.tables)
        return done

    def backward(self) -> bool:
        """Run the Riccati recursion; return whether every box program was solved."""
        now = self.now
        # The bounds are on u + k: on the step k they are the same less u.
        low = np.minimum(self.bounds[:, 0] - now.torques, 0.0)  # rounding
        high = np.maximum(self.bounds[:, 1] - now.torques, 0.0)
        damping, found = self.damping * self._scale, (self.gains, self.steps, self._slopes, self._predicted)
        return bool(backward_pass((now.A, now.B, now.gaps), self._cost, (low, high), damping, *found))

    def search(self, shares: Sequence[float]) -> float:
        """Try shares of the step on the exact cost; return the one that was taken, 0 for none."""
        now, policy, taken = self.now, self.policy, 0.0
        for share in shares:
            first = (now.q[0], now.v[0])
            if not self._next.run(first, policy, share, self.bounds):
                continue
            cost = self._next.price(self.tables)
            # Armijo's rule by what the quadratic model promises, -a Q_uᵀ k - ½ a² kᵀ Q_uu k. With open gaps
            # it may promise a rise: then what costs no more is taken.
            gain = -share * (self._predicted[0] + 0.5 * share * self._predicted[1])
            if cost <= now.cost - ARMIJO * max(gain, 0.0):
                self.now, self._next = self._next, now
                taken = share
                break
        return taken

    def choose(self, candidates: Sequence[tuple[FeedbackPolicy, float]], enough: float) -> int:
        """Roll policies out without gaps and keep the cheapest motion; return its number, -1 for none.

        Unlike `search` this may raise the cost, since the motion begins anew where the gaps are: what a
        controller needs whose robot is not where the last plan was.

        Parameters
        ----------
        candidates
            Policies, each with the share of its step.
        enough
            The first motion that costs no more ends the search.
        """
        first = (self.now.q[0].copy(), self.now.v[0].copy())
        best, least = -1, np.inf
        for number, (policy, share) in enumerate(candidates):
            if not self._next.run(first, policy, share, self.bounds):
                continue
            cost = self._next.price(self.tables)
            if cost < least:
                best, least = number, cost
                # The cheapest so far is kept in `spare`: the next rollout writes over `_next`.
                self._next, self.spare = self.spare, self._next
            if least <= enough:
                break
        if best >= 0:
            self.now, self.spare = self.spare, self.now
        return best

    @property
    def policy(self) -> FeedbackPolicy:
        """The current motion with the gains and steps of the last backward pass."""
        now = self.now
        return FeedbackPolicy(now.q, now.v, now.torques, self.gains, self.steps)
