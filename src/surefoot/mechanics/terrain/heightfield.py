"""Measured or random ground: heights on a grid, smooth in between."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, positive_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.mechanics.terrain.surface_shapes import Grid
from surefoot.mechanics.terrain.terrain import Terrain


class HeightfieldTerrain(Terrain):
    """Ground from heights on a regular grid.

    Between the grid's points the height is a bicubic (Catmull-Rom) surface: it goes through every point
    and its normals are continuous, so that a foot does not see a kink at every cell. Outside the grid the
    ground goes on level from its border.

    Parameters
    ----------
    heights
        (nx, ny) heights [m], nx and ny >= 2; the first index goes along x.
    spacing
        Distance between grid points [m], > 0.
    origin
        (2,) place of heights[0, 0] [m]; None centres the grid on the world's origin.

    Raises
    ------
    ProblemError
        For heights that are not a finite (nx, ny) grid, or a spacing that is not positive.

    Examples
    --------
    >>> ground = HeightfieldTerrain([[0.0, 0.0], [0.1, 0.1]], spacing=1.0, origin=[0, 0])
    >>> ground.height([[0.0, 0.5], [1.0, 0.2]])
    array([0. , 0.1])
    """

    def __init__(self, heights: ArrayLike, spacing: float, origin: ArrayLike | None = None) -> None:
        self.heights = finite_array("heights", heights, (None, None))
        if min(self.heights.shape) < 2:
            raise ProblemError(f"heights must be at least 2 x 2, got {self.heights.shape}")
        self.spacing = positive_number("spacing", spacing, "m")
        half = 0.5 * self.spacing * (np.array(self.heights.shape) - 1.0)
        self.origin = -half if origin is None else finite_array("origin", origin, (2,))
        self._extended = _extend(self.heights)

    def __repr__(self) -> str:
        nx, ny = self.heights.shape
        return f"HeightfieldTerrain({nx} x {ny}, spacing={self.spacing:g})"

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height at (..., 2) places [m]: (...)."""
        return self._surface(np.asarray(xy, dtype=np.float64))[0]

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope along x and y [-] at (..., 2) places [m]: (..., 2), the surface's own."""
        return self._surface(np.asarray(xy, dtype=np.float64))[1]

    def shapes(self) -> tuple[Grid]:
        """Return the smooth surface over the grid."""
        return (Grid(self.height, self.origin, self.spacing * (np.array(self.heights.shape) - 1.0)),)

    @property
    def highest_step(self) -> float:
        """Height between the lowest and the highest point of the grid [m]."""
        return float(np.ptp(self.heights))

    def _surface(self, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return heights (...) and gradients (..., 2)."""
        flat = np.ascontiguousarray(xy).reshape(-1, 2)
        heights, slopes = bicubic(self._extended, self.origin, self.spacing, flat)
        return heights.reshape(xy.shape[:-1]), slopes.reshape(xy.shape)


def _extend(heights: FloatArray) -> FloatArray:
    """Return the heights with one more line on every side, continued straight."""
    out = np.pad(heights, 1, mode="edge")
    for axis in (0, 1):
        h = np.moveaxis(out, axis, 0)  # a view
        h[0], h[-1] = 2.0 * h[1] - h[2], 2.0 * h[-2] - h[-3]
    return out


@kernel
def catmull_rom(u: float, weights: FloatArray, slopes: FloatArray) -> None:
    """Fill the weights (4,) [-] and their derivatives (4,) at u in [0, 1]."""
    weights[0], slopes[0] = 0.5 * u * (-1.0 + u * (2.0 - u)), 0.5 * (-1.0 + u * (4.0 - 3.0 * u))
    weights[1], slopes[1] = 1.0 + 0.5 * u * u * (3.0 * u - 5.0), 0.5 * u * (9.0 * u - 10.0)
    weights[2], slopes[2] = 0.5 * u * (1.0 + u * (4.0 - 3.0 * u)), 0.5 * (1.0 + u * (8.0 - 9.0 * u))
    weights[3], slopes[3] = 0.5 * u * u * (u - 1.0), 0.5 * u * (3.0 * u - 2.0)


@kernel
def bicubic(
    extended: FloatArray, origin: FloatArray, spacing: float, xy: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return heights (k,) [m], gradients (k, 2) at (k, 2) of a grid with one more line on every side."""
    count = xy.shape[0]
    heights, slopes = np.zeros(count), np.zeros((count, 2))
    weights, rates = np.empty((2, 4)), np.empty((2, 4))
    cell = np.empty(2, dtype=np.int64)
    for k in range(count):
        inside = True
        for a in range(2):
            last = extended.shape[a] - 3.0
            wanted = (xy[k, a] - origin[a]) / spacing
            if not 0.0 < wanted < last:
                inside = False
            at = min(max(wanted, 0.0), last)
            low = min(math.floor(at), last - 1.0)
            if not low >= 0.0:  # a place that is not a number
                low, at = 0.0, math.nan
            cell[a] = int(low)
            catmull_rom(at - low, weights[a], rates[a])
        for i in range(4):
            for j in range(4):
                h = extended[cell[0] + i, cell[1] + j]
                heights[k] += weights[0, i] * weights[1, j] * h
                slopes[k, 0] += rates[0, i] * weights[1, j] * h / spacing
                slopes[k, 1] += weights[0, i] * rates[1, j] * h / spacing
        if not inside:
            slopes[k] = 0.0
    return heights, slopes
