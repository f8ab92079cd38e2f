"""What a sole answers: shares of its cone, and a verdict with its proof."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray

LIMITS = ("friction", "edge", "yaw")
"""Names of what can bind: the sole slides, tips over an edge, or turns."""


@dataclass(frozen=True, eq=False)
class SoleUse:
    """Shares of a sole's cone that wrenches use, all over the normal force that they have: (...) each.

    The least normal force that holds (f_x, f_y, m_x, m_y, m_z) is a homogeneous function of them, so that it
    is the sum of what each kind takes (Euler's theorem). A share may be negative: what it does helps the
    others.

    Attributes
    ----------
    total
        Least normal force over the given one [-]: 1 on the border. 0 for no wrench at all, infinite where no
        normal force is there, NaN where the wrench is not finite.
    friction, edge, yaw
        Shares of the tangential forces, the tipping moments about the sole's centre, and the yaw moment [-];
        their sum is the total. Alone, they are |f_t| / (mu f_z), the pressure's way to the edge, and the yaw
        moment over the largest.
    binds
        Which of the three takes most, by name: "friction", "edge" or "yaw".
    """

    total: FloatArray
    friction: FloatArray
    edge: FloatArray
    yaw: FloatArray

    @property
    def binds(self) -> np.ndarray:
        """(...) names of the largest share."""
        stacked = np.stack([self.friction, self.edge, self.yaw], axis=-1)
        return np.asarray(np.array(LIMITS)[np.argmax(np.nan_to_num(stacked, nan=-1.0), axis=-1)])


@dataclass(frozen=True, eq=False)
class SoleVerdict:
    """Whether a sole holds a wrench, with a proof that `Sole.verdict` has checked in plain arithmetic.

    Attributes
    ----------
    holds
        Whether it does; None where neither proof passed its check.
    margin
        Normal force to spare [N], negative where it is missing.
    forces
        (k, 3) corner forces in their cones [N] that give the wrench, where it holds.
    torsions
        (k,) yaw moments of the corners' pads [N m], zeros without a torsional radius.
    twist
        (6,) velocity [linear; angular] of the sole [m/s, rad/s], where it does not hold: no corner force can
        take power out of it, and the wrench would.
    """

    holds: bool | None
    margin: float
    forces: FloatArray | None = None
    torsions: FloatArray | None = None
    twist: FloatArray | None = None

    def __bool__(self) -> bool:
        return self.holds is True
