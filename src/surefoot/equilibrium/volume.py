"""Where the centre of mass may be in space while it accelerates: a convex body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array
from surefoot.cones.cone import Fit
from surefoot.equilibrium.limits import ForceLimits
from surefoot.equilibrium.region import Region
from surefoot.equilibrium.regions import com_region
from surefoot.errors import ProblemError
from surefoot.stance import Stance


@dataclass(frozen=True)
class ComVolume:
    """A convex body of centres of mass, as half-spaces and corners.

    Attributes
    ----------
    rows, bounds
        (m, 3), (m,): the body is {c : rows @ c <= bounds}, rows of length one [m]. All of it can be held.
    corners
        (k, 3) corners [m], none where the body is empty or flat.
    gap
        Largest horizontal gap of the regions it was made of [m].
    """

    rows: FloatArray
    bounds: FloatArray
    corners: FloatArray
    gap: float

    @property
    def empty(self) -> bool:
        """Whether no place (or only a flat set of them) is left."""
        return len(self.corners) == 0

    @property
    def volume(self) -> float:
        """Content [m^3]."""
        from scipy.spatial import ConvexHull

        return 0.0 if self.empty else float(ConvexHull(self.corners).volume)

    def contains(self, points: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether (..., 3) points [m] are in the body, or within `tol` [m] of it: (...)."""
        p = np.asarray(points, dtype=np.float64)
        return np.asarray(np.all(p @ self.rows.T <= self.bounds + tol, axis=-1))


def com_volume(
    stance: Stance,
    mass: float,
    accelerations: ArrayLike = (0.0, 0.0, 0.0),
    heights: tuple[float, float] = (0.0, 1.0),
    tol: float = 1e-3,
    facets: int | None = None,
    fit: Fit = "inner",
    limits: ForceLimits | None = None,
) -> ComVolume:
    """Return where the centre of mass may be in space, for one acceleration or for all of several.

    For one acceleration the set is a prism along gravity minus acceleration. For several it is where
    every one of them is possible; since the set of possible accelerations at a place is convex, the
    corners of a polytope of accelerations stand for all of it.

    Parameters
    ----------
    stance, mass, tol, facets, fit, limits
        As for `com_region`.
    accelerations
        (3,) or (k, 3) of the centre of mass at constant angular momentum, world axes [m/s^2].
    heights
        Lowest and highest centre of mass [m].

    Raises
    ------
    ProblemError
        For heights out of order or an acceleration that lifts the robot off.

    Notes
    -----
    H. Audren, A. Kheddar, "3-D Robust Stability Polyhedron in Multicontact", IEEE T-RO 2018.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> stance = Stance([PointContact([x, y, 0]) for x in (0.2, -0.2) for y in (0.1, -0.1)])
    >>> round(com_volume(stance, 15.0, heights=(0.2, 0.4)).volume, 6)
    0.016
    """
    wanted = np.atleast_2d(finite_array("accelerations", accelerations))
    if wanted.shape[1] != 3 or not len(wanted):
        raise ProblemError(f"accelerations must have shape (3,) or (k, 3), got {wanted.shape}")
    low, high = (float(h) for h in heights)
    if not low < high:
        raise ProblemError(f"heights must be (low, high) with low < high, got {heights}")
    rows, bounds = [np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])], [np.array([high, -low])]
    gap = 0.0
    for acceleration in wanted:
        region = com_region(
            stance, mass, tol, acceleration, height=low, facets=facets, fit=fit, limits=limits
        )
        if len(region.inner) < 3:
            return ComVolume(np.vstack(rows), np.concatenate(bounds), np.zeros((0, 3)), region.gap)
        sides, reach = _prism(region)
        rows.append(sides)
        bounds.append(reach)
        gap = max(gap, region.gap)
    A, b = np.vstack(rows), np.concatenate(bounds)
    return ComVolume(A, b, _corners(A, b), gap)


def _prism(region: Region) -> tuple[FloatArray, FloatArray]:
    """Return the sides of the prism over the inner polygon, along the region's axis."""
    edges = np.roll(region.inner, -1, axis=0) - region.inner
    normals = np.column_stack([edges[:, 1], -edges[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    reach = np.sum(normals * region.inner, axis=1)
    lean = normals @ region.axis[:2]
    rows = np.column_stack([normals, -lean])
    bounds = reach - region.height * lean
    size = np.linalg.norm(rows, axis=1)
    return rows / size[:, None], bounds / size


def _corners(A: FloatArray, b: FloatArray) -> FloatArray:
    """Return the corners of {c : A c <= b}, none if it has no interior."""
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    ball = linprog(
        np.array([0.0, 0.0, 0.0, -1.0]),
        A_ub=np.hstack([A, np.ones((len(A), 1))]),
        b_ub=b,
        bounds=[(None, None)] * 3 + [(0.0, None)],
        method="highs",
    )
    if ball.x is None or ball.x[3] < 1e-9:
        return np.zeros((0, 3))
    try:
        found = HalfspaceIntersection(np.hstack([A, -b[:, None]]), ball.x[:3]).intersections
    except QhullError:
        return np.zeros((0, 3))
    hull = ConvexHull(found)
    return np.asarray(found[hull.vertices])
