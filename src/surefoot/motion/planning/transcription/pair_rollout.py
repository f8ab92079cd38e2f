"""Exact steps of a planar problem whose bodies touch each other, beside feet on the ground.

The step is that of `dynamics.Knot`, which knows feet on the ground only: rigid contact, exact
Coulomb friction in the plane, every contact problem solved by `surefoot.solve` and certified.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.libraries import import_casadi
from surefoot.contact import ContactProblem, Planar, Status, solve
from surefoot.mechanics import Robot, StepOptions, Stepper, Terrain
from surefoot.motion.planning.trajectory import TOLERANCE, TorquePolicy, Trajectory
from surefoot.motion.planning.transcription.contact_pairs import PlanarContactPair

PLANAR = np.array([0, 2])
"""Tangent and normal among a contact's axes."""


class PairProblem(Protocol):
    """A start, a ground and pairs of bodies that may touch: see `DirectProblem`, which is one."""

    @property
    def robot(self) -> Robot:
        """The planar robot."""

    @property
    def terrain(self) -> Terrain:
        """The ground."""

    @property
    def q(self) -> FloatArray:
        """(nq,) the configuration at the start."""

    @property
    def v(self) -> FloatArray:
        """(nv,) the velocity at the start."""

    @property
    def knots(self) -> int:
        """How many steps there are."""

    @property
    def dt(self) -> float:
        """Length of a step [s]."""

    @property
    def mu(self) -> float:
        """Friction coefficient of the ground [-]."""

    @property
    def touches(self) -> tuple[PlanarContactPair, ...]:
        """Contacts between bodies of the robot, beside those of its feet with the ground."""

    @property
    def torque_limits(self) -> FloatArray | None:
        """(joints,) largest torques [N m]."""


class PairStep:
    """Takes exact steps of a problem whose bodies touch each other."""

    def __init__(self, problem: PairProblem) -> None:
        ca, robot = import_casadi(), problem.robot
        self.problem, self._data = problem, robot.model.createData()
        self.stepper = Stepper(
            robot, problem.terrain, StepOptions(dt=problem.dt, order=1, solver_tol=TOLERANCE)
        )
        q = ca.SX.sym("q", robot.model.nq)
        self._touches = [ca.Function("touch", [q], [*touch.at(q)]) for touch in problem.touches]
        frictions = [problem.mu] * len(robot.contact_points) + [touch.mu for touch in problem.touches]
        self._laws = [Planar(mu) for mu in frictions]

    def contacts(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return gaps (p,) and Jacobians (p, 2, nv), tangent and normal: of feet, then of touches."""
        seen = self.stepper.contacts(self.stepper.start(q))
        found = [touch(q) for touch in self._touches]
        J = np.asarray(seen.J).reshape(len(seen.gaps), 3, -1)[:, PLANAR]
        gaps = np.concatenate([seen.gaps, [float(gap) for gap, _ in found]])
        return gaps, np.concatenate([J, np.array([np.array(rows) for _, rows in found])])

    def take(
        self, q: FloatArray, v: FloatArray, torques: FloatArray
    ) -> tuple[FloatArray, FloatArray, float, bool]:
        """Return v⁺, impulses (p, 2) along tangent and normal, velocity error, whether it is small."""
        import pinocchio

        model, dt = self.problem.robot.model, self.problem.dt
        M = np.array(pinocchio.crba(model, self._data, q))
        M = np.triu(M) + np.triu(M, 1).T
        bias = np.array(pinocchio.nonLinearEffects(model, self._data, q, v))
        free = v + dt * np.linalg.solve(M, torques - bias)
        gaps, J = self.contacts(q)
        rows = J.reshape(-1, len(v))
        Y, g = np.linalg.solve(M, rows.T), rows @ free
        g[1::2] += gaps / dt
        G = rows @ Y
        answer = solve(ContactProblem(0.5 * (G + G.T), g, contacts=self._laws), tol=TOLERANCE)
        impulses = np.ravel(answer.forces)
        error, solved = answer.residuals.velocity_error, answer.status is Status.SOLVED
        return free + Y @ impulses, impulses.reshape(-1, 2), error, solved


def rollout_with_pairs(problem: PairProblem, policy: TorquePolicy) -> Trajectory:
    """Return where a policy leads from a problem's start, by exact steps in which bodies touch each other."""
    step, dt = PairStep(problem), problem.dt
    out = Trajectory.blank(problem.robot, problem.knots, dt, problem.mu)
    touched = np.zeros((problem.knots, len(problem.touches), 3))
    out.q[0], out.v[0], feet = problem.q, problem.v, len(problem.robot.contact_points)
    for k in range(problem.knots):
        out.torques[k] = policy(k, out.q[k], out.v[k])
        out.v[k + 1], impulses, out.residuals[k], out.solved[k] = step.take(
            out.q[k], out.v[k], out.torques[k]
        )
        out.q[k + 1] = out.q[k] + dt * out.v[k + 1]
        out.impulses[k][:, PLANAR], touched[k][:, PLANAR] = impulses[:feet], impulses[feet:]
    out.ways[:] = out.v
    out.locate(step.stepper)
    return replace(out, touch_impulses=touched)
