"""The ground that a walking body follows: a smoothed plane over the terrain ahead, not its last footholds.

The plane through the last footholds jumps with every step onto a stair, and a body that follows it nods. Here
the plane is the weighted least-squares fit of the terrain over a window about the body, longer than a tread
and shifted towards where the body goes. A Hann window lets steps enter and leave it smoothly.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Terrain
from surefoot.motion.ground.ground_settings import GROUND_PLANE

DAMPING = 1e-3
"""Pull of the slopes to zero, as a share of the window's own spread."""


POINTS, ROWS = 25, 3
"""Number of samples along the heading, and of rows beside it."""


def plane_ahead(
    terrain: Terrain, place: FloatArray, yaw: float, velocity: FloatArray, height: float
) -> tuple[float, FloatArray]:
    """Return the height at a (2,) place [m] and the (2,) slope along world x and y of the plane [-].

    Parameters
    ----------
    terrain
        As believed.
    place
        (2,) where the body is [m], world axes.
    yaw
        Its heading [rad].
    velocity
        (2,) wanted velocity, world axes [m/s].
    height
        Of the centre of mass above the ground [m]; sets the window.
    """
    share = np.linspace(-1.0, 1.0, POINTS + 2)[1:-1]
    along = GROUND_PLANE.half_length * height * share
    across = GROUND_PLANE.half_width * height * np.linspace(-1.0, 1.0, ROWS)
    offsets = np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1).reshape(-1, 2)
    weights = np.repeat(1.0 + np.cos(np.pi * share), ROWS)
    weights = weights / weights.sum()
    c, s = math.cos(yaw), math.sin(yaw)
    turned = offsets @ np.array([[c, s], [-s, c]]) + GROUND_PLANE.ahead * velocity[:2]
    heights = terrain.height(place + turned)
    rows = np.column_stack([np.ones(len(turned)), turned])
    normal = (rows * weights[:, None]).T @ rows
    normal[1:, 1:] += DAMPING * height**2 * np.eye(2)
    level, slope_x, slope_y = np.linalg.solve(normal, rows.T @ (weights * heights))
    return float(level), np.array([slope_x, slope_y])
