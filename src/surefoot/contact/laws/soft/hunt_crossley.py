"""Hunt and Crossley's contact: damping that grows with the overlap, so that the force starts at zero.

K. H. Hunt, F. R. E. Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl.
Mech. 42(2), 1975. The restitution's closed form: D. W. Marhefka, D. E. Orin, IEEE Trans. SMC-A 29(6), 1999.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact.laws.soft.soft_law import SoftLaw


@dataclass(frozen=True)
class HuntCrossley(SoftLaw):
    """f_n = stiffness depth^exponent max(0, 1 + dissipation rate).

    Exponent 1 is what Drake's point contact takes; 3/2 is Hunt and Crossley's sphere.

    Attributes
    ----------
    stiffness
        [N/m^exponent], > 0.
    dissipation
        [s/m], >= 0. Restitution falls with the impact speed, as that of real bodies does: to first order it
        is 1 - 2/3 dissipation speed.
    exponent
        >= 1 [-].

    Examples
    --------
    >>> law = HuntCrossley(2e5, dissipation=0.5)
    >>> law.force(-0.001, [0.0, 0.0, 0.2])
    array([  0.,   0., 180.])
    >>> round(law.restitution(speed=1.0), 4)
    0.7484
    """

    stiffness: float
    dissipation: float = 0.0
    exponent: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < real_number("stiffness", self.stiffness) < math.inf:
            raise ProblemError(f"stiffness must be a finite number > 0 [N/m^p], got {self.stiffness:g}")
        real_number("dissipation", self.dissipation, low=0.0, high=1e300)
        real_number("exponent", self.exponent, low=1.0, high=10.0)

    def pressed(self, depth: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the force, its derivative by depth and by rate; see `SoftLaw.pressed`."""
        elastic = self.stiffness * depth**self.exponent
        slope = self.exponent * self.stiffness * depth ** (self.exponent - 1.0)
        share = np.maximum(1.0 + self.dissipation * rate, 0.0)
        damped = np.where(share > 0.0, self.dissipation * elastic, 0.0)
        return elastic * share, slope * share, damped

    def stored(self, depth: FloatArray) -> FloatArray:
        """Return the elastic energy [J] at (...,) depths [m]."""
        return self.stiffness * depth ** (self.exponent + 1.0) / (self.exponent + 1.0)

    def restitution(self, speed: float) -> float:
        """Return the restitution at an impact speed [m/s], weight neglected; any mass and stiffness."""
        return _restitution(self.dissipation * real_number("speed", speed, low=0.0, high=1e150))

    def words(self, engine: str) -> dict[str, Any] | None:
        """Return stiffness and dissipation where the exponent is 1, Drake's."""
        own = {"stiffness": self.stiffness, "dissipation": self.dissipation}
        return own if engine == "hunt-crossley" and self.exponent == 1.0 else None

    @classmethod
    def bouncing(
        cls, stiffness: float, restitution: float, speed: float, exponent: float = 1.0
    ) -> HuntCrossley:
        """Return the law that bounces with a coefficient of restitution at one impact speed.

        Parameters
        ----------
        stiffness
            [N/m^exponent].
        restitution
            In (0, 1], at least 1e-6 [-].
        speed
            Impact speed at which it holds [m/s], > 0.
        exponent
            Of the depth [-], see the class.
        """
        fast = real_number("speed", speed, low=1e-9, high=1e9)
        return cls(stiffness, _severity(restitution) / fast, exponent)


@dataclass(frozen=True)
class Hertz(HuntCrossley):
    """f_n = stiffness depth^(3/2) max(0, 1 + dissipation rate): a sphere on a half-space, H. Hertz 1882.

    Valid for overlaps that are small beside the radius, and speeds small beside the material's waves.

    Attributes
    ----------
    stiffness
        4/3 E* sqrt(radius) [N/m^1.5]; see `Hertz.sphere`.
    dissipation
        [s/m], 0 for Hertz's elastic bodies.
    exponent
        3/2 [-], no other.
    """

    exponent: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.exponent != 1.5:
            raise ProblemError(f"Hertz's exponent is 1.5, got {self.exponent:g}; HuntCrossley takes any")

    @classmethod
    def sphere(cls, radius: float, modulus: float, poisson: float = 0.5, dissipation: float = 0.0) -> Hertz:
        """Return the law of an elastic sphere on a rigid plane.

        Parameters
        ----------
        radius
            [m].
        modulus
            Young's modulus [Pa].
        poisson
            Poisson's ratio, 0.5 for rubber.
        dissipation
            [s/m].

        Examples
        --------
        >>> law = Hertz.sphere(radius=0.022, modulus=1e7)
        >>> round(1e3 * law.rest_depth(40.0), 3)
        0.613
        """
        size = real_number("radius", radius, low=1e-9, high=1e9)
        stiff = real_number("modulus", modulus, low=1e-9, high=1e15)
        ratio = real_number("poisson", poisson, low=-1.0, high=0.5)
        return cls(4.0 / 3.0 * stiff / (1.0 - ratio**2) * math.sqrt(size), dissipation)


def _restitution(severity: float) -> float:
    """Return e at dissipation times impact speed, a: a - ln(1 + a) = -a e - ln(1 - a e).

    Both sides are the integral of v dv / (1 + dissipation v) over compression and restitution, which do the
    same elastic work.
    """
    from scipy.optimize import brentq

    if severity < 1e-4:  # the logarithms cancel: two terms of the series
        return 1.0 - 2.0 / 3.0 * severity + 4.0 / 9.0 * severity**2
    # the compression's elastic work, times dissipation² over the mass;
    # log1p and expm1 since it nearly cancels
    work = severity - math.log1p(severity)
    # with y = a e in (0, 1): -y - ln(1 - y) = work, solved for z = -ln(1 - y), which stays well scaled
    z = brentq(lambda z: z + math.expm1(-z) - work, 0.0, work + 1.0, xtol=1e-300, rtol=1e-15)
    return float(-math.expm1(-z) / severity)


def _severity(restitution: float) -> float:
    """Return dissipation times impact speed that gives a coefficient of restitution."""
    from scipy.optimize import brentq

    wanted = real_number("restitution", restitution)
    if not 1e-6 <= wanted <= 1.0:
        raise ProblemError(
            f"restitution must be between 1e-6 and 1, got {wanted:g}: this law gives something back"
        )
    if wanted == 1.0:
        return 0.0
    return float(brentq(lambda a: _restitution(a) - wanted, 0.0, 2.0 / wanted, xtol=1e-300, rtol=1e-14))
