"""A region of the plane known from inside and outside."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.drawn import Drawn
from surefoot.base.errors import count_of
from surefoot.mechanics.statics.polygons import hull, intersection

_TINY = 1e-300


@dataclass(eq=False, repr=False)
class Region(Drawn):
    """A convex region between an inner and an outer polygon.

    Attributes
    ----------
    inner
        (k, 2) corners, counter-clockwise [m]: every point of this polygon belongs to the region. Two corners
        are a segment, one is a point, none an empty region.
    directions, heights
        (h, 2) [-], (h,) [m]: no point of the region has ``directions @ point > heights``.
    gap
        Largest distance of the outer polygon from the inner one [m], measured on these two; infinite where
        rounding lets nothing be said of what is outside (the polygon stands, and there are no half-planes).
    height
        Height of the plane the polygon lies in [m].
    axis
        (3,) direction [-] along which the region continues unchanged, third component 1 (for a centre of
        mass): vertical when standing still.
    force_limit
        Total normal force that had to be assumed, because the contacts can squeeze each other without
        limit [N]; infinite where nothing was assumed.
    converged
        Whether the gap is within the tolerance asked for.
    """

    inner: FloatArray
    directions: FloatArray
    heights: FloatArray
    gap: float
    height: float
    axis: FloatArray
    force_limit: float = math.inf
    converged: bool = True

    def __repr__(self) -> str:
        if self.empty:
            return "Region(empty)" if self.gap == 0.0 else "Region(undecided)"
        return f"Region(area={self.area:.4g} m^2, gap={self.gap:.2g} m, {len(self.inner)} corners)"

    def __str__(self) -> str:
        if self.empty:
            return "The region is empty." if self.gap == 0.0 else "Undecided: no point of it is certain."
        known = f"known to {1e3 * self.gap:.2g} mm"
        return f"A region of {1e4 * self.area:.0f} cm² with {count_of(len(self.inner), 'corner')}, {known}."

    @property
    def empty(self) -> bool:
        """Whether no point of the region is known: none exists, unless the gap is infinite."""
        return len(self.inner) == 0

    @property
    def area(self) -> float:
        """Area of the inner polygon [m^2]."""
        return polygon_area(self.inner)

    @property
    def outer(self) -> FloatArray:
        """(h, 2) corners of the outer polygon, counter-clockwise [m]; none where nothing bounds it."""
        if self.empty or not len(self.directions):
            return np.zeros((0, 2))
        middle = self.inner.mean(axis=0)
        reach = float(np.max(self.heights - self.directions @ middle, initial=0.0))
        return intersection(self.directions, self.heights, middle, 10.0 * reach + 1e-300)

    def contains(self, point: ArrayLike) -> bool:
        """Tell whether a (2,) point of the plane, or a (3,) point in space, is in the inner polygon [m].

        A point in space is first moved along `axis` to the region's height.
        """
        return self.distance(point) <= 1e-9 * max(1.0, float(np.abs(self.inner).max(initial=0.0)))

    def distance(self, point: ArrayLike) -> float:
        """Return the signed distance of a (2,) or (3,) point to the inner border [m]: negative inside."""
        if self.empty:
            return math.inf
        to_point = self._in_plane(point) - self.inner
        edges = np.roll(self.inner, -1, axis=0) - self.inner
        length = np.maximum((edges * edges).sum(axis=1), _TINY)
        share = np.clip((to_point * edges).sum(axis=1) / length, 0.0, 1.0)
        nearest = float(np.hypot(*(to_point - share[:, None] * edges).T).min())
        left = edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0]
        return -nearest if len(edges) >= 3 and bool(np.all(left >= 0.0)) else nearest

    def at_height(self, height: float) -> FloatArray:
        """Return the inner polygon in the plane of another height [m], moved along the axis: (k, 2) [m]."""
        return np.asarray(self.inner + (height - self.height) * self.axis[:2])

    def _in_plane(self, point: ArrayLike) -> FloatArray:
        p = finite_array("point", point)
        if p.shape == (3,):
            return np.asarray(p[:2] - (p[2] - self.height) * self.axis[:2])
        return finite_array("point", p, (2,))


def polygon_area(corners: FloatArray) -> float:
    """Return the area [m²] of a polygon with (k, 2) corners, positive counter-clockwise (shoelace)."""
    if len(corners) < 3:
        return 0.0
    x, y = corners[:, 0] - corners[0, 0], corners[:, 1] - corners[0, 1]
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def convex_hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of (n, 2) points [m], counter-clockwise; a line has two."""
    return hull(np.ascontiguousarray(points, dtype=np.float64))
