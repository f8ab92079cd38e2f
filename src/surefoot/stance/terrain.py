"""Ground shapes: height, gap and normal at a place."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, real_number
from surefoot.spatial import rotation_from_normal


class Terrain(ABC):
    """The ground as a height field z = height(x, y), world axes; methods take batches (..., 2 or 3)."""

    @abstractmethod
    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""

    @abstractmethod
    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the unit normals out of the ground at (..., 2) places: (..., 3)."""

    def gap(self, points: ArrayLike) -> FloatArray:
        """Return the signed distance of (..., 3) points to the tangent plane below them [m]: (...).

        Exact on planes; elsewhere to first order in the curvature.
        """
        p = np.asarray(points, dtype=np.float64)
        above = p[..., 2] - self.height(p[..., :2])
        return np.asarray(above * self.normal(p[..., :2])[..., 2])

    def frame(self, xy: ArrayLike, heading: ArrayLike = (1.0, 0.0, 0.0)) -> FloatArray:
        """Return rotation_world_contact (3, 3) of the ground at one (2,) place."""
        return rotation_from_normal(self.normal(xy), heading)


class SlopeTerrain(Terrain):
    """A plane through the origin that rises along +x.

    Parameters
    ----------
    degrees
        Angle of the slope [deg], between -90 and 90 (both excluded); negative falls along +x.

    Examples
    --------
    >>> SlopeTerrain(45.0).height([2.0, 0.0]).round(12)
    np.float64(2.0)
    """

    def __init__(self, degrees: float = 0.0) -> None:
        self.degrees = real_number("slope", degrees, low=-89.0, high=89.0)
        angle = math.radians(self.degrees)
        self._rise = math.tan(angle)
        self._normal = np.array([-math.sin(angle), 0.0, math.cos(angle)]) + 0.0

    def __repr__(self) -> str:
        return f"SlopeTerrain({self.degrees:g})"

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""
        return np.asarray(np.asarray(xy, dtype=np.float64)[..., 0] * self._rise)

    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the unit normals at (..., 2) places: (..., 3), the same everywhere."""
        shape = np.asarray(xy).shape[:-1]
        return np.broadcast_to(self._normal, (*shape, 3)).copy()


class FlatTerrain(SlopeTerrain):
    """The plane z = 0."""

    def __init__(self) -> None:
        super().__init__(0.0)

    def __repr__(self) -> str:
        return "FlatTerrain()"
