"""Going down steps that feet have felt: late feet go on to the next tread, settled ones tell where they are.

A foot that has slid over an edge, or missed one, falls onto the next tread: fast on the way there, slowly
near it. What a foot tells of a height in its first instants is off by what the body is shaken; so each stand
is believed once it has lasted.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.walking_feet import SEARCH_SPEED
from surefoot.estimation.felt_flight import FeltFlight

OFF_TREAD, NEAR_TREAD = 0.06, 0.1
"""A late foot that is so much lower than its tread goes down to the next one, and slows down so near to it,
in heights of the centre of mass."""
SLOW_SEARCH = 0.06
"""`search_speed` where a tread should be."""
ONWARD = 1.0
"""`lead` of a foot that goes down to the next one."""
NOISE = 0.008
"""By how much a foot that stands on a tread may seem to be above it [m]."""
SETTLED = 0.05
"""A foot has stood for so long before it tells where [s]."""


class FeltDescent:
    """What feet do and tell on the way down steps.

    Parameters
    ----------
    flight
        The steps.
    height
        Of the centre of mass above the ground [m].

    Attributes
    ----------
    search_speed, lead
        See `Caution`.
    """

    def __init__(self, flight: FeltFlight, height: float) -> None:
        self.flight, self._height = flight, height
        self.search_speed, self.lead = SLOW_SEARCH, 0.0
        self._landed: dict[int, float] = {}
        self._stood: BoolArray | None = None

    def observe(self, time: float, carrying: BoolArray, soles: FloatArray, below: float) -> None:
        """Take in a step at a time [s].

        Parameters
        ----------
        time
            Now [s].
        carrying, soles
            (n,), (n, 3) as for `GroundBelief.observe`.
        below
            How far a late foot is below where it was to find the ground, the most of them [m].
        """
        below /= self._height
        off, near = below > OFF_TREAD, below > -self.flight.rise / self._height - NEAR_TREAD
        self.search_speed = SEARCH_SPEED if off and not near else SLOW_SEARCH
        self.lead = ONWARD if off else 0.0
        self._settle(time, carrying, soles)

    def _settle(self, time: float, carrying: BoolArray, soles: FloatArray) -> None:
        """Learn from feet that have stood for a while."""
        landed = carrying if self._stood is None else carrying & ~self._stood
        self._stood = carrying.copy()
        self._landed = {k: since for k, since in self._landed.items() if carrying[k]}
        self._landed |= dict.fromkeys(np.flatnonzero(landed).tolist(), time)
        for k in [k for k, since in self._landed.items() if time - since >= SETTLED]:
            del self._landed[k]
            self.flight.stand(float(soles[k, :2] @ self.flight.along), float(soles[k, 2]))

    def above(self, soles: FloatArray, asked: BoolArray) -> FloatArray:
        """Return how far (n, 3) soles are above treads, of those `asked`, over what may be noise: (n,)."""
        out = np.zeros(len(soles))
        for k in np.flatnonzero(asked).tolist():
            out[k] = self.flight.above(float(soles[k, :2] @ self.flight.along), float(soles[k, 2])) / NOISE
        return out
