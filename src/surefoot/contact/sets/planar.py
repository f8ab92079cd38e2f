"""Coulomb friction in the plane, two rows: tangent and normal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class Planar(ContactKind):
    """Forces (f_t, f_n) of a contact in a plane, |f_t| <= mu f_n.

    Maximum dissipation: f_t u_t = -mu f_n |u_t|, so the De Saxcé shift is Γ(u) = mu |u_t|.

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.

    References
    ----------
    .. [1] P. Lötstedt, "Coulomb friction in two-dimensional rigid body systems", ZAMM 61, 1981.

    Examples
    --------
    >>> Planar(mu=0.5).project([10.0, 5.0]).tolist()
    [4.0, 8.0]
    """

    mu: float
    rows: ClassVar[int] = 2
    normal: ClassVar[int] = 1

    @property
    def factors(self) -> tuple[Factor, ...]:
        """One interval: friction."""
        return (Factor((0,), self.mu),)
