"""Stairs: flat treads and vertical risers along x."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, positive_number, real_number, whole_number
from surefoot.mechanics.terrain.levels import LevelsTerrain
from surefoot.mechanics.terrain.surface_shapes import EXTENT


class StairsTerrain(LevelsTerrain):
    """Stairs that climb along +x from x = 0, with level ground before and after.

    Step k (1, 2, ..., steps) has its tread at height k * rise for x in [(k - 1) * tread, k * tread); the
    ground is at 0 before the first riser and stays at the last height behind the last (see
    `riser_distance` to keep feet off the risers).

    Parameters
    ----------
    rise
        Height of a step [m]; negative for stairs that go down.
    tread
        Depth of a step [m], > 0.
    steps
        Number of steps, >= 1.

    Examples
    --------
    >>> stairs = StairsTerrain(rise=0.15, tread=0.3, steps=3)
    >>> stairs.height([[-0.1, 0.0], [0.0, 0.0], [0.31, 5.0], [9.0, 0.0]])
    array([0.  , 0.15, 0.3 , 0.45])
    """

    def __init__(self, rise: float = 0.12, tread: float = 0.3, steps: int = 10) -> None:
        self.rise = real_number("rise", rise, low=-10.0, high=10.0)
        self.tread = positive_number("tread", tread, "m")
        self.steps = whole_number("steps", steps, low=1)

    def __repr__(self) -> str:
        return f"StairsTerrain(rise={self.rise:g}, tread={self.tread:g}, steps={self.steps})"

    @property
    def text(self) -> str:
        """See `Terrain.text`; empty unless there are ten steps, as in a text."""
        return f"stairs:{self.rise!r},{self.tread!r}" if self.steps == 10 else ""

    @property
    def steepness(self) -> float:
        """Rise over tread [-]."""
        return abs(self.rise) / self.tread

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the height of the tread at (..., 2) places [m]: (...)."""
        x = np.asarray(xy, dtype=np.float64)[..., 0]
        return np.asarray(self.rise * np.clip(np.floor(x / self.tread) + 1.0, 0.0, self.steps))

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return the risers along x between two far ends (steps + 2,), and the heights (steps + 1,) [m]."""
        far, counts = 0.5 * EXTENT, np.arange(self.steps + 1, dtype=np.float64)
        edges = np.array([-far, *(self.tread * counts[:-1]), self.tread * self.steps + far])
        return edges, np.asarray(self.rise * counts)

    def approach(self, clearance: float) -> FloatArray:
        """Return the (2,) place that lies `clearance` before the first riser [m]."""
        return np.array([-clearance, 0.0])
