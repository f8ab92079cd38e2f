"""Polyhedral cones: half-spaces and rays of the same set, and friction pyramids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.contact.cones.cone import Cone, Fit

if TYPE_CHECKING:  # what needs SciPy and compiled code is loaded by the methods that do
    from surefoot.contact.cones.representation import Method


def checked_fit(fit: str) -> Fit:
    """Return which side of a cone its pyramid is on: "inner" or "outer"; any other word is refused."""
    check_name("fit", fit, get_args(Fit))
    return cast("Fit", fit)


class PolyhedralCone(Cone):
    """The cone {x : halfspaces @ x <= 0} = {rays.T @ beta : beta >= 0}.

    Both representations are given and trusted; `from_rays` and `from_halfspaces` work the other one out.
    Cones that are not pointed are welcome: no half-spaces at all is the whole space, no rays at all is {0},
    and a line is a pair of opposite rays.

    Parameters
    ----------
    halfspaces
        (m, dim); rows are outward normals, of any length and in any unit.
    rays
        (r, dim); rows generate the cone, of any length, in the unit of its points.

    Raises
    ------
    ProblemError
        If the two do not have the same dimension, or hold values that are not finite.
    """

    def __init__(self, halfspaces: ArrayLike, rays: ArrayLike) -> None:
        self.halfspaces = finite_array("halfspaces", halfspaces, (None, None))
        self.rays = finite_array("rays", rays, (None, None))
        if self.halfspaces.shape[1] != self.rays.shape[1]:
            raise ProblemError(
                f"halfspaces and rays must have the same dimension, got {self.halfspaces.shape[1]} "
                f"and {self.rays.shape[1]}"
            )
        self.dim = self.halfspaces.shape[1]

    def __repr__(self) -> str:
        return f"{type(self).__name__}(dim={self.dim}, {len(self.halfspaces)} rows, {len(self.rays)} rays)"

    @classmethod
    def from_rays(cls, rays: ArrayLike, method: Method = "qhull") -> PolyhedralCone:
        """Return the cone that the rays (r, dim) generate, redundant rays and rows removed.

        Parameters
        ----------
        rays
            (r, dim) in the unit of the cone's points; zero rows say nothing.
        method
            "qhull" or "cdd": see `surefoot.contact.cones.representation`.

        Examples
        --------
        >>> cone = PolyhedralCone.from_rays([[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1], [0, 0, 1]])
        >>> cone, bool(cone.contains([0.4, 0.4, 1.0])), bool(cone.contains([0.6, 0.6, 1.0]))
        (PolyhedralCone(dim=3, 4 rows, 4 rays), True, False)
        """
        from surefoot.contact.cones.representation import convert

        generators = finite_array("rays", rays, (None, None))
        halfspaces, kept = convert(generators, method)
        return PolyhedralCone(halfspaces, generators[kept])

    @classmethod
    def from_halfspaces(cls, halfspaces: ArrayLike, method: Method = "qhull") -> PolyhedralCone:
        """Return the cone {x : halfspaces @ x <= 0}, redundant rows removed; see `from_rays`.

        Examples
        --------
        >>> PolyhedralCone.from_halfspaces([[0, 0, -1], [0, 0, -2]])
        PolyhedralCone(dim=3, 1 rows, 5 rays)
        """
        polar = PolyhedralCone.from_rays(finite_array("halfspaces", halfspaces, (None, None)), method)
        return PolyhedralCone(polar.rays, polar.halfspaces)

    def project(self, x: ArrayLike) -> FloatArray:
        """Return the nearest point of the cone, (..., dim) in the unit of x: non-negative least squares."""
        from surefoot.contact.cones.nearest import nearest_in_cone

        points = self._points(x)
        return nearest_in_cone(self.rays, points.reshape(-1, self.dim)).reshape(points.shape)

    def margin(self, x: ArrayLike) -> FloatArray:
        """Return the signed distance of x (..., dim) to the boundary, in the unit of x: (...).

        Positive inside, infinite in the whole space.
        """
        points = self._points(x)
        slack = np.asarray(-self._excess(points))
        outside = slack < 0.0
        if np.any(outside):
            slack[outside] = -np.linalg.norm(points[outside] - self.project(points[outside]), axis=-1)
        return slack

    def contains(self, x: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether x (..., dim), in any unit, is within tol max(1, ||x||) of every half-space: (...)."""
        points = self._points(x)
        scale = np.maximum(1.0, np.linalg.norm(points, axis=-1))
        return np.asarray(self._excess(points) <= tol * scale)

    def _excess(self, points: FloatArray) -> FloatArray:
        """Return how far (..., dim) points are beyond the worst half-space: (...), -inf without any."""
        size = np.linalg.norm(self.halfspaces, axis=1)
        normals = self.halfspaces[size > 0.0] / size[size > 0.0, None]
        return np.asarray(np.max(points @ normals.T, axis=-1, initial=-np.inf))

    def dual(self) -> PolyhedralCone:
        """Return the dual cone: its rays are minus the half-spaces, its half-spaces minus the rays."""
        return PolyhedralCone(-self.rays, -self.halfspaces)


@dataclass(frozen=True)
class FitError:
    """How far a pyramid is from its cone, as positive shares of the cone's section.

    Attributes
    ----------
    radial
        Largest radial gap over the radius: 1 - cos(pi / k) inside, 1 / cos(pi / k) - 1 outside.
    area
        Area gap over the circle's area.
    """

    radial: float
    area: float


MOST_FACETS = 1000
"""Sides of a pyramid that is 5e-6 of the friction short of its cone."""


class FrictionPyramid(PolyhedralCone):
    """A friction pyramid with k sides; built by `FrictionCone.polyhedral`.

    Its half-spaces are (k, 3), each with a tangential part of length one, so that a row's slack is in
    newtons of tangential force; rays are (k, 3) with f_z = 1. With mu = 0 (friction coefficient [-]) the
    pyramid is the ray along z and one more row, -f_z <= 0, is needed. `phase` turns it about z [rad].
    """

    def __init__(self, mu: float, facets: int = 8, fit: Fit = "inner", phase: float = 0.0) -> None:
        self.mu = real_number("mu", mu, low=0.0)
        if math.isinf(self.mu):
            raise ProblemError("a friction pyramid needs a finite mu, got inf")
        if whole_number("facets", facets, low=3) > MOST_FACETS:
            raise ProblemError(f"facets must be up to {MOST_FACETS} (then take the exact cone), got {facets}")
        self.facets, self.fit, self.phase = int(facets), checked_fit(fit), float(phase)
        half = math.pi / self.facets
        at = self.phase + 2.0 * half * np.arange(self.facets)
        # rays on the cone and faces inside it, or faces that touch the cone and
        # rays outside: cos(π / k) between them
        face_angle, ray_angle = (at + half, at) if fit == "inner" else (at, at + half)
        face_mu = self.mu * math.cos(half) if fit == "inner" else self.mu
        ray_mu = self.mu if fit == "inner" else self.mu / math.cos(half)
        ones = np.ones(self.facets)
        halfspaces = np.column_stack([np.cos(face_angle), np.sin(face_angle), -face_mu * ones])
        rays = np.column_stack([ray_mu * np.cos(ray_angle), ray_mu * np.sin(ray_angle), ones])
        if self.mu == 0.0:
            halfspaces = np.vstack([halfspaces, [0.0, 0.0, -1.0]])
        super().__init__(halfspaces, rays)

    def __repr__(self) -> str:
        return f"FrictionPyramid(mu={self.mu:g}, facets={self.facets}, fit={self.fit!r})"

    @property
    def fit_error(self) -> FitError:
        """Exact fit errors of this pyramid against its cone, in closed form.

        >>> FrictionPyramid(0.6, 4, "outer").fit_error.radial
        0.41421356...
        """
        half = math.pi / self.facets
        if self.fit == "inner":
            return FitError(1.0 - math.cos(half), 1.0 - math.sin(2 * half) / (2 * half))
        return FitError(1.0 / math.cos(half) - 1.0, math.tan(half) / half - 1.0)
