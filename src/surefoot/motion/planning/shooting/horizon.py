"""The knots of a horizon: exact steps forward, smoothed derivatives of the same steps backward.

Steps are values with all that their derivatives need, so that a motion that a line search accepts is
differentiated without stepping again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError, NoSolution
from surefoot.mechanics import Knot, KnotStep, MomentumKnot, Robot, StepOptions, Stepper, Terrain
from surefoot.motion.planning.shooting.cost_terms import Feet, Motion, Tables, motion_cost
from surefoot.motion.planning.shooting.state_space import difference, feedback


class FeedbackPolicy(NamedTuple):
    """Torques u + a k + K (x ⊖ x̄) about a motion, for a share a.

    Attributes
    ----------
    q, v, torques
        (N + 1, nq), (N + 1, nv) and (N, m) x̄ and u.
    gains, steps
        (N, m, 2nv) K and (N, m) k.
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    gains: FloatArray
    steps: FloatArray


class Horizon:
    """N knots in a row and the motion through them.

    Parameters
    ----------
    robot
        With a free flyer or a fixed base, and joints of one degree of freedom.
    knots
        N.
    dt, mu, terrain, tol
        Length of a knot [s], friction, the ground, and the tolerance of the contact problems.
    momentum
        Whether the knots keep momentum; else plain first-order steps.

    Attributes
    ----------
    q, v
        (N + 1, nq), (N + 1, nv) where the knots start.
    torques
        (N, m) [N m].
    gaps
        (N, 2nv) where each step ends less where the next knot starts, as tangents at the latter; the last
        knot's end is the last state.
    J, rates, heights
        Contact Jacobians (N, 3p, nv) in contact axes, the derivatives of J v by q, and distances to the
        ground (N, p) at the knots' starts.
    cost
        Of the motion; infinite where a step failed.
    A, B
        Derivatives (N, 2nv, 2nv) and (N, 2nv, m) of the steps.

    Raises
    ------
    ModelError
        For a robot with other joints, or too few.
    """

    def __init__(
        self, robot: Robot, knots: int, dt: float, mu: float, terrain: Terrain | None, tol: float = 1e-8,
        momentum: bool = True,
    ) -> None:  # fmt: skip
        model, p = robot.model, len(robot.contact_points)
        nq, nv, m = int(model.nq), int(model.nv), robot.joints
        # Differences of states (`state_space`) know a free flyer and plain numbers, no other quaternions or
        # angles given as cosine and sine.
        if nq != nv + (1 if robot.floating else 0):
            raise ModelError(f"{robot.name} has joints with more coordinates than degrees of freedom")
        if nv < 2 or m < 1:
            raise ModelError(
                f"shooting is for robots with joints and at least two velocities, not {robot.name}"
            )
        self.floating, self.dt, self.mu = robot.floating, dt, mu
        options = StepOptions(dt=dt, order=1, solver_tol=tol)
        kind = MomentumKnot if momentum else Knot
        self._knot = kind(Stepper(robot, terrain, options))
        self._steps: list[KnotStep] = []
        self.q, self.v = np.tile(robot.nominal, (knots + 1, 1)), np.zeros((knots + 1, nv))
        self.torques, self.gaps = np.zeros((knots, m)), np.zeros((knots, 2 * nv))
        self.J, self.rates = np.zeros((knots, 3 * p, nv)), np.zeros((knots, 3 * p, nv))
        self.heights, self.impulses = np.zeros((knots, p)), np.zeros((knots, p, 3))
        self.A, self.B = np.zeros((knots, 2 * nv, 2 * nv)), np.zeros((knots, 2 * nv, m))
        self.cost = np.inf

    def __len__(self) -> int:
        return len(self.torques)

    def run(
        self, start: tuple[FloatArray, FloatArray], policy: FeedbackPolicy, share: float, limits: FloatArray
    ) -> bool:
        """Step from a state under a policy, without gaps; return whether every contact problem is solved.

        The torques are u + share k + K (x ⊖ x̄).

        Parameters
        ----------
        start
            (nq,) and (nv,).
        policy
            What to follow.
        share
            0 to 1.
        limits
            (N, 2, m) bounds on the torques [N m].
        """
        self.q[0], self.v[0] = start
        # A rollout has no gaps: each knot starts where the one before ended.
        self.gaps[:] = 0.0
        self._steps = []
        for k in range(len(self)):
            here = self.q[k], self.v[k]
            self.torques[k] = feedback(
                self.floating, here, (policy.q[k], policy.v[k]), policy.torques[k], policy.steps[k], share,
                policy.gains[k], limits[k],
            )  # fmt: skip
            if not (np.isfinite(self.torques[k]).all() and self._advance(k)):
                self.cost = np.inf
                return False
            self.q[k + 1], self.v[k + 1] = self._steps[k].q, self._steps[k].v
        return True

    def take(self, q: FloatArray, v: FloatArray, torques: FloatArray) -> bool:
        """Take states (N + 1, nq), (N + 1, nv) and torques (N, m) as they are, gaps and all."""
        self.q[:], self.v[:], self.torques[:] = q, v, torques
        self._steps = []
        for k in range(len(self)):
            if not self._advance(k):
                self.cost = np.inf
                return False
            self._open(k, self._steps[k].q, self._steps[k].v)
        return True

    def _open(self, k: int, q: FloatArray, v: FloatArray) -> None:
        """Note the gap between (nq,) and (nv,) where a knot ends and where the next one starts."""
        n = v.size
        difference(self.floating, self.q[k + 1], q, self.gaps[k, :n])
        self.gaps[k, n:] = v - self.v[k + 1]

    def _advance(self, k: int) -> bool:
        """Step from a knot's state under its torques; return whether the contact problem is solved."""
        step = self._knot.step(self.q[k], self.v[k], self.torques[k], self.mu)
        self._steps.append(step)
        # what the costs and the result need
        self.J[k], self.heights[k], self.impulses[k] = step.contacts.J, step.gaps, step.impulses
        return step.solved

    @property
    def motion(self) -> Motion:
        """(N + 1, nq) q, (N + 1, nv) v and (N, joints) torques [N m]."""
        return self.q, self.v, self.torques

    @property
    def feet(self) -> Feet:
        """(N, 3p, nv) J, its rates, and (N, p) heights [m] of the contact points."""
        return self.J, self.rates, self.heights

    def price(self, tables: Tables) -> float:
        """Return the cost of the motion, kept as `cost`."""
        self.cost = motion_cost(self.floating, self.motion, self.feet, tables)
        return self.cost

    def differentiate(self, smoothing: float) -> bool:
        """Fill A, B and `rates`; return whether all steps were solved and reached the central path."""
        for k, step in enumerate(self._steps):
            try:
                self._knot.derivative(step, smoothing, (self.A[k], self.B[k]))
            except NoSolution:
                return False
            self.rates[k] = self._knot.contact_rates(step)
        return len(self._steps) == len(self)
