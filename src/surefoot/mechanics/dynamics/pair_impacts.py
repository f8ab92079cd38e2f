"""The exchange of impulses between many bodies, each contact with surfaces of its own."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.impacts import GAIN, Meeting
from surefoot.mechanics.dynamics.state import Impact


class PairMeeting(Meeting):
    """Bodies that are about to exchange impulses."""

    def collide(self, near: IntArray, last: FloatArray, leaving: FloatArray) -> Impact:
        """Return the exchange with the guess of how contacts will turn, without it where it makes energy.

        A contact that slides along an edge, or changes its slot, is not where it was: what its velocity
        changed by says little of what it will. See `Meeting.collide`.
        """
        assert self.surfaces is not None
        last = np.where(self.surfaces.on[:, None], last, 0.0)
        impact = super().collide(near, last, leaving)
        arriving = self.contacts.velocities(self.before)
        work, push = arithmetic.mean_work(impact.impulses, arriving, impact.leaving)
        if work <= GAIN * push * GRAVITY * self.options.dt:
            return impact
        return self._with_missed(near, last, None)
