"""The one stage of a first-order step, with its derivative; see `derivative`.

At fixed impulses λ, with a = (v⁺ - v) / dt and inverse dynamics ID::

    M δv⁺ = M δv + (∂(Jᵀλ)/∂q - dt ∂ID(q, v, a)/∂q) δq - dt ∂ID/∂v δv + dt δτ
    q⁺ = q ⊕ dt v⁺
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.dynamics.derivative.impact import InputRates
from surefoot.mechanics.dynamics.derivative.stages import Stages
from surefoot.mechanics.dynamics.state import Impact


class FirstOrderStages(Stages):
    """Takes a first-order step and keeps its exchange of impulses."""

    def _retrace(self, impact: Impact | None) -> None:
        assert impact is not None  # a first-order step through the air has one without contacts
        stepper, request = self.stepper, self.request
        self.speed = request.state.v
        options, seen = stepper.options, self._seen(request.state.q)
        if request.smoothing > 0.0:
            impact = self._exchange_on_path(impact, seen)
        self.main = self._exchange(
            self._work.heavy, options.dt, impact, seen, options.dt, options.pull, request.smoothing
        )

    def through(self, given: InputRates) -> FloatArray:
        """See `Stages.through`: (2nv + 6p, c)."""
        import pinocchio

        effort = self._pushing(given.q, given.push)
        effort[self.stepper.motors] += given.torques
        dt, impact = self.stepper.options.dt, self.main.impact
        after, left, impulses = self.main.through(given, dt * effort)
        by_q, by_way = pinocchio.dIntegrate(self.stepper.bodies.model, impact.q, dt * impact.after)
        return np.vstack([by_q @ given.q + dt * by_way @ after, after, impulses, left])
