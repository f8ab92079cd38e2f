"""A ditch across the way."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.mechanics.terrain.levels import LevelsTerrain
from surefoot.mechanics.terrain.surface_shapes import EXTENT


class PitTerrain(LevelsTerrain):
    """Level ground with a ditch across the way.

    Parameters
    ----------
    start, length
        Where along x the ditch begins, and how long it is [m].
    depth
        Of the ditch [m].

    Raises
    ------
    ProblemError
        For a number that is not finite, no length, or a negative depth.

    Examples
    --------
    >>> PitTerrain(start=1.0, length=0.3, depth=0.05).height([[0.9, 0.0], [1.1, 2.0]])
    array([ 0.  , -0.05])
    """

    def __init__(self, start: float, length: float, depth: float) -> None:
        given = {"start": start, "length": length, "depth": depth}
        self.start, self.length, self.depth = (float(finite_array(k, v, ())) for k, v in given.items())
        if not self.length > 0.0:
            raise ProblemError(f"length must be positive [m], got {self.length:g}")
        if not self.depth >= 0.0:
            raise ProblemError(f"depth must be >= 0 [m], got {self.depth:g}")

    def __repr__(self) -> str:
        return f"PitTerrain(start={self.start:g}, length={self.length:g}, depth={self.depth:g})"

    @property
    def text(self) -> str:
        """See `Terrain.text`."""
        return f"pit:{self.start!r},{self.length!r},{self.depth!r}"

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""
        x = np.asarray(xy, dtype=np.float64)[..., 0]
        return np.where((x >= self.start) & (x < self.start + self.length), -self.depth, 0.0)

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the ditch's sides along x between two far ends (4,), and the heights (3,) [m]."""
        far, end = 0.5 * EXTENT, self.start + self.length
        ends = -far + min(self.start + 0.5 * far, 0.0), far + max(end - 0.5 * far, 0.0)
        return np.array([ends[0], self.start, end, ends[1]]), np.array([0.0, -self.depth, 0.0])
