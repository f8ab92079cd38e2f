"""What ground is made of, for engines and renderers: planes, boxes and grids of heights, world axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray

EXTENT = 100.0
"""Full length of what has no length of its own [m], about the origin."""
DEPTH = 1.0
"""How far solid ground reaches below its lowest point [m]."""


@dataclass(frozen=True, eq=False)
class Plane:
    """An endless plane.

    Attributes
    ----------
    point
        (3,) on it [m].
    rotation
        (3, 3) rotation_world_plane, z along the normal.
    """

    point: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class GroundBox:
    """A solid box along the world's axes.

    Attributes
    ----------
    centre
        (3,) [m].
    size
        (3,) full lengths [m].
    """

    centre: FloatArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class Grid:
    """A smooth surface over a rectangle, sampled as finely as its consumer likes.

    Attributes
    ----------
    height
        Function of (..., 2) places that returns heights (...) [m].
    origin
        (2,) corner with the smallest x and y [m].
    size
        (2,) lengths along x and y [m].

    Examples
    --------
    >>> ramp = Grid(lambda xy: 0.1 * xy[..., 0], np.zeros(2), np.array([1.0, 0.5]))
    >>> ramp.heights(0.5)
    array([[0.  , 0.  ],
           [0.05, 0.05],
           [0.1 , 0.1 ]])
    """

    height: Callable[[FloatArray], FloatArray]
    origin: FloatArray
    size: FloatArray

    def counts(self, cell: float) -> IntArray:
        """Return the numbers of points (2,) along x and y for cells of at most `cell` [m]."""
        return np.maximum(np.ceil(self.size / cell - 1e-9).astype(np.int64), 1) + 1

    def heights(self, cell: float) -> FloatArray:
        """Return the heights (nx, ny) [m] at the points of `counts`, the first index along x."""
        nx, ny = self.counts(cell)
        x = self.origin[0] + np.linspace(0.0, self.size[0], nx)
        y = self.origin[1] + np.linspace(0.0, self.size[1], ny)
        return np.asarray(self.height(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)))


Shape: TypeAlias = Plane | GroundBox | Grid
"""Consumers hold one builder per class of these three."""
