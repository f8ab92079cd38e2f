"""Convex compliant bodies: half-spaces, and which faces the pressure is counted from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array, real_number
from surefoot.errors import ProblemError


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
