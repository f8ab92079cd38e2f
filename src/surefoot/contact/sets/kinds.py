"""Points, lines and soles: the contacts whose sections are products of discs, see `Factor`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.sets.contact import ContactKind, Factor


@dataclass(frozen=True)
class Frictionless(ContactKind):
    """A normal force λ_n >= 0, one row; Signorini's law 0 <= λ_n ⟂ u_n >= 0, under either contact law.

    References
    ----------
    .. [1] A. Signorini, "Sopra alcune questioni di elastostatica", 1933.

    Examples
    --------
    >>> float(Frictionless().project([-3.0])[0])
    0.0
    """

    rows: ClassVar[int] = 1
    normal: ClassVar[int] = 0


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
    _sizes = ("radius",)

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
    _sizes = ("resistance",)

    @cached_property
    def lengths(self) -> FloatArray:
        """(rows,) [-, m]: the coefficient of rolling resistance for the moments."""
        return np.array([1.0, 1.0, 1.0, self.resistance or 1.0, self.resistance or 1.0])

    @property
    def factors(self) -> tuple[Factor, ...]:
        """Two discs: sliding and rolling."""
        return Factor((0, 1), self.mu), Factor((3, 4), 1.0 if self.resistance > 0.0 else 0.0)


@dataclass(frozen=True)
class DecoupledSole(ContactKind):
    """Wrenches [force; moment] about the centre of a sole of length x width, z its normal, limit by limit.

    The friction cone ||(f_x, f_y)|| <= mu f_z, the centre of pressure within the sole, |m_x| <= f_z width / 2
    and |m_y| <= f_z length / 2, and the yaw moment |m_z| <= torsion f_z: six determined numbers where four
    corners have twelve. Cone and centre of pressure are exact; the yaw moment has its own limit, and does not
    know that friction used up in sliding is missing for it. The exact set of a foot is `sf.Sole`.

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

    >>> DecoupledSole(mu=0.6, length=0.2, width=0.1, torsion=0.02).support([0.0, 0.0, -0.1, 0.0, 1.0, 0.0])
    0.0
    """

    mu: float
    length: float
    width: float
    torsion: float
    rows: ClassVar[int] = 6
    _sizes = ("length", "width", "torsion")

    def __post_init__(self) -> None:
        super().__post_init__()
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
