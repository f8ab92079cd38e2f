"""A range sensor that looks at the ground ahead: rays, noise, mounting errors, rate and latency.

What a ray hits is found on the true terrain, so that edges hide what lies behind them. The points are in
base axes, as they were when they were taken; where the base was then, the robot has to know itself.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Remembering
from surefoot.base.spatial import rotation_about, rotation_exp, rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.motion import HeightScan

MARCH, BISECTIONS = 64, 7
"""Places along a ray at which the ground is looked for, and halvings after that."""
NEAREST = 0.08
"""What is nearer is not seen [m]."""


@dataclass(frozen=True)
class RangeSensor:
    """A depth camera or lidar at the robot's front; the defaults are an ordinary time-of-flight camera.

    Attributes
    ----------
    rate
        Scans in a second [1/s].
    latency
        From a scan to its points [s].
    reach
        Largest distance [m].
    pitch
        Angle by which it looks down [deg].
    across, along
        Width and height of its field of view [deg].
    columns, rows
        Rays; each scan turns all of them by a random part of a pixel.
    noise
        Standard deviation of a distance, as a share of it.
    dropped, stray
        Shares of rays that give nothing, and a distance that has nothing to do with the ground.
    tilt, shift
        Standard deviations of its mounting's errors about and along each axis [rad], [m]; fixed in a run.
    position
        (forward, up) from the base's origin, in lengths from there to the front feet and in heights of it.
    """

    rate: float = 15.0
    latency: float = 0.04
    reach: float = 2.0
    pitch: float = 45.0
    across: float = 100.0
    along: float = 80.0
    columns: int = 48
    rows: int = 36
    noise: float = 0.01
    dropped: float = 0.05
    stray: float = 0.003
    tilt: float = 0.008
    shift: float = 0.004
    position: tuple[float, float] = (1.5, 0.25)

    def scaled(self, level: float) -> RangeSensor:
        """Return a sensor whose noise, stray rays and mounting errors are `level` times as large."""
        level = real_number("level", level, low=0.0, high=100.0)
        grown = ("noise", "tilt", "shift", "stray")
        return replace(self, **{name: level * getattr(self, name) for name in grown})

    def check(self) -> None:
        """Raise `ProblemError` for a number that no sensor has."""
        real_number("rate of the range sensor", self.rate, low=0.1, high=1000.0)
        real_number("latency of the range sensor", self.latency, low=0.0, high=1.0)
        real_number("reach of the range sensor", self.reach, low=NEAREST + 0.01, high=100.0)
        for name in ("across", "along"):
            real_number(name, getattr(self, name), low=1.0, high=170.0)
        for name in ("noise", "tilt", "shift"):
            real_number(name, getattr(self, name), low=0.0, high=1.0)
        if not 0.0 <= self.dropped + self.stray <= 1.0 or min(self.dropped, self.stray) < 0.0:
            raise ProblemError("dropped and stray rays of a range sensor must be shares, together at most 1")
        if min(self.columns, self.rows) < 2:
            raise ProblemError("a range sensor needs at least 2 x 2 rays")


class ActiveRangeSensor(Remembering):
    """A range sensor at work on a robot and a true terrain.

    Parameters
    ----------
    model
        The sensor.
    robot
        Who carries it.
    terrain
        What it looks at.
    dt
        Time between calls [s].
    seed
        Of its random numbers.

    Raises
    ------
    ProblemError
        For numbers that no sensor has.
    """

    MEMORY = ("_random", "_true_mounting", "_true_place", "_count", "_waiting")

    def __init__(
        self, model: RangeSensor, robot: Robot, terrain: Terrain, dt: float, seed: int | None
    ) -> None:
        model.check()
        self.model, self.terrain = model, terrain
        self._random = random = np.random.default_rng([0 if seed is None else seed, 3])
        self._every = max(1, round(1.0 / (model.rate * dt)))
        self._late = max(0, round(model.latency / dt))
        feet = robot.foot_positions(robot.nominal) - robot.nominal[:3]
        front = float(feet[:, 0].max())
        self._place = np.array([model.position[0] * front, 0.0, model.position[1] * float(robot.nominal[2])])
        angle = math.radians(model.pitch)
        self._mounting = rotation_about(np.array([0.0, 1.0, 0.0]), angle)
        turn = model.tilt * random.normal(size=3)
        self._true_mounting = rotation_exp(turn) @ self._mounting
        self._true_place = self._place + model.shift * random.normal(size=3)
        self._count = 0
        self._waiting: deque[tuple[int, HeightScan]] = deque()

    def look(self, q: FloatArray, time: float) -> HeightScan | None:
        """Return the scan that arrives at a time [s] with the robot at the true (nq,) q, or None."""
        if self._count % self._every == 0:
            self._waiting.append((self._count + self._late, self._scan(q, time)))
        self._count += 1
        if self._waiting and self._waiting[0][0] < self._count:
            return self._waiting.popleft()[1]
        return None

    def _scan(self, q: FloatArray, time: float) -> HeightScan:
        """Return what the sensor makes of the ground."""
        model, random = self.model, self._random
        R = rotation_from_quaternion(q[3:7])
        rays = self._rays()
        origin, directions = q[:3] + R @ self._true_place, rays @ (R @ self._true_mounting).T
        distance = cast_rays(self.terrain, origin, directions, model.reach)
        fate = random.random(len(rays))
        distance = distance * (1.0 + model.noise * random.normal(size=len(rays)))
        stray = random.random(len(rays)) * model.reach
        distance = np.where(fate < model.stray, stray, distance)
        seen = np.isfinite(distance) & (fate < 1.0 - model.dropped)
        seen &= distance > NEAREST
        points = self._place + (distance[seen, None] * rays[seen]) @ self._mounting.T
        # a point's height is as uncertain as the ray's length, seen from above, and its direction
        return HeightScan(time, points, (model.noise * distance[seen]) ** 2 + 4e-6, self._place.copy())

    def _rays(self) -> FloatArray:
        """Return the unit directions (k, 3) of a scan, x along the sensor's axis."""
        model, random = self.model, self._random
        steps = [math.radians(model.across) / model.columns, math.radians(model.along) / model.rows]
        jitter = random.random(2) - 0.5
        azimuth = steps[0] * (np.arange(model.columns) - 0.5 * (model.columns - 1) + jitter[0])
        elevation = steps[1] * (np.arange(model.rows) - 0.5 * (model.rows - 1) + jitter[1])
        a, e = (grid.ravel() for grid in np.meshgrid(azimuth, elevation, indexing="ij"))
        return np.column_stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), -np.sin(e)])


def cast_rays(terrain: Terrain, origin: FloatArray, directions: FloatArray, reach: float) -> FloatArray:
    """Return how far rays go to the ground: (k,) [m], infinite for those that do not meet it within reach.

    Parameters
    ----------
    terrain
        The ground.
    origin
        (3,) where all rays begin, above the ground [m].
    directions
        (k, 3) unit vectors.
    reach
        Largest distance [m].

    Examples
    --------
    >>> from surefoot.mechanics.terrain import FlatTerrain
    >>> down = np.array([[0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [1.0, 0.0, 0.0]])
    >>> cast_rays(FlatTerrain(), np.array([0.0, 0.0, 0.4]), down, 2.0).round(3)
    array([0.4, 0.5, inf])
    """
    marks = reach * np.linspace(0.0, 1.0, MARCH + 1)
    along = origin + marks[:, None, None] * directions
    # The first mark below the ground brackets the hit; what is thinner than a stride of the march is missed.
    below = along[..., 2] < terrain.height(along[..., :2])
    hit = below.any(axis=0)
    first = np.argmax(below, axis=0)
    high = marks[first]
    low = marks[np.maximum(first - 1, 0)]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        at = origin + middle[:, None] * directions
        under = at[:, 2] < terrain.height(at[:, :2])
        low, high = np.where(under, low, middle), np.where(under, middle, high)
    return np.where(hit, 0.5 * (low + high), np.inf)
