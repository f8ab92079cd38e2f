"""Ground in levels along x, with vertical jumps between them: what stairs and pits share."""

from __future__ import annotations

from abc import abstractmethod
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.terrain.shapes import DEPTH, EXTENT, Box
from surefoot.terrain.terrain import Terrain


class LevelsTerrain(Terrain):
    """Level stretches across the way. Normals are vertical: a height field has no vertical faces."""

    @abstractmethod
    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the edges along x (k + 1,), ascending, the outer two far away, and the heights (k,) [m]."""

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope [-] at (..., 2) places [m]: zeros (..., 2)."""
        return np.zeros(np.shape(xy))

    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the vertical [-] at (..., 2) places [m]: (..., 3)."""
        shape = np.asarray(xy).shape[:-1]
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), (*shape, 3)).copy()

    @property
    def highest_step(self) -> float:
        """Largest jump [m]."""
        return float(np.abs(np.diff(self.levels()[1])).max())

    def shapes(self) -> tuple[Box, ...]:
        """Return one box for each level, from its top to `DEPTH` below the lowest one."""
        edges, tops = self.levels()
        bottom = tops.min() - DEPTH
        return tuple(
            Box(
                np.array([0.5 * (low + high), 0.0, 0.5 * (top + bottom)]),
                np.array([high - low, EXTENT, top - bottom]),
            )
            for (low, high), top in zip(pairwise(edges), tops, strict=True)
        )
