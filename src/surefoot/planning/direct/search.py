"""Ipopt on one transcription: from numbers of a motion to variables, through the solver, and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import build_nlp, pack, unpack
from surefoot.planning.direct.contact_rows import ContactLaw
from surefoot.planning.direct.guess import Guess
from surefoot.planning.direct.problem import DirectProblem
from surefoot.planning.direct.transcribe import contact_velocities, transcribe
from surefoot.planning.transcription.forms import import_casadi

QUIET: dict[str, Any] = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point of the search.

    Attributes
    ----------
    variables, multipliers
        Of the NLP: x, and those of bounds and rows.
    guess
        The motion that they mean.
    cost, violation
        Objective, and the largest violation of a row or bound.
    iterations
        Ipopt's.
    solved
        Whether Ipopt calls it solved, or acceptable.
    said
        Ipopt's return status.
    """

    variables: FloatArray
    multipliers: tuple[FloatArray, FloatArray]
    guess: Guess
    cost: float
    violation: float
    iterations: int
    solved: bool
    said: str


class DirectSearch:
    """A problem under one way to write the contact laws, ready to be solved again and again.

    Parameters
    ----------
    problem
        See `DirectProblem`.
    law
        See `contact_rows`.
    """

    def __init__(self, problem: DirectProblem, law: ContactLaw) -> None:
        self.problem, self.law = problem, law
        self.transcription = transcribe(problem, law)
        self._nlp, self._derivatives = build_nlp(self.transcription.block, problem.knots)
        self._seen = contact_velocities(problem)

    def bounds(
        self, contact_bounds: tuple[FloatArray, FloatArray] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of all variables; those of the contacts (N, m) where they differ by knot."""
        t, n = self.transcription, self.problem.knots
        limits = self.problem.torque_limits
        assert limits is not None
        states = self.problem.state_bounds()
        contacts = (t.contacts.low, t.contacts.high) if contact_bounds is None else contact_bounds
        out = []
        for sign, state, contact in zip((-1.0, 1.0), states, contacts, strict=True):
            own = np.broadcast_to(contact, (n, np.shape(contact)[-1]))
            out.append(pack(state, np.hstack([np.tile(sign * limits, (n, 1)), own])))
        return out[0], out[1]

    def pack(self, guess: Guess) -> FloatArray:
        """Return the NLP's variables (n,) that mean a motion."""
        closing, sliding = self.seen(guess)
        contacts = self.law.start(guess.impulses, closing, sliding, self.problem.mu)
        return pack(np.hstack([guess.q, guess.v]), np.hstack([guess.torques, contacts]))

    def unpack(self, variables: FloatArray) -> Guess:
        """Return the motion that the NLP's variables (n,) mean."""
        nq, joints = int(self.problem.robot.model.nq), self.problem.robot.joints
        states, inputs = unpack(variables, int(self.transcription.block.x.shape[0]), self.problem.knots)
        impulses = np.array([np.array(self.transcription.impulses(row)).T for row in inputs[:, joints:]])
        return Guess(states[:, :nq].copy(), states[:, nq:].copy(), inputs[:, :joints].copy(), impulses)

    def seen(self, guess: Guess) -> tuple[FloatArray, FloatArray]:
        """Return φ (N, p) and u_t (N, p, d - 1) of a motion [m/s]."""
        return contact_motion(self._seen, guess)

    def solve(
        self,
        start: FloatArray,
        eps: float,
        *,
        multipliers: tuple[FloatArray, FloatArray] | None = None,
        contact_bounds: tuple[FloatArray, FloatArray] | None = None,
        row_bounds: tuple[FloatArray, FloatArray] | None = None,
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
        ca, t, n = import_casadi(), self.transcription, self.problem.knots
        given = {**QUIET, **{f"ipopt.{k}": v for k, v in options.items()}, **self._derivatives}
        solver = ca.nlpsol("direct", "ipopt", self._nlp, given)
        low, high = self.bounds(contact_bounds)
        row_low, row_high = np.tile(t.row_low, (n, 1)), np.tile(t.row_high, (n, 1))
        if row_bounds is not None:
            row_low[:, -t.law_rows :], row_high[:, -t.law_rows :] = row_bounds
        last = np.zeros((n, 1))
        last[-1] = 1.0
        data = np.hstack([self.problem.references[1:], last])
        call = {
            "x0": np.clip(start, low, high), "p": np.concatenate([[eps], data.ravel()]),
            "lbx": low, "ubx": high, "lbg": row_low.ravel(), "ubg": row_high.ravel(),
        }  # fmt: skip
        if multipliers is not None:
            call["lam_x0"], call["lam_g0"] = multipliers
        out, said = solver(**call), solver.stats()
        x, g = np.array(out["x"]).ravel(), np.array(out["g"]).ravel()
        beyond = [low - x, x - high, row_low.ravel() - g, g - row_high.ravel()]
        violation = float(max(np.max(b, initial=0.0) for b in beyond))
        back = np.array(out["lam_x"]).ravel(), np.array(out["lam_g"]).ravel()
        return Iterate(
            x, back, self.unpack(x), float(out["f"]), violation, int(said["iter_count"]),
            bool(said["success"]), str(said["return_status"]),
        )  # fmt: skip


def contact_motion(seen: Any, guess: Guess) -> tuple[FloatArray, FloatArray]:
    """Return φ (N, p) and u_t (N, p, d - 1) of a motion [m/s], by the function of `contact_velocities`."""
    closing, sliding = [], []
    for q, v in zip(guess.q[:-1], guess.v[1:], strict=True):
        phi, u = seen(q, v)
        closing.append(np.array(phi).ravel())
        sliding.append(np.array(u).T)
    return np.array(closing), np.array(sliding)
