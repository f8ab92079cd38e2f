"""The exchange of forces with soft ground, explicitly: the forces that gap and velocity give before it.

Only as stable as the step is short, which is what this integration is there to show: see
`surefoot.laws.stable_step`. Normal forces come from the law; exact friction is a contact problem in which
they are given, regularised friction follows from the velocity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact import ContactProblem
from surefoot.contact.laws.soft.behaviour import stable_step_together
from surefoot.solvers.solver import solve
from surefoot.spatial import GRAVITY
from surefoot.stepping import arithmetic
from surefoot.stepping.impacts import LostMotion, Meeting
from surefoot.stepping.state import Impact


class ExplicitMeeting(Meeting):
    """Feet that are about to exchange forces with soft ground; see `Meeting`."""

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange; see `Meeting.collide`."""
        law, contacts, dt = self.options.soft, self.contacts, self.horizon
        assert law is not None
        arriving = contacts.velocities(self.before)
        normal = law.normal(contacts.gaps, arriving[:, 2])
        if not arithmetic.largest(normal) < np.inf:
            raise LostMotion("contact force")
        impulses, solution, rows = np.zeros(arriving.shape), None, None
        taken = np.flatnonzero(normal > 0.0)
        if taken.size:
            rows, G, g = self.unshifted(taken)
            _, by_depth, by_rate = law.pressed(-contacts.gaps[taken], -arriving[taken, 2])
            self.tally.add_step(stable_step_together(G[2::3, 2::3], by_depth, by_rate))
            given = dt * normal[taken]
            if law.friction.exact:
                g[2::3] += GRAVITY * dt  # free where forces are given; it sets the speed worth solving
                problem = ContactProblem(G, g, self.mu, given, given)
                solution = solve(
                    problem, self.options.solver, self.options.solver_tol, warm_start=last[taken]
                )
                self.tally.add(solution)
                impulses[taken] = solution.forces
            else:
                ratio = replace(law.friction, mu=self.mu).ratio(arriving[taken, :2])
                impulses[taken, :2] = ratio * given[:, None]
            impulses[taken, 2] = given
        return self._outcome(taken, rows, impulses, None, solution)
