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
        self._halfspaces = finite_array("halfspaces", halfspaces, (None, None))
        self._rays = finite_array("rays", rays, (None, None))
        if self._halfspaces.shape[1] != self._rays.shape[1]:
            raise ProblemError(
                f"halfspaces and rays must have the same dimension, got {self._halfspaces.shape[1]} "
                f"and {self._rays.shape[1]}"
            )
        self.dim = self._halfspaces.shape[1]

    @property
    def halfspaces(self) -> FloatArray:
        """(m, dim) outward normals."""
        return self._halfspaces

    @property
    def rays(self) -> FloatArray:
        """(r, dim) generators."""
        return self._rays

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


class RayCone(PolyhedralCone):
    """A cone whose rays are given and whose half-spaces are worked out when they are asked for.

    Membership, projection and support go by the rays, without half-spaces, which can be many thousands.

    Parameters
    ----------
    rays
        (r, dim), in the unit of the cone's points; zero rows and redundant ones are welcome.
    method
        "qhull" or "cdd": see `surefoot.contact.cones.representation`.
    most_rows
        Half-spaces that may be expected at most where they are asked for.

    Examples
    --------
    >>> cone = RayCone([[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1], [0, 0, 1]])
    >>> cone, bool(cone.contains([0.4, 0.4, 1.0]))
    (RayCone(dim=3, 5 rays), True)
    >>> len(cone.halfspaces), cone
    (4, RayCone(dim=3, 4 rows, 4 rays))
    """

    def __init__(self, rays: ArrayLike, method: Method = "qhull", most_rows: float = math.inf) -> None:
        given = finite_array("rays", rays, (None, None))
        super().__init__(np.zeros((0, given.shape[1])), given)
        self._method, self._most_rows, self._converted = method, most_rows, False

    def __repr__(self) -> str:
        rows = f"{len(self._halfspaces)} rows, " if self._converted else ""
        return f"RayCone(dim={self.dim}, {rows}{len(self._rays)} rays)"

    @property
    def halfspaces(self) -> FloatArray:
        """(m, dim) outward normals of length one, worked out once; redundant rays are dropped with that.

        Raises
        ------
        ProblemError
            If there may be more than `most_rows`.
        """
        if not self._converted:
            from surefoot.contact.cones.representation import convert

            most = most_rows(len(self._rays), self.dim)
            if most > self._most_rows:
                raise ProblemError(
                    f"{len(self._rays)} rays may have up to {most} half-spaces, more than most_rows="
                    f"{self._most_rows:g}: use fewer facets or contacts, raise most_rows, or go by "
                    "`contains`, which needs no half-spaces"
                )
            self._halfspaces, kept = convert(self._rays, self._method)
            self._rays, self._converted = self._rays[kept], True
        return self._halfspaces

    def contains(self, x: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether x (..., dim), in any unit, is within tol max(1, ||x||) of the cone: (...)."""
        points = self._points(x)
        scale = np.maximum(1.0, np.linalg.norm(points, axis=-1))
        finite = np.isfinite(points).all(axis=-1)
        near = self.project(np.where(np.asarray(finite)[..., None], points, 0.0))
        return np.asarray(finite & (np.linalg.norm(points - near, axis=-1) <= tol * scale))

    def support(self, direction: ArrayLike, tol: float = 1e-9) -> FloatArray:
        """Return sup of direction . x over the cone for (..., dim) directions: (...), 0 or infinity."""
        d = self._points(direction)
        size = np.linalg.norm(self._rays, axis=1)
        unit = self._rays[size > 0.0] / size[size > 0.0, None]
        over = np.max(d @ unit.T, axis=-1, initial=-np.inf)
        return np.where(over <= tol * np.maximum(1.0, np.linalg.norm(d, axis=-1)), 0.0, np.inf)


def most_rows(rays: int, dim: int) -> int:
    """Return an upper bound on the half-spaces of a cone with so many rays, pointed and of full dimension.

    Facets of the cyclic polytope that is its section, of dimension d = dim - 1 (P. McMullen, "The maximum
    numbers of faces of a convex polytope", Mathematika 17, 1970).
    """
    d = dim - 1
    if rays <= dim:
        return rays + dim
    half = d // 2
    if d % 2:
        return 2 * math.comb(rays - half - 1, half)
    return math.comb(rays - half, half) + math.comb(rays - half - 1, half - 1)


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
