"""The step of `surefoot.stepping.Knot` as the rows of a block of an NLP.

Semi-implicit Euler with all forces at the start, written as inverse dynamics (no mass matrix is inverted)::

    dt RNEA(q, v, (v⁺ - v) / dt) = dt S tau + Jᵀλ,      q⁺ = q ⊕ dt v⁺,

and the laws of contact for φ = gap / dt + n·u and u_t, with u = J(q) v⁺: see `contact_rows`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import Block
from surefoot.planning.direct.contact_rows import AXES, ContactLaw, Rows
from surefoot.planning.direct.problem import DirectProblem
from surefoot.planning.direct.symbolic_body import SymbolicBody
from surefoot.planning.transcription.forms import import_casadi


@dataclass(frozen=True)
class Transcription:
    """A knot in symbols, with the bounds of its variables and rows.

    Attributes
    ----------
    block
        Of `build_nlp`; its parameter is eps [J], its data the reference posture of the knot.
    contacts
        Variables and bounds of the contacts, the last ones of the block's u; torques come before.
    row_low, row_high
        (m,) bounds of the block's rows.
    law_rows
        Number of rows of the contact laws, the last ones.
    impulses
        Function of the contacts' variables: (3, p) [N s].
    """

    block: Block
    contacts: Rows
    row_low: FloatArray
    row_high: FloatArray
    law_rows: int
    impulses: Any


def contact_velocities(problem: DirectProblem) -> Any:
    """Return a CasADi function (q, v⁺) to φ (p, 1) and u_t (d - 1, p) [m/s]."""
    ca = import_casadi()
    body = SymbolicBody(problem.robot.model, problem.robot.contact_points)
    q, after = ca.SX.sym("q", body.nq), ca.SX.sym("v", body.nv)
    return ca.Function("seen", [q, after], [*_seen(problem, body, q, after)])


def transcribe(problem: DirectProblem, law: ContactLaw) -> Transcription:
    """Return the block of a problem's knots under a way to write the contact laws."""
    ca = import_casadi()
    body = SymbolicBody(problem.robot.model, problem.robot.contact_points)
    dt, n = problem.dt, body.nv
    x, after = ca.SX.sym("x", body.nq + n), ca.SX.sym("after", body.nq + n)
    q, v, q_after, v_after = x[: body.nq], x[body.nq :], after[: body.nq], after[body.nq :]
    torques, eps = ca.SX.sym("torques", problem.robot.joints), ca.SX.sym("eps")
    reference = ca.SX.sym("reference", body.nq + 1)
    contacts = law.write(*_seen(problem, body, q, v_after), problem.mu, eps)
    frame = problem.terrain.frame([0.0, 0.0])
    forces = ca.mtimes(ca.DM(frame), contacts.impulses) / dt
    effort = body.inverse_dynamics(q, v, (v_after - v) / dt, forces, frame[:, 2])
    motors = ca.vertcat(ca.SX.zeros(problem.robot.base_dof), torques)
    equal = ca.vertcat(dt * (effort - motors), q_after - body.integrate(q, dt * v_after))
    rows = [(equal, 0.0, 0.0), *contacts.rows]
    low = np.concatenate([np.full(r.shape[0], a) for r, a, _ in rows])
    high = np.concatenate([np.full(r.shape[0], b) for r, _, b in rows])
    w = problem.weights
    off = q_after - reference[: body.nq]
    cost = dt * (w.torque * ca.sumsqr(torques) + w.velocity * ca.sumsqr(v_after) + w.posture * ca.sumsqr(off))
    cost += w.change / dt * ca.sumsqr(v_after - v)
    cost += reference[body.nq] * w.end * (ca.sumsqr(off) + ca.sumsqr(v_after))  # 1 in the last knot
    u = ca.vertcat(torques, contacts.variables)
    block = Block(x, u, after, eps, ca.vertcat(*(r for r, _, _ in rows)), cost + contacts.cost, reference)
    impulses = ca.Function("impulses", [contacts.variables], [contacts.impulses])
    return Transcription(block, contacts, low, high, len(low) - int(equal.shape[0]), impulses)


def _seen(problem: DirectProblem, body: SymbolicBody, q: Any, after: Any) -> tuple[Any, Any]:
    """Return φ (p, 1) and u_t (d - 1, p)."""
    ca = import_casadi()
    frame, points = problem.terrain.frame([0.0, 0.0]), problem.robot.contact_points
    above = points.radii + float(problem.terrain.height([0.0, 0.0])) * frame[2, 2]
    gaps = ca.mtimes(ca.DM(frame[:, 2:].T), body.sphere_centres(q)).T - ca.DM(above)
    velocities = ca.mtimes(ca.DM(frame.T), body.point_velocities(q, after, frame[:, 2]))
    return gaps / problem.dt + velocities[2, :].T, velocities[list(AXES[problem.tangents]), :]
