"""A rectangular sole without corners: the whole wrench, six rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.sets.contact import ContactKind, Factor
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class Patch(ContactKind):
    """Wrenches [force; moment] about the centre of a sole of length x width, z its normal.

    The friction cone ||(f_x, f_y)|| <= mu f_z, the centre of pressure within the sole, |m_x| <= f_z width / 2
    and |m_y| <= f_z length / 2, and the yaw moment |m_z| <= torsion f_z: six determined numbers where four
    corners have twelve. Cone and centre of pressure are exact; the yaw moment has its own limit, as in
    `WrenchCone(torsion=...)`, and does not know that friction used up in sliding is missing for it.

    The centre of pressure is unilateral contact, not friction: with Γ left out, λ ⟂ u says that no corner
    approaches and that corners which lift carry nothing. Friction dissipates the most it can, f_t · u_t = -mu
    f_z ||u_t|| and m_z ω_z = -torsion f_z |ω_z|: the shift is Γ(u) = mu ||u_t|| + torsion |ω_z|.

    Parameters
    ----------
    mu
        Friction coefficient [-], finite and >= 0.
    length, width
        Full size along x and y [m], > 0.
    torsion
        Largest yaw moment per newton [m], >= 0; 0 turns freely.

    References
    ----------
    .. [1] S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of surface contacts for humanoid robots", ICRA 2015.

    Examples
    --------
    Pressed at the toe with more than the sole's half length:

    >>> Patch(mu=0.6, length=0.2, width=0.1, torsion=0.02).support([0.0, 0.0, -0.1, 0.0, 1.0, 0.0])
    0.0
    """

    mu: float
    length: float
    width: float
    torsion: float
    rows: ClassVar[int] = 6

    def __post_init__(self) -> None:
        super().__post_init__()
        self._checked(length=self.length, width=self.width, torsion=self.torsion)
        if not (self.length > 0.0 and self.width > 0.0):
            raise ProblemError(f"length and width must be > 0, got {self.length:g} and {self.width:g}")

    @cached_property
    def lengths(self) -> FloatArray:
        """(rows,) [-, m]: half the sole for the tipping moments, the torsion for the yaw moment."""
        return np.array([1.0, 1.0, 1.0, 0.5 * self.width, 0.5 * self.length, self.torsion or 1.0])

    @property
    def factors(self) -> tuple[Factor, ...]:
        """A disc for friction, an interval for each moment."""
        return (
            Factor((0, 1), self.mu),
            Factor((3,), 1.0, friction=False),
            Factor((4,), 1.0, friction=False),
            Factor((5,), 1.0 if self.torsion > 0.0 else 0.0),
        )
