"""The 6-D contact wrench cone of a rectangular patch, in closed form.

S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of Surface Contacts for Humanoid Robots: Closed-Form
Formulae of the Contact Wrench Cone for Rectangular Support Areas", ICRA 2015.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, positive_number, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact.cones.cone import Fit
from surefoot.contact.cones.polyhedral import PolyhedralCone, checked_fit

_SIGNS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])


class WrenchCone(PolyhedralCone):
    """Wrenches [force; moment] that a flat rectangular patch can transmit, about its centre.

    The patch presses with a friction pyramid whose four sides face along its own x and y axes:
    |f_x| <= m f_z and |f_y| <= m f_z. With ``fit="inner"`` m = mu / sqrt(2), so that every wrench is
    one that the exact friction cone can give; with ``fit="outer"`` m = mu.

    It is exactly the sum of the four corners' pyramids (Caron's 16 rows): friction that goes into yaw is
    missing for f_x, f_y and an off-centre pressure.

    Parameters
    ----------
    length, width
        Full size along x and y [m], > 0.
    mu
        Friction coefficient [-], finite and >= 0.
    fit
        "inner" or "outer": which pyramid stands for the friction cone.

    Raises
    ------
    ProblemError
        If a size is not positive and finite, a coefficient negative, or the fit unknown.

    Examples
    --------
    Half the weight on the front edge of a 0.2 m x 0.1 m sole: the pressure row is an equality.

    >>> cone = WrenchCone(length=0.2, width=0.1, mu=0.6)
    >>> wrench = np.array([0.0, 0.0, 100.0, 0.0, -10.0, 0.0])  # centre of pressure x = 0.1 m
    >>> bool(cone.contains(wrench)), float(np.max(cone.halfspaces @ wrench))
    (True, 0.0)
    """

    def __init__(self, length: float, width: float, mu: float, fit: Fit = "inner") -> None:
        self.length = positive_number("length", length)
        self.width = positive_number("width", width)
        self.mu = real_number("mu", mu, low=0.0)
        if math.isinf(self.mu):
            raise ProblemError("a wrench cone needs a finite mu, got inf")
        self.fit = checked_fit(fit)
        side = self.mu / math.sqrt(2.0) if fit == "inner" else self.mu
        limits = 0.5 * self.length, 0.5 * self.width, side
        super().__init__(_rows(*limits), _rays(*limits))

    def __repr__(self) -> str:
        return f"WrenchCone(length={self.length:g}, width={self.width:g}, mu={self.mu:g}, fit={self.fit!r})"


def _rows(X: float, Y: float, m: float) -> FloatArray:
    """Return Caron's (16, 6) rows: sliding, tipping, and yaw with its couplings."""
    rows = np.zeros((8, 6))
    for k, (axis, limit) in enumerate(((0, m), (1, m), (3, Y), (4, X))):
        rows[2 * k, axis], rows[2 * k + 1, axis] = 1.0, -1.0
        rows[2 * k : 2 * k + 2, 2] = -limit
    # Caron, Pham and Nakamura 2015: |Y f_x - m τ_x| + |X f_y - m τ_y| - m (X + Y) f_z <= τ_z, one row for
    # each pair of signs of the two, and its mirror image from above
    yaw = [
        [a * Y, b * X, -m * (X + Y), -s * a * m, -s * b * m, -s]
        for s in (1.0, -1.0)  # lower and upper limit of tau_z
        for a, b in _SIGNS
    ]
    return np.vstack([rows, yaw])


def _rays(X: float, Y: float, m: float) -> FloatArray:
    """Return the (16, 6) wrenches of a unit normal force on each edge of each corner's pyramid."""
    rays = []
    for sx, sy in _SIGNS:
        for a, b in _SIGNS:
            force = np.array([a * m, b * m, 1.0])
            rays.append([*force, *np.cross([sx * X, sy * Y, 0.0], force)])
    return np.array(rays)
