"""A soft finger: friction and torsion about the normal in one elliptic cone, four rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class SoftFinger(ContactKind):
    """Wrenches (f_x, f_y, f_z, m_z) with sqrt(f_x² + f_y² + (m_z / radius)²) <= mu f_z.

    The limit surface of a pressed pad, taken as an ellipsoid. With D = diag(1/mu, 1/mu, 1/(mu radius)) on
    w_t = (f_x, f_y, m_z) it is ||D w_t|| <= f_z; maximum dissipation is w_t · u_t = -f_z ||D⁻¹ u_t||, and the
    shift Γ(u) = ||D⁻¹ u_t|| = mu sqrt(u_x² + u_y² + (radius ω_z)²).

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.
    radius
        Torsional radius [m], >= 0: the largest moment is mu · radius · f_z. Zero is a point contact that
        turns freely.

    References
    ----------
    .. [1] R. Howe, M. Cutkosky, "Practical force-motion models for sliding manipulation", IJRR 15(6), 1996.

    Examples
    --------
    >>> SoftFinger(mu=0.5, radius=0.02).project([0.0, 10.0, 5.0, 0.0]).tolist()
    [0.0, 4.0, 8.0, 0.0]
    """

    mu: float
    radius: float
    rows: ClassVar[int] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        self._checked(radius=self.radius)

    @cached_property
    def lengths(self) -> FloatArray:
        """(rows,) [-, m]: the torsional radius for the moment."""
        return np.array([1.0, 1.0, 1.0, self.radius or 1.0])

    @property
    def factors(self) -> tuple[Factor, ...]:
        """One ball, since the moment is counted over the radius."""
        if self.radius == 0.0:
            return Factor((0, 1), self.mu), Factor((3,), 0.0)
        return (Factor((0, 1, 3), self.mu),)
