"""Ground with random heights."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, real_number, whole_number
from surefoot.mechanics.terrain.heightfield import HeightfieldTerrain

BUMP = 0.2
"""Distance between the random heights of rough ground [m]."""
FIELD = (16.0, 8.0)
"""Size of rough ground along x and y [m], about the origin."""


def rough_ground(seed: int, height: float) -> HeightfieldTerrain:
    """Return ground with random heights, uniform between 0 and `height` [m], every `BUMP`, smooth in between.

    Examples
    --------
    >>> ground = rough_ground(seed=3, height=0.04)
    >>> bool(0.0 <= ground.heights.min() <= ground.heights.max() <= 0.04)
    True
    """
    top = real_number("height", height, low=0.0, high=10.0)
    counts = [round(size / BUMP) + 1 for size in FIELD]
    random = np.random.default_rng(whole_number("seed", seed))
    return _Rough(random.uniform(0.0, top, counts), f"rough:{whole_number('seed', seed)},{top!r}")


class _Rough(HeightfieldTerrain):
    """A height field that a text says."""

    def __init__(self, heights: FloatArray, text: str) -> None:
        super().__init__(heights, BUMP)
        self._text = text

    @property
    def text(self) -> str:
        """See `Terrain.text`."""
        return self._text
