"""Ground in levels along x, with vertical jumps between them: what stairs and pits share."""

from __future__ import annotations

from abc import abstractmethod
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.terrain.surface_shapes import DEPTH, EXTENT, GroundBox
from surefoot.mechanics.terrain.terrain import Terrain


class LevelsTerrain(Terrain):
    """Level stretches across the way.

    As a height field it has vertical normals everywhere; its faces and edges are known to `nearest`.
    """

    @abstractmethod
    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the edges along x (k + 1,), ascending, the outer two far away, and the heights (k,) [m]."""

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope [-] at (..., 2) places [m]: zeros (..., 2)."""
        return np.zeros(np.shape(xy))

    def nearest(self, points: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the distance of (..., 3) points to treads, faces and edges [m], and the normals there.

        A point inside the ground is measured to the tread above it. See `Terrain.nearest`.
        """
        p = np.asarray(points, dtype=np.float64)
        edges, tops = self.levels()
        x, z = p[..., 0], p[..., 2]
        at = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(tops) - 1)
        distance = z - tops[at]
        normal = np.zeros(p.shape)
        normal[..., 2] = 1.0
        for side, near in ((-1, edges[at]), (1, edges[np.minimum(at + 1, len(tops))])):
            other = at + side
            beside = (other >= 0) & (other < len(tops))
            top = tops[np.clip(other, 0, len(tops) - 1)]
            # the closest point of the block beside: on its face, or on its edge for a point above it
            across, up = x - near, np.maximum(z - top, 0.0)
            away = np.hypot(across, up)
            closer = beside & (top > tops[at]) & (z >= tops[at]) & (away < distance)
            distance = np.where(closer, away, distance)
            length = np.where(away > 0.0, away, 1.0)
            outward = np.where(away > 0.0, across / length, -side)  # a point on the face
            normal[..., 0] = np.where(closer, outward, normal[..., 0])
            normal[..., 2] = np.where(closer, up / length, normal[..., 2])
        return distance, normal

    @property
    def highest_step(self) -> float:
        """Largest jump [m]."""
        return float(np.abs(np.diff(self.levels()[1])).max())

    def shapes(self) -> tuple[GroundBox, ...]:
        """Return one box for each level, from its top to `DEPTH` below the lowest one."""
        edges, tops = self.levels()
        bottom = tops.min() - DEPTH
        return tuple(
            GroundBox(
                np.array([0.5 * (low + high), 0.0, 0.5 * (top + bottom)]),
                np.array([high - low, EXTENT, top - bottom]),
            )
            for (low, high), top in zip(pairwise(edges), tops, strict=True)
        )
