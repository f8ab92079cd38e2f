"""The exact step of a small system: motors in, motion out, every contact problem solved and certified.

The same step as `surefoot.stepping.Knot` for what that cannot say: a foot that touches a block. Rigid contact
and exact Coulomb friction, nothing soft is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, finite_array
from surefoot.contact import ContactProblem, Status
from surefoot.contact.sets import Planar
from surefoot.planning.transcription.problem import Motion, SmallProblem
from surefoot.solvers.solver import solve
from surefoot.stepping.arithmetic import with_missed

REACH = 1e-3
"""Contacts that free motion brings closer than this are in the problem [m]."""


@dataclass(frozen=True)
class Replay:
    """A motion of exact steps.

    Attributes
    ----------
    motion
        States, inputs and impulses.
    residuals
        (N,) velocity error of each knot's contact problem, see `surefoot.contact.Residuals`.
    solved
        (N,) whether it is solved to the tolerance.
    """

    motion: Motion
    residuals: FloatArray
    solved: BoolArray

    @property
    def law_residual(self) -> float:
        """Largest velocity error, infinite where a problem was not solved."""
        return float(self.residuals.max(initial=0.0)) if self.solved.all() else np.inf


def replay(problem: SmallProblem, u: FloatArray, tol: float = 1e-8) -> Replay:
    """Return where the motors' forces u (N, m) [N, N m] lead from the problem's start.

    Raises
    ------
    ProblemError
        For inputs of another shape, or not finite.
    """
    system = problem.system
    given = finite_array("u", u, (None, len(system.actuated)))
    N, n, p = len(given), system.size, len(system.touches)
    q, v = np.empty((N + 1, n)), np.empty((N + 1, n))
    impulses, residuals, solved = np.zeros((N, p, 2)), np.zeros(N), np.ones(N, dtype=bool)
    q[0], v[0] = problem.q, problem.v
    for k in range(N):
        v[k + 1], impulses[k], residuals[k], solved[k] = exact_step(problem, q[k], v[k], given[k], tol)
        q[k + 1] = q[k] + problem.dt * v[k + 1]
    return Replay(Motion(q, v, given, impulses[:, :, 1], impulses[:, :, 0]), residuals, solved)


def exact_step(
    problem: SmallProblem, q: FloatArray, v: FloatArray, u: FloatArray, tol: float
) -> tuple[FloatArray, FloatArray, float, bool]:
    """Return v⁺, the impulses (p, 2) along tangent and normal, the velocity error and whether it is small."""
    system, dt = problem.system, problem.dt
    M = np.array(system.mass(q))
    free = v + dt * np.linalg.solve(M, system.selection @ u - np.array(system.bias(q, v)).ravel())
    gaps = np.array(system.gap(q)).ravel()
    J = np.stack([np.array(system.tangent(q)), np.array(system.normal(q))], axis=1)
    out = np.zeros((gaps.size, 2))
    near = np.flatnonzero(gaps + dt * J[:, 1] @ free < REACH)
    after, error, solved = free, 0.0, True
    while near.size:
        rows = J[near].reshape(-1, system.size)
        Y = np.linalg.solve(M, rows.T)
        g = rows @ free
        g[1::2] += gaps[near] / dt
        G = rows @ Y
        laws = [Planar(float(system.mu[c])) for c in near]
        answer = solve(ContactProblem(0.5 * (G + G.T), g, contacts=laws), tol=tol)
        error, solved = answer.residuals.velocity_error, answer.status is Status.SOLVED
        out[:] = 0.0
        out[near] = np.asarray(answer.forces).reshape(-1, 2)
        after = free + Y @ out[near].ravel()
        speeds = np.zeros((gaps.size, 3))
        speeds[:, 2] = J[:, 1] @ after
        more = with_missed(speeds, gaps, dt, near)
        if more.size == near.size:
            break
        near = more
    return after, out, error, solved
