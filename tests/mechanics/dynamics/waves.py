"""Ground for derivatives."""

from __future__ import annotations

import numpy as np

from surefoot.mechanics.terrain import Terrain


class Waves(Terrain):
    """Rough ground whose curvature is smooth everywhere."""

    def __repr__(self):
        return "Waves()"

    def height(self, xy):
        x, y = np.moveaxis(np.asarray(xy, dtype=float), -1, 0)
        return 0.03 * np.sin(9.0 * x + 1.0) * np.cos(7.0 * y + 2.0)

    def gradient(self, xy):
        x, y = np.moveaxis(np.asarray(xy, dtype=float), -1, 0)
        along = 9.0 * np.cos(9.0 * x + 1.0) * np.cos(7.0 * y + 2.0)
        return 0.03 * np.stack([along, -7.0 * np.sin(9.0 * x + 1.0) * np.sin(7.0 * y + 2.0)], axis=-1)


ROUGH = Waves()
