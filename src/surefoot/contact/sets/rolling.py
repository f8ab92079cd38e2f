"""A point contact with rolling resistance, five rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class Rolling(ContactKind):
    """Wrenches (f_x, f_y, f_z, m_x, m_y) with ||f_t|| <= mu f_z and ||m_t|| <= resistance f_z.

    Sliding and rolling each dissipate the most they can: f_t · u_t = -mu f_z ||u_t|| and m_t · ω_t =
    -resistance f_z ||ω_t||. The shift is the sum, Γ(u) = mu ||u_t|| + resistance ||ω_t||.

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.
    resistance
        Coefficient of rolling resistance [m], >= 0: how far the pressure's centre runs ahead.

    References
    ----------
    .. [1] V. Acary, F. Bourrier, "Coulomb friction with rolling resistance as a cone complementarity
       problem", European Journal of Mechanics A/Solids 85, 2021.

    Examples
    --------
    >>> Rolling(mu=0.5, resistance=0.01).project([0.0, 10.0, 5.0, 0.0, 0.0]).tolist()
    [0.0, 4.0, 8.0, 0.0, 0.0]
    """

    mu: float
    resistance: float
    rows: ClassVar[int] = 5

    def __post_init__(self) -> None:
        super().__post_init__()
        self._checked(resistance=self.resistance)

    @cached_property
    def lengths(self) -> FloatArray:
        """(rows,) [-, m]: the coefficient of rolling resistance for the moments."""
        return np.array([1.0, 1.0, 1.0, self.resistance or 1.0, self.resistance or 1.0])

    @property
    def factors(self) -> tuple[Factor, ...]:
        """Two discs: sliding and rolling."""
        return Factor((0, 1), self.mu), Factor((3, 4), 1.0 if self.resistance > 0.0 else 0.0)
