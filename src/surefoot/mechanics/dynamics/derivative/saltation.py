"""The derivative of a step whose impacts are located, with the saltation that moving a touch in time brings.

A flight x(t) that ends where gap(q) = 0 ends later by δs where what goes into it moves::

    δs = -(∂gap/∂q δq) / (∂gap/∂q v),      δx⁻ = ∂x/∂x₀ δx₀ + ẋ⁻ δs

Then come the derivative of the impulses at the touch, and a flight (or an ordinary step) that is shorter by
δs: together the saltation matrix ∂I/∂x + (ẋ⁺ - ∂I/∂x ẋ⁻) ∂gap / (∂gap ẋ⁻) of an impact x⁺ = I(x⁻).

Source: N. J. Kong, J. J. Payne, J. Zhu, A. M. Johnson, "Saltation matrices: the essential tool for
linearizing hybrid dynamical systems", Proceedings of the IEEE 112, 2024.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics.dynamics.derivative.contact_problem import Response
from surefoot.mechanics.dynamics.derivative.impact import Exchange, InputRates
from surefoot.mechanics.dynamics.derivative.stages import Coast, Stages
from surefoot.mechanics.dynamics.state import Impact

AT_ONCE = 1e30
"""Time to the next impulses after an impact [s]: what is open does not take part."""


class LocatedStages(Stages):
    """Keeps the pieces of such a step."""

    def _retrace(self, impact: Impact | None) -> None:
        request, pieces = self.request, self.step.pieces
        self.coasts = [Coast(self._work.flight, *p.start[:2], p.seconds, self.effort) for p in pieces]
        self.touches = [None if p.impact is None else self._touch(p.impact) for p in pieces]
        self.rest: Stages | None = None
        if (rest := pieces[-1].rest) is not None:
            self.rest = Stages(self.stepper, request._replace(state=pieces[-1].start, step=rest))

    def _touch(self, impact: Impact) -> Exchange:
        """Return an impact with what its derivative needs: its contacts touch, and no time goes by."""
        seen, gaps = self._seen(impact.q), np.full(len(impact.impulses), np.inf)
        gaps[impact.near] = 0.0
        level = seen._replace(gaps=gaps)
        return self._exchange(self._work.weightless, 1.0, impact, level, AT_ONCE, 0.0)

    @property
    def responses(self) -> list[tuple[Response, IntArray]]:
        """See `Stages.responses`."""
        found = [(e.response, e.impact.near) for e in self.touches if e is not None and e.response]
        return found + ([] if self.rest is None else self.rest.responses)

    def through(self, given: InputRates) -> FloatArray:
        """See `Stages.through`: (2nv + 6p, c)."""
        n, T, nothing = len(given.q), np.vstack([given.q, given.v]), np.zeros_like(given.leaving)
        effort = np.zeros_like(given.v)
        effort[self.stepper.motors] = given.torques
        total, left, late = nothing, nothing, np.zeros(T.shape[1])
        for k, touch in enumerate(self.touches):
            if self.rest is not None and touch is None:
                rest = self.rest.through(given._replace(q=T[:n], v=T[n:], leaving=left, seconds=-late))
                total, left = total + rest[2 * n : -len(left)], rest[-len(left) :]
                return np.vstack([rest[: 2 * n], total, left])
            T = self._free_motion_rates(k, T, effort, given.inertia)
            wait = -late  # the end of the step stays where it is
            if touch is not None:
                # The gap of whoever touches first stays zero: δs = -(∂gap δq) / (∂gap v⁻), see above.
                opening = touch.ground.gaps()[self.step.pieces[k].first]
                wait = -(opening @ T[:n]) / (opening @ touch.impact.before)
            T, late = T + np.outer(self.coasts[k].pace, wait), late + wait
            if touch is not None:
                rates = given._replace(q=T[:n], v=T[n:], leaving=nothing)
                after, left, impulses = touch.through(rates)
                T, total = np.vstack([T[:n], after]), total + impulses
        return np.vstack([T, total, left])
