"""The exchange of impulses with the ground: the contact problem of a step, and how often it is solved.

The laws hold for the mean velocity of a contact until the next impulses. Of one that holds on, half of what
its velocity changed by since the last impulses is expected to come again: so impulses work on a mean velocity
that obeys the laws, to second order.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.numerics.vectors import largest
from surefoot.base.spatial import GRAVITY
from surefoot.contact import COMPILED_CONTACTS, ContactProblem, ContactSolution, solve
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.arithmetic import FASTEST
from surefoot.mechanics.dynamics.detection import Contacts, Surfaces
from surefoot.mechanics.dynamics.options import StepOptions
from surefoot.mechanics.dynamics.state import Impact

SWERVE = 1e-6
"""Change of a contact's velocity from impulses to impulses that is worth a guess [m/s]."""
GAIN = 1e-3
"""Energy that this guess may make in a step, as a share of what their load gains in a fall over dt."""


class LostMotion(Exception):
    """A number that stopped being finite; `Stepper` says when and in which joint."""


class Tally:
    """Counts the contact problems of one step that were left unsolved, and keeps the worst residual.

    Of soft laws also the largest distance of normal impulses from the law.
    """

    def __init__(self) -> None:
        self.unsolved, self.worst, self.law_error = 0, 0.0, 0.0

    def add(self, solution: ContactSolution) -> None:
        """Count one solution."""
        self.unsolved += not solution.solved
        self.worst = max(self.worst, solution.residuals.velocity_error)

    def add_law(self, error: float, agreed: float) -> None:
        """Count how far the normal impulses ended from their law, as a share of the largest one."""
        self.unsolved += not error <= agreed
        self.law_error = max(self.law_error, error)


class Meeting(NamedTuple):
    """Feet that are about to exchange impulses with the ground.

    Attributes
    ----------
    q, before, free
        See `Impact`.
    contacts
        At q.
    foot
        (p,) index of every contact point's foot.
    L
        (nv, nv) lower factor of the mass matrix at q.
    horizon
        Time to the next impulses [s].
    mu
        Friction of the ground.
    options, tally
        How problems are solved, and who counts them.
    surfaces
        Of the contacts where they are not all alike; None for `mu` and the restitution of `options`.
    """

    q: FloatArray
    before: FloatArray
    free: FloatArray
    contacts: Contacts
    foot: IntArray
    L: FloatArray
    horizon: float
    mu: float
    options: StepOptions
    tally: Tally
    surfaces: Surfaces | None = None

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange of impulses.

        Parameters
        ----------
        near
            (k,) contacts that may touch.
        last, leaving
            (p, 3) impulses of the step before [N s], and contact velocities right after them [m/s].
        """
        guess = self.contacts.swerves(self.before, leaving, last, self.foot, SWERVE)
        if guess is None:
            return self._with_missed(near, last, None)
        arriving, swerve = guess
        impact = self._with_missed(near, last, swerve)
        work, push = arithmetic.mean_work(impact.impulses, arriving, impact.leaving)
        # Friction and normal impulses never do positive work on the mean velocity where restitution is zero:
        # a guess by which they do is a wrong one.
        if work <= GAIN * push * GRAVITY * self.options.dt:
            return impact
        # the guess would make energy: the mean velocity over the impulses themselves takes its place
        guess = self.contacts.swerves(self.before, -arriving, last, self.foot, 0.0)
        if guess is None:
            return self._with_missed(near, last, None)
        summed = np.isin(self.foot, self.foot[last[:, 2] > 0.0])
        return self._with_missed(near, last, guess[1])._replace(summed=summed)

    def _with_missed(self, near: IntArray, warm: FloatArray, swerve: FloatArray | None) -> Impact:
        """Solve the contact problem; contacts that the impulses push into the ground join in."""
        while True:
            impact = self._exchange(near, warm, swerve)
            gaps = self.contacts.gaps
            more = arithmetic.with_missed(impact.velocities, gaps, self.horizon, near)
            # The set only grows, so this ends.
            if more.size == near.size:
                return impact
            near, warm = more, impact.impulses

    def _exchange(self, near: IntArray, warm: FloatArray, swerve: FloatArray | None) -> Impact:
        """Return the impulses of the near contacts, all others without, and what they lead to."""
        impulses, rows, solution = np.zeros(warm.shape), None, None
        if near.size:
            rows, G, g = self.matrices(near)
            if swerve is not None:
                g += swerve[near].ravel()
            solution = self._solution(G, g, rows, near, warm[near])
            impulses[near] = solution.forces
        return self._outcome(near, rows, impulses, swerve, solution)

    def matrices(self, near: IntArray) -> tuple[Any, Any, FloatArray]:
        """Return rows, G [1/kg] and g [m/s] of the near contacts (k,), see `arithmetic.assemble`."""
        options, gaps = self.options, self.contacts.gaps
        if self.surfaces is not None:
            e = self.surfaces.restitution
        else:
            e = np.full(gaps.size, options.restitution)
        given = self.L, self.before, self.free, gaps, near, self.horizon, options.pull
        return self.contacts.assemble(*given, e, options.rest_speed)

    def _solution(
        self, G: Any, g: FloatArray, rows: Any, near: IntArray, warm: FloatArray
    ) -> ContactSolution:
        """Return the counted solution of a contact problem of the near contacts, G the rows' square."""
        options, mu = self.options, self.mu if self.surfaces is None else self.surfaces.friction[near]
        problem = finite_problem(G, g, mu, options.problem_law)
        if near.size > COMPILED_CONTACTS:
            problem.factor = self.contacts.factor(rows)
        solution = solve(problem, options.solver, options.solver_tol, warm_start=warm)
        self.tally.add(solution)
        return solution

    def _outcome(
        self, near: IntArray, rows: Any, impulses: FloatArray, swerve: FloatArray | None,
        solution: ContactSolution | None,
    ) -> Impact:  # fmt: skip
        """Return what the (p, 3) impulses of the near contacts, with their rows, lead to."""
        after = self.free
        if rows is not None:
            after = self.contacts.apply(self.L, rows, impulses[near], self.free)
            if not largest(after) < FASTEST:
                raise LostMotion("velocity under the impulses of contacts")
        leaving = self.contacts.velocities(after)
        means = leaving if swerve is None else leaving + swerve
        return Impact(self.q, self.before, self.free, after, near, rows, impulses, leaving, means, solution)


def checked(G: Any, g: FloatArray) -> None:
    """Refuse a contact problem G (3n, 3n) [1/kg], dense or sparse, g (3n,) [m/s] that is not finite."""
    entries = G if isinstance(G, np.ndarray) else G.data
    if not max(largest(g), largest(entries.ravel())) < np.inf:
        raise LostMotion("contact problem")


def finite_problem(G: Any, g: FloatArray, mu: float | FloatArray, law: str = "coulomb") -> ContactProblem:
    """Return the contact problem G (3n, 3n) [1/kg], g (3n,) [m/s], of finite numbers."""
    checked(G, g)
    return ContactProblem(G, g, mu, law=law)
