"""A point contact with Coulomb friction, three rows."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class Point(ContactKind):
    """Forces (f_x, f_y, f_z) of the friction cone ||f_t|| <= mu f_z, z the surface normal.

    Maximum dissipation: f_t · u_t = -mu f_z ||u_t||, so the De Saxcé shift is Γ(u) = mu ||u_t||.

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.

    References
    ----------
    .. [1] G. De Saxcé, Z.-Q. Feng, "The bipotential method", Math. Comput. Modelling 28, 1998.

    Examples
    --------
    >>> Point(mu=0.5).project([0.0, 10.0, 5.0]).tolist()
    [0.0, 4.0, 8.0]
    """

    mu: float

    @property
    def factors(self) -> tuple[Factor, ...]:
        """One disc: friction."""
        return (Factor((0, 1), self.mu),)

    @property
    def short_form(self) -> tuple[int | None, str] | None:
        """The exact cone."""
        return None, "inner"
