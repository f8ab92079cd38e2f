"""What a pressure field is made of: compliant bodies, the ground as flat pieces, and their polygons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array, real_number
from surefoot.errors import ProblemError
from surefoot.terrain import Plane, Terrain


@dataclass(frozen=True, eq=False)
class CompliantSolid:
    """A convex polyhedron in its own axes: {x: normals @ x <= offsets}.

    Attributes
    ----------
    normals
        (m, 3) unit normals, outwards.
    offsets
        (m,) [m].
    pressed
        (m,) faces whose distance makes the pressure; the nearest of them counts. The others only bound the
        body: the sides of a sole that is glued to a foot.
    corners
        (k, 3) of the body [m], for its extent.
    """

    normals: FloatArray
    offsets: FloatArray
    pressed: BoolArray
    corners: FloatArray

    @classmethod
    def box(cls, size: ArrayLike) -> CompliantSolid:
        """Return a box about its centre, edge lengths `size` (3,) [m], pressed from all its faces."""
        edges = finite_array("size", size, (3,))
        if not (edges > 0.0).all():
            raise ProblemError(f"size must be > 0 [m], got {edges.tolist()}")
        signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
        normals, offsets = np.vstack([np.eye(3), -np.eye(3)]), 0.5 * np.tile(edges, 2)
        return cls(normals, offsets, np.ones(6, dtype=np.bool_), 0.5 * edges * signs)

    @classmethod
    def sole(cls, outline: ArrayLike, thickness: float, height: float = 0.0) -> CompliantSolid:
        """Return a sole, pressed from below only.

        Parameters
        ----------
        outline
            (k, 2) points whose convex hull is the outline, in the foot's axes [m].
        thickness
            Of the compliant layer [m].
        height
            z of the underside in the foot's axes [m].

        Raises
        ------
        ProblemError
            If the points span no area.
        """
        from scipy.spatial import ConvexHull, QhullError

        points = finite_array("outline", outline, (None, 2))
        thick = real_number("thickness", thickness, low=1e-9, high=1e6)
        low = real_number("height", height, low=-1e6, high=1e6)
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError) as error:
            raise ProblemError(f"outline must span an area, got {len(points)} points that do not") from error
        sides = np.unique(hull.equations.round(14), axis=0)
        normals = np.vstack([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], np.pad(sides[:, :2], ((0, 0), (0, 1)))])
        offsets = np.concatenate([[-low, low + thick], -sides[:, 2]])
        rim = points[hull.vertices]
        corners = np.vstack([np.column_stack([rim, np.full(len(rim), z)]) for z in (low, low + thick)])
        return cls(normals, offsets, np.arange(len(offsets)) == 0, corners)

    def distances(self, points: FloatArray) -> FloatArray:
        """Return how far (..., 3) points lie inside every face [m]: (..., m), negative outside."""
        return np.asarray(self.offsets - points @ self.normals.T)


class Facet(NamedTuple):
    """A flat convex piece of ground: corners (k, 3) counter-clockwise from above [m], unit normal (3,)."""

    corners: FloatArray
    normal: FloatArray


def facets(terrain: Terrain, points: FloatArray) -> list[Facet]:
    """Return a square of each of the terrain's planes, beyond (k, 3) points, those of a body [m].

    Raises
    ------
    ProblemError
        If the ground is not of planes.
    """
    out = []
    for plane in terrain.shapes():
        if not isinstance(plane, Plane):
            raise ProblemError(f"a pressure field takes planes; {terrain!r} has a {type(plane).__name__}")
        local = (points - plane.point) @ plane.rotation
        low, high = local[:, :2].min(axis=0), local[:, :2].max(axis=0)
        reach = np.linalg.norm(high - low) + np.abs(local[:, 2]).max() + 1e-9
        square = 0.5 * (low + high) + reach * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        corners = plane.point + np.pad(square, ((0, 0), (0, 1))) @ plane.rotation.T
        out.append(Facet(corners, plane.rotation[:, 2]))
    return out


_A, _B = 0.445948490915965, 0.091576213509771
_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
_PLACES = np.array([[1.0 - 2.0 * s if i == j else s for j in range(3)] for s in (_A, _B) for i in range(3)])
"""Dunavant's rule of degree 4 on a triangle: exact for a pressure of degree two and its first moments."""


def clipped(polygon: FloatArray, values: FloatArray) -> FloatArray:
    """Return the part of a polygon (k, 3) where a linear function, `values` (k,) at its corners, is >= 0."""
    if (values >= 0.0).all():
        return polygon
    if (values < 0.0).all():
        return polygon[:0]
    out = []
    for a, b, x, y in zip(polygon, np.roll(polygon, -1, 0), values, np.roll(values, -1), strict=True):
        if x >= 0.0:
            out.append(a)
        if (x >= 0.0) != (y >= 0.0):
            out.append(a + x / (x - y) * (b - a))
    return np.array(out) if len(out) >= 3 else polygon[:0]


def nodes(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and weights (n,) [m²] that integrate over a convex polygon (k, 3)."""
    triangles = np.stack([np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1], polygon[2:]], axis=1)
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=-1)
    points = np.einsum("nj,tjd->tnd", _PLACES, triangles)
    return points.reshape(-1, 3), (areas[:, None] * _WEIGHTS).ravel()


def nodes_about(
    centre: FloatArray, polygon: FloatArray, normal: FloatArray, along: int = 24, out: int = 8
) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and signed weights (n,) that integrate over a polygon what turns about a point.

    The polygon is the signed sum of the triangles that its edges make with the centre; on rays from there a
    direction of sliding is constant, and Gauss's rule exact; edges are cut below the centre, where the
    direction turns fastest.
    """
    starts, ends = polygon, np.roll(polygon, -1, 0)
    edges = ends - starts
    squares = np.maximum((edges * edges).sum(-1), 1e-300)
    foot = np.clip(((centre - starts) * edges).sum(-1) / squares, 0.0, 1.0)[:, None]
    middle = starts + foot * edges
    starts, ends = np.concatenate([starts, middle]), np.concatenate([middle, ends])
    t, wt = np.polynomial.legendre.leggauss(along)
    s, ws = np.polynomial.legendre.leggauss(out)
    t, wt, s, ws = 0.5 * (t + 1.0), 0.5 * wt, 0.5 * (s + 1.0), 0.5 * ws
    # t^3 draws the points to the foot of the perpendicular, at the start of every second half
    first = np.arange(len(starts)) < len(polygon)
    near, slope = t**3, 3.0 * t**2 * wt
    share = np.where(first[:, None], 1.0 - near, near)
    rim = starts[:, None] + share[..., None] * (ends - starts)[:, None]
    double = np.cross(starts - centre, ends - centre) @ normal
    points = centre + s[:, None] * (rim[:, :, None] - centre)
    weights = double[:, None, None] * slope[None, :, None] * (s * ws)
    return points.reshape(-1, 3), weights.ravel()
