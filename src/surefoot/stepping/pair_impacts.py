"""The exchange of impulses between many bodies: surfaces of their own, and impacts that run through them.

Newton's law of restitution for all contacts at once has one answer, which is not what a row of balls does: of
three that touch, the first one comes back. The velocities of a wave of collisions one after the other are had
by solving the contacts that close, those alone, again and again, until none does [1]_: the same law, and the
same friction, in the order in which the shock arrives.

References
----------
.. [1] B. Smith, D. M. Kaufman, E. Vouga, R. Tamstorf, E. Grinspun, "Reflections on simultaneous impact", ACM
   Transactions on Graphics 31(4), 2012.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.spatial import GRAVITY
from surefoot.stepping import arithmetic
from surefoot.stepping.detection import Surfaces
from surefoot.stepping.impacts import GAIN, Meeting
from surefoot.stepping.state import Impact

STAGES = 1000
"""Most exchanges of one wave."""


class PairMeeting(Meeting):
    """Bodies that are about to exchange impulses; `surfaces` says what each contact is made of."""

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange of impulses, see `Meeting.collide`."""
        surfaces = self._surfaces
        last = np.where(surfaces.on[:, None], last, 0.0)
        wave, change = self._wave(near) if surfaces.propagation else (None, self.before)
        if wave is None:
            return self._guarded(near, last, leaving)
        settled = self._replace(before=self.before + change, free=self.free + change)
        impact = settled._with_missed(near, last, None)  # a shock says nothing of how contacts turn
        return impact._replace(before=self.before, free=self.free, impulses=impact.impulses + wave)

    def _guarded(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange with the guess of how contacts will turn, without it where it makes energy.

        A contact that slides along an edge, or changes its slot, is not where it was: what its velocity
        changed by says little of what it will.
        """
        impact = super().collide(near, last, leaving)
        arriving = self.contacts.velocities(self.before)
        work, push = arithmetic.mean_work(impact.impulses, arriving, impact.leaving)
        if work <= GAIN * push * GRAVITY * self.options.dt:
            return impact
        return self._with_missed(near, last, None)

    @property
    def _surfaces(self) -> Surfaces:
        assert self.surfaces is not None
        return self.surfaces

    @property
    def _slow(self) -> float:
        """Speed below which nothing bounces [m/s]: what gravity makes in two steps."""
        return 2.0 * self.options.dt * GRAVITY

    def _wave(self, near: IntArray) -> tuple[FloatArray | None, FloatArray]:
        """Return the impulses (p, 3) of a wave of impacts (None without any), and their change of v (nv,)."""
        surfaces, contacts = self._surfaces, self.contacts
        total, v, still = np.zeros((len(self.foot), 3)), self.before, np.zeros(self.before.size)
        for stage in range(STAGES):
            speeds = contacts.velocities(v)[near, 2]
            closing = (speeds < -self._slow) & (surfaces.restitution[near] > 0.0)
            closing &= contacts.gaps[near] + self.horizon * speeds <= 0.0
            chosen = near[closing]
            if not chosen.size:
                return (total if stage else None), v - self.before
            rows, G, g = self._replace(before=v, free=v).unshifted(chosen)
            g[2::3] += surfaces.restitution[chosen] * speeds[closing]
            solution = self._solution(G, g, chosen, np.zeros((chosen.size, 3)))
            total[chosen] += solution.forces
            v = v + contacts.apply(self.L, rows, solution.forces, still)
        return total, v - self.before

    def _matrices(self, near: IntArray) -> tuple[Any, Any, FloatArray]:
        """See `Meeting`; each contact has a restitution of its own."""
        pull, gaps = self.options.pull, self.contacts.gaps
        rows, G, g = self.contacts.assemble(self.L, self.before, self.free, gaps, near, self.horizon, pull)
        self._bounce(near, g, pull)
        return rows, G, g

    def _bounce(self, near: IntArray, g: FloatArray, pull: float) -> None:
        """Put each contact's restitution into g, as `arithmetic.assemble` does one for all."""
        e, gaps, dt = self._surfaces.restitution[near], self.contacts.gaps[near], self.horizon
        if not e.any():
            return
        before = self.contacts.velocities(self.before)[near, 2]
        shift = np.where(gaps > 0.0, gaps, pull * gaps) / dt
        closing = (before < -self._slow) & (gaps + dt * (g[2::3] - shift) <= 0.0) & (e > 0.0)
        g[2::3] += np.where(closing, np.minimum(shift, e * before) - shift, 0.0)
