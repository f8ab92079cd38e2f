"""A friction pyramid, three rows: Coulomb's cone linearised from inside or outside."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.sets.cone_projection import nearest
from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class Pyramid(ContactKind):
    """Forces (f_x, f_y, f_z) of a pyramid with so many sides, inside or around the friction cone.

    Maximum dissipation over the pyramid's own section: Γ(u) = max of -f_t · u_t over it at f_z = 1, which
    is mu ||u_t|| only towards an inner pyramid's corners: linearised friction pulls to them.

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.
    facets
        Number of sides, >= 3.
    fit
        "inner" or "outer".

    References
    ----------
    .. [1] D. Stewart, J. Trinkle, "An implicit time-stepping scheme for rigid body dynamics with inelastic
       collisions and Coulomb friction", IJNME 39, 1996.

    Examples
    --------
    >>> Pyramid(mu=0.5, facets=4).project([10.0, 0.0, 5.0]).round(9).tolist()
    [4.0, 0.0, 8.0]
    """

    mu: float
    facets: int = 8
    fit: str = "inner"

    def __post_init__(self) -> None:
        super().__post_init__()
        FrictionPyramid(0.5, self.facets, self.fit)  # type: ignore[arg-type]  # its checks are ours

    @property
    def short_form(self) -> tuple[int | None, str] | None:
        """The pyramid."""
        return self.facets, self.fit

    @cached_property
    def _edges(self) -> FloatArray:
        """The (facets, 2) corners of the section f_z = 1."""
        return FrictionPyramid(self.mu, self.facets, self.fit).rays[:, :2]  # type: ignore[arg-type]

    @property
    def polygon(self) -> tuple[int, bool] | None:
        """The polygon."""
        return self.facets, self.fit == "inner"

    @property
    def discs_inside(self) -> tuple[Factor, ...]:
        """The round cone inside the pyramid."""
        share = float(np.cos(np.pi / self.facets)) if self.fit == "inner" else 1.0
        return (Factor((0, 1), self.mu * share),)

    def nearest(self, y: FloatArray, low: float, high: float) -> FloatArray:
        """Return the nearest point (3,) [N] under other bounds [N]."""
        x, y_, z = (float(v) for v in y)
        return np.array(
            nearest(x, y_, z, float(self.mu), float(low), float(high), self.facets, self.fit == "inner")
        )

    def reach(self, direction: FloatArray, friction: bool | None = None) -> float:
        """Return sup of direction (3,), any unit, · λ over the section λ_n = 1, without the normal's part."""
        return 0.0 if friction is False else float(np.max(self._edges @ np.asarray(direction)[:2]))

    def power(self, force: FloatArray, velocity: FloatArray, friction: bool) -> float:
        """Return the power of the tangents of a force (3,) and velocity (3,): all are friction [W]."""
        return float(np.asarray(force)[:2] @ np.asarray(velocity)[:2]) if friction else 0.0
