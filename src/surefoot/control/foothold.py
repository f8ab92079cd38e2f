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

from surefoot.arrays import FloatArray
from surefoot.control.step_windows import FARTHEST, nearest_shift, step_windows
from surefoot.control.walking_kernels import plane_through
from surefoot.kernels import kernel
from surefoot.spatial import GRAVITY
from surefoot.terrain import Terrain


@kernel
def raibert(
    hip: FloatArray,
    velocity: FloatArray,
    wanted: FloatArray,
    turn_rate: float,
    height: float,
    stance_time: float,
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

    A speed error moves the place by its capture point's offset: a pendulum would come to rest over it.

    Examples
    --------
    >>> raibert(np.zeros(2), np.array([0.5, 0.0]), np.array([0.5, 0.0]), 0.0, 0.3, 0.2)
    array([0.05, 0.  ])
    """
    out = np.empty(2)
    pendulum = math.sqrt(height / GRAVITY)
    swerve = 0.5 * pendulum * pendulum * turn_rate  # for the centripetal acceleration
    for i in range(2):
        across = -wanted[1] if i == 0 else wanted[0]
        out[i] = hip[i] + 0.5 * stance_time * wanted[i] + pendulum * (velocity[i] - wanted[i])
        out[i] -= swerve * across
    return out


@kernel
def step_place(
    com: FloatArray, com_velocity: FloatArray, arm: FloatArray, yaw: float, velocity: FloatArray, left: float,
    height: float, stance_time: float,
) -> FloatArray:  # fmt: skip
    """Return the nominal (2,) place of a foot of a turning body at touchdown, world axes [m].

    Raibert's rule about where the hip will be, plus half of what the body turns over the foot in the stance.

    Parameters
    ----------
    com, com_velocity
        (3,) centre of mass and its velocity now [m], [m/s].
    arm
        (>= 2,) from the centre of mass to where the foot belongs, heading axes [m].
    yaw
        Wanted heading now [rad].
    velocity
        (3,) wanted: forward, left [m/s], yaw rate [rad/s].
    left
        Time to touchdown [s].
    height, stance_time
        As for `raibert`.
    """
    turn = velocity[2]
    c, s = math.cos(yaw + turn * left), math.sin(yaw + turn * left)
    wanted, hip = np.empty(2), np.empty(2)
    wanted[0], wanted[1] = c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]
    x, y = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
    lead = 0.5 * stance_time * turn
    hip[0], hip[1] = com[0] + left * wanted[0] + x, com[1] + left * wanted[1] + y
    out = raibert(hip, com_velocity[:2], wanted, turn, height, stance_time)
    out[0] -= lead * y
    out[1] += lead * x
    return out


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

    def choose(
        self,
        terrain: Terrain,
        place: FloatArray,
        way: FloatArray | None = None,
        before: FloatArray | None = None,
        more: float = math.inf,
    ) -> FloatArray:
        """Return the (2,) place [m] to step on, world axes; the nominal one on a plane.

        On steps across the (2,) `way` of the foot [m] it is moved along the way, between the edges: those
        between which it was to stand `before` (2,) [m], where that was said, is near enough, and moves it by
        no `more` than the nearest [m].
        """
        if terrain.planar:
            return place
        length = 0.0 if way is None else math.hypot(float(way[0]), float(way[1]))
        if way is not None and length > 1e-6:
            along = way / length
            kept = None if before is None else float((before - place) @ along)
            shift = self.step_shift(terrain, place, along, kept, more)
            if shift is not None:
                return np.asarray(place + shift * along)
        return self._best(terrain, place)

    def step_shift(
        self,
        terrain: Terrain,
        place: FloatArray,
        along: FloatArray,
        before: float | None = None,
        more: float = math.inf,
    ) -> float | None:
        """Return how far a foot should be moved along a (2,) direction on steps [m]; None without edges.

        Where the tread that a foot was to stand on `before` is `FARTHEST` away at most, and by no `more`
        farther than the nearest, that one is kept [m].
        """
        windows = step_windows(terrain, place, along, self.margin)
        if windows is None:
            return None
        nearest = float(nearest_shift(windows, np.zeros(1))[0])
        if before is not None:
            tread = int(np.abs(np.clip(before, *windows) - before).argmin())
            shift = float(np.clip(0.0, windows[0][tread], windows[1][tread]))
            if abs(shift) <= min(FARTHEST, abs(nearest) + more):
                return shift
        return nearest if abs(nearest) <= FARTHEST else None

    def _best(self, terrain: Terrain, place: FloatArray) -> FloatArray:
        """Return the best (2,) place about one, by the ground around each [m]."""
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


def fit_plane(places: FloatArray, about: FloatArray, damping: float = 1e-4) -> tuple[float, float, float]:
    """Return (height at `about`, slope along x, slope along y) of the plane nearest to (n, 3) places.

    `damping` [m²] pulls the slopes to zero where the places do not tell them.

    Examples
    --------
    >>> points = np.array([[0, 0, 0.0], [1, 0, 0.1], [0, 1, 0.0], [1, 1, 0.1]])
    >>> [round(v, 3) for v in fit_plane(points, np.zeros(2))]
    [0.0, 0.1, 0.0]
    """
    return plane_through(np.ascontiguousarray(places), np.ascontiguousarray(about), damping)
