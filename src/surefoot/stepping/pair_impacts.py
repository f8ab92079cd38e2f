"""The exchange of impulses between many bodies, each contact with surfaces of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.spatial import GRAVITY
from surefoot.stepping import arithmetic
from surefoot.stepping.detection import Surfaces
from surefoot.stepping.impacts import GAIN, Meeting
from surefoot.stepping.state import Impact


class PairMeeting(Meeting):
    """Bodies that are about to exchange impulses; `surfaces` says what each contact is made of."""

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange with the guess of how contacts will turn, without it where it makes energy.

        A contact that slides along an edge, or changes its slot, is not where it was: what its velocity
        changed by says little of what it will. See `Meeting.collide`.
        """
        last = np.where(self._surfaces.on[:, None], last, 0.0)
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

    def _matrices(self, near: IntArray) -> tuple[Any, Any, FloatArray]:
        """See `Meeting`; each contact has a restitution of its own."""
        pull, gaps = self.options.pull, self.contacts.gaps
        rows, G, g = self.contacts.assemble(self.L, self.before, self.free, gaps, near, self.horizon, pull)
        e, gaps, dt = self._surfaces.restitution[near], gaps[near], self.horizon
        if e.any():  # as `arithmetic.assemble` does with one for all
            before = self.contacts.velocities(self.before)[near, 2]
            shift = np.where(gaps > 0.0, gaps, pull * gaps) / dt
            slow = 2.0 * self.options.dt * GRAVITY
            closing = (before < -slow) & (gaps + dt * (g[2::3] - shift) <= 0.0) & (e > 0.0)
            g[2::3] += np.where(closing, np.minimum(shift, e * before) - shift, 0.0)
        return rows, G, g
