"""Where to put a foot down: Raibert's rule on the terrain, moved off edges and steep ground.

The nominal place lies below the hip at the middle of the coming stance, plus a share of the speed error
that a pendulum of the body's height would need to catch itself [1]_. On terrain that is not a plane,
candidates around it are weighed by their distance, by the height differences within the foot's reach
(edges) and by the part of the friction cone that the ground's tilt uses.

References
----------
.. [1] M. Raibert, "Legged robots that balance", MIT Press, 1986.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.spatial import GRAVITY
from surefoot.terrain import Terrain

CAPTURE_SHARE = 1.0
"""Share of the capture point's offset sqrt(h / g) by which a speed error moves the foothold; at 1 a pendulum
would come to rest over it."""


def raibert(
    hip: FloatArray,
    velocity: FloatArray,
    wanted: FloatArray,
    turn_rate: float,
    height: float,
    stance_time: float,
    capture: float = CAPTURE_SHARE,
) -> FloatArray:
    """Return the nominal (2,) place of a foot at touchdown, world axes [m].

    Parameters
    ----------
    hip
        (2,) where the hip will be at touchdown (of the wanted motion) [m].
    velocity, wanted
        (2,) velocity of the body, as it is and as it should be [m/s].
    turn_rate
        Wanted yaw rate [rad/s].
    height
        Of the centre of mass above the ground [m].
    stance_time
        Length of the coming stance [s].
    capture
        See `CAPTURE_SHARE`.

    Examples
    --------
    >>> raibert(np.zeros(2), np.array([0.5, 0.0]), np.array([0.5, 0.0]), 0.0, 0.3, 0.2)
    array([0.05, 0.  ])
    """
    pendulum = math.sqrt(height / GRAVITY)
    error = velocity - wanted
    across = np.array([-wanted[1], wanted[0]]) * turn_rate  # centripetal acceleration
    return np.asarray(
        hip + 0.5 * stance_time * wanted + capture * pendulum * error - 0.5 * pendulum**2 * across
    )


@dataclass(frozen=True)
class FootholdSearch:
    """Looks for a good place near the nominal one.

    Attributes
    ----------
    reach
        Largest distance from the nominal place, along each axis [m].
    margin
        Distance to edges that is wanted [m].
    edge_weight, tilt_weight
        Cost of a height difference within the margin, and of the ground's slope, against the distance.
    """

    reach: float = 0.08
    margin: float = 0.03
    edge_weight: float = 3.0
    tilt_weight: float = 0.05

    def choose(self, terrain: Terrain, place: FloatArray) -> FloatArray:
        """Return the (2,) place [m] to step on, world axes; the nominal one on a plane."""
        if terrain.planar:
            return place
        steps = np.linspace(-self.reach, self.reach, 9)
        grid = np.stack(np.meshgrid(steps, steps[::2], indexing="ij"), axis=-1).reshape(-1, 2)
        candidates = place + grid
        angles = np.arange(8) * (0.25 * math.pi)
        ring = self.margin * np.column_stack([np.cos(angles), np.sin(angles)])
        middle = terrain.height(candidates)
        around = terrain.height(candidates[:, None, :] + ring)
        rise = np.ptp(np.concatenate([around, middle[:, None]], axis=1), axis=1)
        lean = np.abs(around - middle[:, None]).max(axis=1)
        if terrain.noise > 0.0:  # what may be noise is no edge
            rise, lean = np.maximum(rise - terrain.noise, 0.0), np.maximum(lean - terrain.noise, 0.0)
        cost = np.linalg.norm(grid, axis=1) + self.edge_weight * rise + self.tilt_weight * lean / self.margin
        return np.asarray(candidates[int(np.argmin(cost))])


def fit_plane(
    places: FloatArray, about: FloatArray, damping: float = 1e-4, weights: FloatArray | None = None
) -> tuple[float, float, float]:
    """Return (height at `about`, slope along x, slope along y) of the plane nearest to (n, 3) places.

    `damping` [m²] pulls the slopes to zero where the places do not tell them; (n,) `weights` are 1 for None.

    Examples
    --------
    >>> points = np.array([[0, 0, 0.0], [1, 0, 0.1], [0, 1, 0.0], [1, 1, 0.1]])
    >>> [round(v, 3) for v in fit_plane(points, np.zeros(2))]
    [0.0, 0.1, 0.0]
    """
    xy = places[:, :2] - about
    rows = np.column_stack([np.ones(len(xy)), xy])
    left = rows.T if weights is None else rows.T * weights
    normal = left @ rows
    normal[1:, 1:] += damping * np.eye(2)
    height, slope_x, slope_y = np.linalg.solve(normal, left @ places[:, 2])
    return float(height), float(slope_x), float(slope_y)


def slope_rotation(yaw: ArrayLike, slope: FloatArray) -> FloatArray:
    """Return (..., 3, 3) rotations with z along a plane's normal and x along (...,) headings in the plane.

    Parameters
    ----------
    yaw
        (...,) headings [rad].
    slope
        (2,) rise of the plane along world x and y.
    """
    normal = np.array([-slope[0], -slope[1], 1.0]) / math.sqrt(1.0 + float(slope @ slope))
    heading = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    forward = heading - (heading @ normal)[..., None] * normal
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    left = np.cross(normal, forward)
    return np.stack([forward, left, np.broadcast_to(normal, left.shape)], axis=-1)
