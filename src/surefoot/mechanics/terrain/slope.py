"""An inclined plane."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_number
from surefoot.mechanics.terrain.surface_shapes import Plane
from surefoot.mechanics.terrain.terrain import Terrain


class SlopeTerrain(Terrain):
    """A plane through the origin that rises along +x.

    Parameters
    ----------
    degrees
        Angle of the slope [deg], from -89 to 89; negative falls along +x.

    Examples
    --------
    >>> SlopeTerrain(45.0).height([2.0, 0.0]).round(12)
    np.float64(2.0)
    """

    planar = True

    def __init__(self, degrees: float = 0.0) -> None:
        self.degrees = real_number("slope", degrees, low=-89.0, high=89.0)
        angle = math.radians(self.degrees)
        self._rise = math.tan(angle)
        self._normal = np.array([-math.sin(angle), 0.0, math.cos(angle)]) + 0.0

    def __repr__(self) -> str:
        return f"SlopeTerrain({self.degrees:g})"

    @property
    def text(self) -> str:
        """See `Terrain.text`."""
        return f"slope:{self.degrees!r}"

    @property
    def steepness(self) -> float:
        """Rise over way [-]."""
        return float(np.linalg.norm(self.gradient(np.zeros(2))))

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""
        return np.asarray(np.asarray(xy, dtype=np.float64)[..., 0] * self._rise)

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope along x and y [-] at (..., 2) places [m]: (..., 2), the same everywhere."""
        return np.broadcast_to(np.array([self._rise, 0.0]), np.shape(xy)).copy()

    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the unit normals [-] at (..., 2) places [m]: (..., 3), the same everywhere."""
        shape = np.asarray(xy).shape[:-1]
        return np.broadcast_to(self._normal, (*shape, 3)).copy() if shape else self._normal.copy()

    def shapes(self) -> tuple[Plane]:
        """Return the plane."""
        origin = [0.0, 0.0]
        return (Plane(np.array([*origin, self.height(origin)]), self.frame(origin)),)
