"""The exchange of forces with soft ground: a law's rows in the contact problem, until both agree.

Over a step the law gives λ = dt f(gap + dt u, u), the force at its end (backward Euler: stored energy is
convex in the overlap, so that no step makes energy). Linearised, that is a row with a compliance and a bias
on the normal; friction stays exact. Where the law's force starts with a jump (a damper, MuJoCo's), a contact
that the full force would throw back across the gap within the step ends it at the surface with a part of the
jump: the graph of the law is filled in there, and with it stays monotone. Each Newton step is one contact
problem.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.vectors import largest
from surefoot.base.spatial import GRAVITY
from surefoot.contact import ContactProblem, SoftLaw, solve
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.impacts import GAIN, SWERVE, LostMotion, Meeting, checked
from surefoot.mechanics.dynamics.state import Impact

NEWTON = 40
"""Most linearisations of a step."""
CALM = 15
"""Linearisations after which Newton's steps are halved, in case they go in circles."""
FINER = 1e-3
"""Share of the tolerance to which later linearisations are solved: the solver's error is all that is left."""
AGREED = 1e-8
"""Distance of the normal impulses from the law that ends the iteration, as a share of the largest one."""


class Graph:
    """The law's impulses over a step, as a function of the normal velocities.

    Attributes
    ----------
    law, dt
        See `StepOptions`.
    gaps, arriving
        (p,) at the beginning [m], and normal velocities before the exchange [m/s].
    wall, jump
        (p,) velocities at which the step ends at the surface [m/s], and the largest impulses there [N s].
    """

    def __init__(self, law: SoftLaw, dt: float, gaps: FloatArray, arriving: FloatArray) -> None:
        self.law, self.dt, self.gaps, self.arriving = law, dt, gaps, arriving
        self.wall = -gaps / dt
        self.jump = dt * np.maximum(law.over_step(gaps, self.wall, arriving, dt)[0], 0.0)

    def impulses(self, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the impulses (p,) [N s] below the wall and minus their slopes (p,) [kg]; else zeros."""
        force, slope = self.law.over_step(self.gaps, speeds, self.arriving, self.dt)
        if not (largest(force) < np.inf and largest(slope) < np.inf):
            raise LostMotion("contact force")
        on = (speeds < self.wall) & (force > 0.0) & (slope > 0.0)
        return np.where(on, self.dt * force, 0.0), np.where(on, self.dt * slope, 0.0)


class SoftRows:
    """What each contact's row says, linearised about (p,) normal velocities [m/s].

    0 <= λ ⟂ u + compliance λ + bias >= 0, λ <= most.

    Attributes
    ----------
    on
        (p,) contacts that take part.
    at_wall
        (p,) those of them that end the step at the surface.
    compliance, bias, most
        (p,) [1/kg], [m/s], [N s].
    """

    def __init__(self, graph: Graph, speeds: FloatArray, at_wall: BoolArray) -> None:
        # Newton: λ = Λ₀ - s (u - u₀) is u + λ / s + (-Λ₀ / s - u₀) = 0, a row with the compliance 1 / s. At
        # the wall the velocity is known, u = wall, and the impulse is what part of the jump that takes.
        impulses, slopes = graph.impulses(speeds)
        tangent = (slopes > 0.0) & ~at_wall
        steep = np.where(tangent, slopes, 1.0)
        self.on, self.at_wall = tangent | at_wall, at_wall
        self.compliance = np.where(tangent, 1.0 / steep, 0.0)
        self.bias = np.where(tangent, -impulses / steep - speeds, -graph.wall)
        self.most = np.where(at_wall, graph.jump, np.inf)


class SoftMeeting(Meeting):
    """Feet that are about to exchange forces with soft ground; see `Meeting`."""

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange under the soft law, which itself says who presses; see `Meeting.collide`.

        A foot that holds on is guessed to be carried on along the ground as since the last impulses; what
        that would make of energy through friction is not taken.
        """
        guess = self.contacts.swerves(self.before, leaving, last, self.foot, SWERVE)
        if guess is None:
            return self._agree(last, None)
        arriving, swerve = guess
        swerve[:, 2] = 0.0
        impact = self._agree(last, swerve)
        sideways = impact.impulses.copy()
        sideways[:, 2] = 0.0
        work, _ = arithmetic.mean_work(sideways, arriving, impact.leaving)
        if work <= GAIN * float(impact.impulses[:, 2].sum()) * GRAVITY * self.options.dt:
            return impact
        return self._agree(last, None)

    def _agree(self, warm: FloatArray, swerve: FloatArray | None) -> Impact:
        """Return the exchange in which contact problem and law agree."""
        law, contacts = self.options.soft, self.contacts
        assert law is not None
        arriving = contacts.velocities(self.before)[:, 2]
        graph = Graph(law, self.horizon, contacts.gaps, arriving)
        speeds, at_wall = contacts.velocities(self.free)[:, 2], np.zeros(arriving.shape, dtype=np.bool_)
        if swerve is not None:
            speeds += swerve[:, 2]
        parts, impact, error = None, None, np.inf
        for count in range(NEWTON):
            rows = SoftRows(graph, speeds, at_wall)
            taken = np.flatnonzero(rows.on)
            if parts is None or not np.array_equal(parts[0], taken):
                parts = self._assemble(taken, swerve)
            impact = self._solve_rows(parts, rows, warm, swerve, FINER if count else 1.0)
            warm, found = impact.impulses, impact.velocities[:, 2]
            error, walled = _disagreement(graph, rows, impact, parts)
            if error <= AGREED and np.array_equal(walled, at_wall):
                break
            at_wall = walled
            speeds = found if count < CALM else 0.5 * (found + speeds)
        assert impact is not None
        if impact.solution is not None:
            self.tally.add(impact.solution)
        self.tally.add_law(error, AGREED)
        return impact

    def _assemble(self, taken: IntArray, swerve: FloatArray | None) -> FreeProblem:
        """Return the rows of J, G and g of the contacts that take part, without the law."""
        if not taken.size:
            return FreeProblem(taken, None, np.zeros((0, 0)), np.zeros(0))
        contacts, closed = self.contacts, np.zeros(self.contacts.gaps.size)
        Y, G, g = contacts.assemble(self.L, self.before, self.free, closed, taken, self.horizon, 0.0)
        checked(G, g)
        if swerve is not None:
            g += swerve[taken].ravel()
        return FreeProblem(taken, Y, G, g)

    def _solve_rows(
        self, parts: FreeProblem, rows: SoftRows, warm: FloatArray, swerve: FloatArray | None, finer: float
    ) -> Impact:
        """Return the exchange under linear rows, to `finer` times the tolerance if it can be had."""
        taken, Y, G, g = parts
        impulses, solution = np.zeros(warm.shape), None
        if Y is not None:
            shifted, compliance = g.copy(), np.zeros(g.size)
            shifted[2::3] += rows.bias[taken]
            compliance[2::3] = rows.compliance[taken]
            problem = ContactProblem(
                G, shifted, self.mu, 0.0, rows.most[taken], compliance=compliance
            )  # fmt: skip
            solver, tol = self.options.solver, self.options.solver_tol
            solution = solve(problem, solver, finer * tol, warm_start=warm[taken])
            if finer < 1.0 and not solution.solved:
                solution = solve(problem, solver, tol, warm_start=solution.forces)
            impulses[taken] = solution.forces
        return self._outcome(taken, Y, impulses, swerve, solution)


class FreeProblem(NamedTuple):
    """The contact problem of the contacts `taken` (k,) without the law: Y = L⁻¹ Jᵀ as rows, G, g."""

    taken: IntArray
    Y: FloatArray | None
    G: FloatArray
    g: FloatArray


def _disagreement(
    graph: Graph, rows: SoftRows, impact: Impact, parts: FreeProblem
) -> tuple[float, BoolArray]:
    """Return how far the normal impulses are from the law, and which contacts go to the wall next.

    The distance is Newton's next step of each contact by itself, |λ - Λ(u)| / (1 + G_nn |Λ'|), as a share of
    the largest impulse: that is how far λ is from the law's answer, whatever the stiffness.
    """
    impulses, speeds = impact.impulses[:, 2], impact.velocities[:, 2]
    wanted, slopes = graph.impulses(speeds)
    response = np.zeros(speeds.shape)
    response[parts.taken] = parts.G.diagonal()[2::3]
    full = rows.at_wall & (impulses >= graph.jump)
    crossed = rows.on & ~rows.at_wall & (speeds >= graph.wall) & (impulses > 0.0) & (graph.jump > 0.0)
    walled = crossed | (rows.at_wall & ~full & (impulses > 0.0))
    off = np.abs(impulses - wanted) / (1.0 + response * slopes)
    off[walled & rows.at_wall] = 0.0
    largest = float(impulses.max(initial=0.0))
    worst = float(off.max(initial=0.0))
    if worst == 0.0:
        return 0.0, walled
    return (worst / largest if largest > 0.0 else np.inf), walled
