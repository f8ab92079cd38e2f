"""Proofs that a contact problem has no solution, and their check; finding one is a solver's work.

Coulomb's law asks u_n >= 0 of every unilateral contact whose normal force is not bounded above, and u = 0
of a bilateral one. So for a direction d with d_n >= 0 on those normals, anything on bilateral contacts and
nothing else, every solution has d·u >= 0. If G d = 0 then d·u = d·(G λ + g) = g·d whatever the forces, and
g·d < 0 proves that there is no solution. For the convex law d may be any direction in which the admissible
set goes on for ever (its recession cone): the forces' energy falls along it without end.

In floating point G d is never zero: d·u = g·d + (G d)·λ, so what d proves is that the forces of a solution
have a sum of norms of at least its reach |g·d| / max_k ||(G d)_k||.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, numbers, of_kind
from surefoot.base.errors import ProblemError
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.scales import ROUNDING
from surefoot.contact.problem.set_scales import block_sizes, parts_of

MEANT = 1e6
"""Forces beyond this many times s / ||G_kk||, the force that stops the fastest contact, are never meant."""


@dataclass(frozen=True)
class InfeasibilityProof:
    """A direction along which no forces within its reach can keep the law; see the module for the argument.

    Attributes
    ----------
    direction
        Direction d [-] in the shape of the forces, (n, 3) or (m,), contact frames, of largest entry one; zero
        on contacts that it does not need.
    work
        g·d < 0, with the rounding of the sum taken off [m/s].
    reach
        No forces with a sum of norms below this solve the problem [N], moments over their lengths; infinite
        where G d is exactly zero.
    needed
        The reach from which a proof counts: forces beyond it are never meant [N].
    """

    direction: FloatArray
    work: float
    reach: float
    needed: float

    @property
    def conclusive(self) -> bool:
        """Whether the reach is beyond any force that could be meant."""
        return self.reach > self.needed


def _admissible(problem: ContactProblem, direction: FloatArray) -> FloatArray:
    """Return the direction cut to the cone of lawful velocities' duals, contact by contact.

    With θ Γ(u) the law's shift, u + θ Γ(u) in K* leaves d·u >= 0 for the directions of K whose friction discs
    are narrowed by 1 - θ: all of K for the convex law, its unilateral part for Coulomb's.
    """
    d = np.where(np.isfinite(direction), direction, 0.0)
    top = float(np.abs(d).max(initial=0.0))
    contacts, out = problem.contact_set, (d / top if top > 0.0 else d).ravel()
    for contact, own in zip(contacts, contacts.split(out), strict=True):
        if contact.bilateral:
            continue
        height = max(float(own[contact.normal]), 0.0) if contact.normal_max == np.inf else 0.0
        share = 1.0 - problem.law.shift_at(contact.coefficient)
        keep = np.zeros(contact.rows)
        keep[contact.normal] = height
        for disc in contact.discs_inside:
            rows = list(disc.rows)
            size = float(np.linalg.norm(own[rows] / contact.lengths[rows]))
            # a little inside the disc: rounding must not carry the direction out of the cone
            limit = disc.radius * (share if disc.friction else 1.0) * height * (1.0 - 4.0 * ROUNDING)
            keep[rows] = own[rows] * (min(1.0, limit / size) if size > 0.0 else 0.0)
        own[:] = keep
    return out.reshape(direction.shape)


def check_proof(problem: ContactProblem, direction: FloatArray) -> InfeasibilityProof | None:
    """Return what a direction (n, 3), in any unit, proves about a problem, or None if it proves nothing.

    The direction is made admissible first. Rounding counts against the proof in every sum. For pyramids under
    the convex law the cone inside the pyramid takes their place: a direction in it is one in both.
    """
    of_kind("problem", problem, ContactProblem)
    if problem.contacts == 0:
        return None
    given = numbers("direction", direction)
    if given.size != problem.g.size:
        raise ProblemError(f"direction must have shape {problem.shape}, got {given.shape}")
    d = _admissible(problem, given.reshape(problem.shape).copy())
    flat, size = d.ravel(), problem.g.size
    terms = problem.g * flat
    # the bound on the sum's rounding, n eps Σ |terms|, is added: it can only weaken the proof
    work = float(terms.sum()) + size * ROUNDING * float(np.abs(terms).sum())
    if not work < 0.0:
        return None
    slack = _drift(problem, d)
    worst = float(slack.max(initial=0.0))
    reach = -work / worst if worst > 0.0 else np.inf
    own = problem.contact_set.split(d) if problem.general else d
    return InfeasibilityProof(
        d, work, reach, _forces_needed(problem, np.array([np.any(part) for part in own]))
    )


def _drift(problem: ContactProblem, d: FloatArray) -> FloatArray:
    """Return a bound on ||(G d)_k|| of every contact, rounding included.

    Sums of sizes: at least the norms, and no square that overflows or vanishes.
    """
    if problem.general:
        drift, noise = np.abs(problem.G @ d.ravel()), np.abs(problem.G) @ np.abs(d.ravel())
        slack = problem.contact_set.lengths * (drift + (d.size + 3) * ROUNDING * noise)
        return np.array([own.sum() for own in problem.contact_set.split(slack)])
    b = problem.blocks
    rows = np.repeat(np.arange(problem.contacts), np.diff(b.starts))
    used = np.abs(d[b.columns]).max(axis=1) > 0.0
    rows, values, ends = rows[used], b.values[used], d[b.columns[used]]
    drift, noise = np.zeros((problem.contacts, 3)), np.zeros((problem.contacts, 3))
    np.add.at(drift, rows, np.einsum("kab,kb->ka", values, ends))
    np.add.at(noise, rows, np.einsum("kab,kb->ka", np.abs(values), np.abs(ends)))
    most = np.diff(b.starts).max(initial=0) * 3 + 3
    return np.asarray(np.abs(drift).sum(axis=1) + most * ROUNDING * noise.sum(axis=1))


def connected_parts(problem: ContactProblem) -> IntArray:
    """Return the number of each contact's part, (n,): parts are joined by no entry of G at all."""
    if problem.general:
        return parts_of(
            block_sizes(problem.contact_set, problem.G), np.ones(problem.contacts, dtype=bool), 0.0
        )
    b, n = problem.blocks, problem.contacts
    rows = np.repeat(np.arange(n), np.diff(b.starts))
    joined = np.abs(b.values).max(axis=(1, 2), initial=0.0) > 0.0
    graph = sp.csr_matrix((joined[joined], (rows[joined], b.columns[joined])), shape=(n, n))
    return np.asarray(sp.csgraph.connected_components(graph, directed=False)[1], dtype=np.int64)


def _forces_needed(problem: ContactProblem, pushed: BoolArray) -> float:
    """Return `InfeasibilityProof.needed`, of the connected parts that the direction lies in."""
    label = connected_parts(problem)
    part = np.isin(label, label[pushed])
    w, s = problem.scales[:2]
    weights = w[part & (w > 0.0)]
    return MEANT * float(s[part].max(initial=0.0)) / float(weights.min()) if weights.size else 0.0
