"""The linear spring and damper, cut where it would pull.

T. Schwager, T. Pöschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9,
2007: a contact that is cut where the force turns negative ends before the overlap is gone, and bounces more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact.laws.soft.soft_law import SoftLaw

FULLY_PLASTIC = 1e-6
"""Restitution below which no damping ratio is looked for: it would be above 1e3."""


@dataclass(frozen=True)
class SpringDamper(SoftLaw):
    """f_n = max(0, stiffness depth + damping depth rate).

    Right for a thin elastic layer, and for what engines call compliant contact. The force jumps at touchdown
    by damping times speed, which no elastic body does; the Hunt-Crossley law does not.

    Attributes
    ----------
    stiffness
        [N/m], > 0.
    damping
        [N s/m], >= 0.

    Examples
    --------
    >>> law = SpringDamper(1e4, 20.0)
    >>> law.force(-0.001, [0.0, 0.0, -0.1])
    array([ 0.,  0., 12.])
    >>> round(law.restitution(mass=1.0), 3)
    0.744
    """

    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < real_number("stiffness", self.stiffness) < math.inf:
            raise ProblemError(f"stiffness must be a finite number > 0 [N/m], got {self.stiffness:g}")
        real_number("damping", self.damping, low=0.0, high=1e300)

    @classmethod
    def bouncing(cls, stiffness: float, restitution: float, mass: float) -> SpringDamper:
        """Return the law under which a mass bounces with a coefficient of restitution.

        Parameters
        ----------
        stiffness
            [N/m].
        restitution
            In (0, 1] [-].
        mass
            Effective mass of the impact, 1 / G_nn [kg].
        """
        ratio = damping_ratio(restitution)
        heavy = real_number("mass", mass, low=np.finfo(float).tiny)
        return cls(stiffness, 2.0 * ratio * math.sqrt(stiffness * heavy))

    def pressed(self, depth: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the force, its derivative by depth and by rate; see `SoftLaw.pressed`."""
        force = self.stiffness * depth + self.damping * rate
        return force, np.full(force.shape, self.stiffness), np.full(force.shape, self.damping)

    def stored(self, depth: FloatArray) -> FloatArray:
        """Return the energy of the spring [J] at (...,) depths [m]."""
        return 0.5 * self.stiffness * depth**2

    def ratio(self, mass: float) -> float:
        """Return the damping ratio of a mass [kg] on this contact, 1 where it just does not oscillate."""
        return self.damping / (2.0 * math.sqrt(self.stiffness * real_number("mass", mass, low=1e-300)))

    def restitution(self, mass: float) -> float:
        """Return the coefficient of restitution of a mass [kg], its weight neglected; any speed."""
        return restitution_of(self.ratio(mass))


def restitution_of(ratio: float) -> float:
    """Return the coefficient of restitution at a damping ratio, the contact cut where it would pull.

    exp(-2 ζ acos(ζ) / sqrt(1 - ζ²)), and its continuation beyond 1 (Schwager and Pöschel 2007, simplified).

    >>> [round(restitution_of(r), 4) for r in (0.0, 0.1, 1.0, 2.0)]
    [1.0, 0.7441, 0.1353, 0.0478]
    """
    zeta = real_number("ratio", ratio, low=0.0, high=1e150)
    if abs(zeta - 1.0) < 1e-9:
        return math.exp(-2.0)
    beta = math.sqrt(abs(1.0 - zeta * zeta))
    time = 2.0 * (math.acos(zeta) if zeta < 1.0 else math.acosh(zeta)) / beta  # until the force is gone, x ω
    return math.exp(-zeta * time)


def damping_ratio(restitution: float) -> float:
    """Return the damping ratio at which a mass bounces with a coefficient of restitution.

    >>> round(damping_ratio(0.5), 6)
    0.255276
    """
    from scipy.optimize import brentq

    wanted = real_number("restitution", restitution)
    if not FULLY_PLASTIC <= wanted <= 1.0:
        raise ProblemError(
            f"restitution must be between {FULLY_PLASTIC:g} and 1, got {wanted:g}: a spring and damper "
            "always gives something back"
        )
    if wanted == 1.0:
        return 0.0
    return float(brentq(lambda zeta: restitution_of(zeta) - wanted, 0.0, 1e3, xtol=1e-14, rtol=1e-14))
