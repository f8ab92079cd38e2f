"""How a sole lies on ground that is no plane."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics.terrain import Terrain


def sole_plane(
    terrain: Terrain, corners: FloatArray, xy: FloatArray, yaw: float, radius: float = 0.0
) -> tuple[FloatArray, float]:
    """Return how a sole that is put down lies: frame (3, 3), z its normal, and height of its middle [m].

    On ground that is no plane the normal is that of the plane nearest to the heights under the corners, and
    the sole is as low as it can be with no corner in the ground.

    Parameters
    ----------
    terrain
        The ground.
    corners
        (c, 3) from the middle of the sole to the middles of its corners' spheres, x ahead and z up [m].
    xy
        (2,) where its middle comes to be, world axes [m].
    yaw
        Where its toes point [rad].
    radius
        Of the spheres at its corners [m]; the height is that of their middles.

    Examples
    --------
    >>> from surefoot.mechanics.terrain import SlopeTerrain
    >>> corners = np.array([[0.1, 0.03, 0.0], [0.1, -0.03, 0.0], [-0.1, 0.03, 0.0], [-0.1, -0.03, 0.0]])
    >>> frame, height = sole_plane(SlopeTerrain(10.0), corners, np.array([1.0, 0.0]), 0.0)
    >>> round(height, 4), round(math.degrees(math.acos(frame[2, 2])), 4)
    (0.1763, 10.0)
    """
    c, s = math.cos(yaw), math.sin(yaw)
    if terrain.planar:
        normal = terrain.normal(xy)
    else:
        level = corners[:, :2] @ np.array([[c, s], [-s, c]])
        rows = np.column_stack([level, np.ones(len(level))])
        slope = np.linalg.lstsq(rows, terrain.height(xy + level), rcond=None)[0]
        normal = np.array([-slope[0], -slope[1], 1.0])
        normal /= np.linalg.norm(normal)
    frame = rotation_from_normal(normal, [c, s, 0.0])
    reach = corners @ frame.T
    above = terrain.height(xy + reach[:, :2]) - reach[:, 2]
    return frame, float(above.max()) + radius / float(normal[2])
