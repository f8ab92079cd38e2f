"""A knot whose contacts nobody gives, and Ipopt on it.

The step is that of `transcription.knot`; the laws of contact are for φ = gap / dt + n·u and u_t, with
u = J(q) v⁺: see `contact_rows`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.libraries import import_casadi
from surefoot.motion.planning.transcription.contact_rows import ContactLaw
from surefoot.motion.planning.transcription.direct_problem import DirectProblem
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.nlp import Block, Iterate, Nlp, Sides, pack, unpack
from surefoot.motion.planning.transcription.symbolic_knot import SymbolicKnot, stack_rows


class DirectNlp:
    """A problem under one way to write the contact laws, ready to be solved again and again.

    Parameters
    ----------
    problem
        See `DirectProblem`.
    law
        See `contact_rows`.

    Attributes
    ----------
    block
        Of `Nlp`; its parameter is eps [J], its data the reference posture of the knot.
    contacts
        Variables and bounds of the contacts, the last ones of the block's u; torques come before.
    rows
        Bounds (knots, m) of the block's rows; those of the laws are the last.
    """

    def __init__(self, problem: DirectProblem, law: ContactLaw) -> None:
        ca, dt, w = import_casadi(), problem.dt, problem.weights
        self.problem, self.law = problem, law
        knot = SymbolicKnot(problem.robot, problem.terrain, dt)
        body, v_after = knot.body, knot.v_after
        torques, eps = ca.SX.sym("torques", problem.robot.joints), ca.SX.sym("eps")
        reference = ca.SX.sym("reference", body.nq + 1)
        touches = [touch.at(knot.q) for touch in problem.touches]
        closing, sliding = _contact_speeds(problem, knot, touches)
        self.contacts = contacts = law.write(closing, sliding, problem.frictions, eps)
        forces = knot.world(contacts.impulses[:, : body.points]) / dt
        # Impulses: forces between bodies are generalised by their own Jacobian, those of the ground by the
        # knot.
        moved = dt * knot.missing_effort(forces, torques)
        for k, (_, J) in enumerate(touches):
            moved -= ca.mtimes(J.T, contacts.impulses[[0, 2], body.points + k])
        equal = ca.vertcat(moved, knot.missed_way())
        rows, self.rows = stack_rows([(equal, 0.0, 0.0), *contacts.rows], problem.knots)
        off, moving = knot.q_after - reference[: body.nq], ca.sumsqr(v_after)
        cost = dt * (w.torque * ca.sumsqr(torques) + w.velocity * moving + w.posture * ca.sumsqr(off))
        cost += w.change / dt * ca.sumsqr(v_after - knot.v)
        cost += reference[body.nq] * w.end * (ca.sumsqr(off) + moving)  # 1 in the last knot
        u = ca.vertcat(torques, contacts.variables)
        self.block = Block(knot.x, u, knot.after, eps, rows, cost + contacts.cost, reference)
        self._impulses = ca.Function("impulses", [contacts.variables], [contacts.impulses])
        self._seen = ca.Function("seen", [knot.q, v_after], [closing, sliding])
        self._law_rows = int(rows.shape[0] - equal.shape[0])
        self._nlp = Nlp(self.block, problem.knots)

    def bounds(self, contact_bounds: Sides | None = None) -> Sides:
        """Return the bounds of all variables; those of the contacts (N, m) where they differ by knot."""
        n, limits = self.problem.knots, self.problem.torque_limits
        assert limits is not None
        states = self.problem.state_bounds()
        contacts = (self.contacts.low, self.contacts.high) if contact_bounds is None else contact_bounds
        out = []
        for sign, state, contact in zip((-1.0, 1.0), states, contacts, strict=True):
            own = np.broadcast_to(contact, (n, np.shape(contact)[-1]))
            out.append(pack(state, np.hstack([np.tile(sign * limits, (n, 1)), own])))
        return out[0], out[1]

    def pack(self, guess: Guess) -> FloatArray:
        """Return the NLP's variables (n,) that mean a motion."""
        contacts = self.law.start(guess.impulses, *self.contact_speeds(guess), self.problem.frictions)
        return pack(np.hstack([guess.q, guess.v]), np.hstack([guess.torques, contacts]))

    def unpack(self, variables: FloatArray) -> Guess:
        """Return the motion that the NLP's variables (n,) mean."""
        nq, joints = int(self.problem.robot.model.nq), self.problem.robot.joints
        states, inputs = unpack(variables, int(self.block.x.shape[0]), self.problem.knots)
        impulses = np.array([np.array(self._impulses(row)).T for row in inputs[:, joints:]])
        return Guess(states[:, :nq].copy(), states[:, nq:].copy(), inputs[:, :joints].copy(), impulses)

    def contact_speeds(self, guess: Guess) -> tuple[FloatArray, FloatArray]:
        """Return φ (N, p) and u_t (N, p, 1) of a motion [m/s]."""
        # Gaps and Jacobians at the start, velocities at the end of a knot: the exact step's φ and u.
        closing, sliding = [], []
        for q, v in zip(guess.q[:-1], guess.v[1:], strict=True):
            phi, u = self._seen(q, v)
            closing.append(np.array(phi).ravel())
            sliding.append(np.array(u).T)
        return np.array(closing), np.array(sliding)

    def solve(
        self,
        start: FloatArray,
        eps: float,
        *,
        multipliers: tuple[FloatArray, FloatArray] | None = None,
        contact_bounds: Sides | None = None,
        row_bounds: Sides | None = None,
        **options: Any,
    ) -> Iterate:
        """Return what Ipopt makes of variables at a softening.

        Parameters
        ----------
        start, multipliers
            Variables, and of a warm start those of bounds and rows.
        eps
            [J].
        contact_bounds, row_bounds
            (N, m) of the contacts' variables and (N, m) of the laws' rows, where they differ by knot.
        options
            Ipopt's.
        """
        n, rows = self.problem.knots, (self.rows[0].copy(), self.rows[1].copy())
        if row_bounds is not None:
            rows[0][:, -self._law_rows :], rows[1][:, -self._law_rows :] = row_bounds
        last = np.zeros((n, 1))
        last[-1] = 1.0
        data = np.hstack([self.problem.references[1:], last])
        return self._nlp.solve(start, data, self.bounds(contact_bounds), rows, (eps,), multipliers, **options)


def _contact_speeds(
    problem: DirectProblem, knot: SymbolicKnot, touches: list[tuple[Any, Any]]
) -> tuple[Any, Any]:
    """Return φ (p, 1) and u_t (1, p)."""
    ca = import_casadi()
    gaps, speeds = knot.gaps(knot.q), knot.point_speeds(knot.q, knot.v_after)
    closing = [gaps.T / problem.dt + speeds[2, :].T]
    sliding = [speeds[0, :]]
    for gap, J in touches:
        rate = ca.mtimes(J, knot.v_after)
        closing.append(gap / problem.dt + rate[1])
        sliding.append(rate[0])
    return ca.vertcat(*closing), ca.horzcat(*sliding)
