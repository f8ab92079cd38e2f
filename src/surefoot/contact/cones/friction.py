"""Coulomb's friction cone, exact (a second-order cone)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.drawn import Drawn
from surefoot.contact.cones.cone import Cone, Fit
from surefoot.contact.cones.polyhedral import FrictionPyramid


class FrictionCone(Drawn, Cone):
    """Forces (f_x, f_y, f_z) with ||(f_x, f_y)|| <= mu f_z, z along the surface normal.

    Parameters
    ----------
    mu
        Friction coefficient [-], >= 0. Zero is the frictionless ray; infinity is the half-space f_z >= 0
        (closed under duality: the dual of mu is 1 / mu).

    Raises
    ------
    ProblemError
        If mu is negative or NaN.

    Examples
    --------
    >>> cone = FrictionCone(mu=0.5)
    >>> bool(cone.contains([3.0, 0.0, 10.0])), float(cone.use([3.0, 0.0, 10.0]))
    (True, 0.6)
    >>> cone.project([0.0, 10.0, 5.0])
    array([0., 4., 8.])
    """

    dim = 3

    def __init__(self, mu: float) -> None:
        self.mu = real_number("mu", mu, low=0.0)

    def __repr__(self) -> str:
        return f"FrictionCone(mu={self.mu:g})"

    def __str__(self) -> str:
        angle = math.degrees(math.atan(self.mu))
        return f"Friction cone of mu {self.mu:g}: forces up to {angle:.3g} deg from the normal."

    def project(self, x: ArrayLike) -> FloatArray:
        """Return the nearest force of the cone: (..., 3) [N]."""
        f = self._points(x)
        out = f.copy()
        z = f[..., 2]
        if math.isinf(self.mu):
            out[..., 2] = np.maximum(z, 0.0)
            return out
        t = np.hypot(f[..., 0], f[..., 1])
        outside = (t > self.mu * z) | (z < 0.0)  # without friction t = mu z below the ray, too
        length = math.hypot(1.0, self.mu)  # its square overflows for the duals of thin cones
        along = np.maximum((self.mu * t + z) / length, 0.0) / length  # new f_z where outside
        ratio = np.divide(self.mu * along, t, out=np.zeros_like(t), where=t > 0.0)
        out[..., 0] = np.where(outside, ratio * f[..., 0], f[..., 0])
        out[..., 1] = np.where(outside, ratio * f[..., 1], f[..., 1])
        out[..., 2] = np.where(outside, along, z)
        return out

    def margin(self, x: ArrayLike) -> FloatArray:
        """Return the signed distance to the boundary: (...) [N], positive inside.

        Inside it is (mu f_z - ||f_t||) / sqrt(1 + mu^2); see `use` for the share of the cone.
        """
        f = self._points(x)
        z = f[..., 2]
        if math.isinf(self.mu):
            return np.asarray(z.copy())
        t = np.hypot(f[..., 0], f[..., 1])
        length = math.hypot(1.0, self.mu)
        below = self.mu * t + z <= 0.0  # the apex is nearest
        return np.where(below, -np.hypot(t, z), (self.mu * z - t) / length)

    def use(self, x: ArrayLike) -> FloatArray:
        """Return the share of the friction in use by (..., 3) forces, ||f_t|| / (mu f_z): 1 on the boundary.

        Zero for a zero force, infinite for a force that pulls or drags without a normal force.
        """
        f = self._points(x)
        t = np.hypot(f[..., 0], f[..., 1])
        # without a normal force there is no friction to use, and any tangential force is infinitely much
        limit = np.where(f[..., 2] > 0.0, self.mu * f[..., 2], 0.0) if self.mu > 0 else np.zeros_like(t)
        share = np.divide(t, limit, out=np.full_like(t, np.inf), where=limit > 0.0)
        return np.where((t == 0.0) & (f[..., 2] >= 0.0), 0.0, share)

    def dual(self) -> FrictionCone:
        """Return the dual cone, the friction cone of 1 / mu."""
        if self.mu == 0.0:
            return FrictionCone(math.inf)
        return FrictionCone(1.0 / self.mu)

    def polyhedral(self, facets: int = 8, fit: Fit = "inner", phase: float = 0.0) -> FrictionPyramid:
        """Return the pyramid with `facets` sides inside or around this cone.

        Parameters
        ----------
        facets
            Number of sides, >= 3.
        fit
            "inner" never promises a force that the ground cannot give; "outer" never forbids one
            that it can.
        phase
            Turn of the pyramid about the normal [rad]; at zero the first ray of an inner pyramid, and
            the first face of an outer one, points along x.

        Raises
        ------
        ProblemError
            For fewer than three facets, an unknown fit, or mu that is infinite.
        """
        return FrictionPyramid(self.mu, facets, fit, phase)
