"""The laws that recorded tosses are judged by, frame by frame, and what noise may do to each.

Poses at even times t_k tell forces without a model of contact. With x the centre and g gravity,

    m (x_{k+1} - 2 x_k + x_{k-1}) / dt² - m g  =  ∫ w(t) f(t) dt,     w >= 0, a triangle over both frames,

is a weighted mean of the force. Coulomb's cone is convex and all corners touch one plane, so whatever pushes
and impacts there were, the mean lies in the cone as well; and it is zero where no corner can have touched.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.spatial.transform import Rotation

from surefoot.arrays import BoolArray, FloatArray
from surefoot.estimation.free_flight import ENOUGH, MARGIN, flying_frames
from surefoot.estimation.ground_plane import GroundPoints, corners
from surefoot.estimation.identify import Surroundings
from surefoot.estimation.tosses import Tosses

CHANCE = 0.01
"""Of a frame beyond noise, by one law, in a whole file of lawful tosses."""
FINEST = 1e-4
"""Noise, in sides and radians, below which a simulator's steps and its rounding are no less."""
WHITE = float(np.sqrt(6.0))
"""Standard deviation of a second difference of white noise of one."""
SAMPLES = 30
"""Second differences in free flight that tell their own noise."""


@dataclass(frozen=True)
class TossLaw:
    """One law over all frames: (N,) `value` fails where judged and above zero, beyond noise above `limit`."""

    name: str
    unit: str
    judged: BoolArray
    value: FloatArray
    limit: FloatArray
    jump: BoolArray

    @property
    def exact(self) -> BoolArray:
        """(N,) where it fails if the recording is taken as it is."""
        return np.asarray(self.judged & (self.value > 0.0))

    @property
    def beyond(self) -> BoolArray:
        """(N,) where it fails beyond noise."""
        return np.asarray(self.judged & (self.value > self.limit))


class TossMotion:
    """Corners, second differences of the poses, their noise, and where a corner may touch the ground.

    Attributes
    ----------
    tosses, found
        As given.
    normal
        (3,) of the ground.
    heights
        (N, 8) of sharp corners above the ground [m].
    position_noise, rotation_noise
        Standard deviations of a recorded coordinate [m] and angle [rad].
    push, twist
        (N, 3) second differences of place, less gravity's, and of the turn [m, rad]; zero at a toss's ends.
    push_noise, twist_noise
        Standard deviations of their coordinates.
    smoothing
        What push_noise is of white noise's.
    whole, near
        (N,) whether a frame has both neighbours, and whether a corner may have touched between them.
    """

    def __init__(self, tosses: Tosses, found: Surroundings) -> None:
        states, starts, dt = tosses.states, tosses.starts, tosses.dt
        self.tosses, self.found = tosses, found
        self.normal = found.plane.rotation.as_matrix()[:, 2]
        self.heights = found.plane.above(corners(tosses))
        self.position_noise = max(found.flight.position_noise, FINEST * tosses.cube.width)
        self.rotation_noise = max(found.flight.rotation_noise, FINEST)
        self.whole = np.ones(len(states), dtype=bool)
        self.whole[starts[:-1]] = self.whole[starts[1:] - 1] = False
        turns = Rotation.from_quat(states[:, 3:7])
        step = (turns[1:] * turns[:-1].inv()).as_rotvec()
        self.push, self.twist = np.zeros((2, len(states), 3))
        self.push[1:-1] = np.diff(states[:, :3], n=2, axis=0)
        self.push[:, 2] += found.gravity * dt * dt
        self.twist[1:-1] = np.diff(step, axis=0)
        self.push[~self.whole] = self.twist[~self.whole] = 0.0
        self.near = self._reach(self.heights, found.gravity * dt * dt, np.linalg.norm(step, axis=1))
        flying = np.zeros(len(states), dtype=bool)
        for first, frames in zip(starts, flying_frames(tosses, found.plane), strict=False):
            flying[first : first + max(int(frames) - 1, 0)] = frames >= ENOUGH
        flying &= self.whole & ~self.near
        white = WHITE * self.position_noise
        least = WHITE * FINEST
        self.push_noise = _noise(self.push[flying], white, least * tosses.cube.width)
        self.twist_noise = _noise(self.twist[flying], WHITE * self.rotation_noise, least)
        self.smoothing = self.push_noise / white

    def _reach(self, heights: FloatArray, fall: float, turned: FloatArray) -> BoolArray:
        """Return (N,) whether a corner may have touched between the frames before and after.

        What bounces between two frames was nearer to the ground than it moves from one to the next.
        """
        first = self.tosses.starts[:-1]
        moved = np.zeros_like(heights)
        moved[1:] = np.abs(np.diff(heights, axis=0))
        moved[first] = 0.0
        most, low = _around(moved, np.maximum, (-1, 1, 2)), _around(heights, np.minimum, (-1, 1))
        arm = np.sqrt(3.0) * self.tosses.cube.half_side
        spin = np.concatenate([turned, [0.0]]) ** 2 * arm
        slack = fall + _around(spin, np.maximum, (-1, 1)) + MARGIN * self.tosses.cube.width
        return np.asarray((low <= most + slack[:, None]).any(axis=1))


def _around(values: FloatArray, pick: Callable[..., FloatArray], shifts: tuple[int, ...]) -> FloatArray:
    """Return the largest or least of each row and its neighbours."""
    out = values
    for shift in shifts:
        out = pick(out, np.roll(values, shift, axis=0))
    return out


def _noise(samples: FloatArray, propagated: float, least: float) -> float:
    """Return the noise of a second difference: the free flight's own where it has enough of them.

    A recording that was smoothed has less of it than white noise has; the median is blind to fiducials lost.
    """
    if len(samples) < SAMPLES:
        return propagated
    own = np.sqrt(np.median(np.sum(samples**2, axis=1)) / stats.chi2.median(3))
    return max(float(own), least)


def _ground_variance(motion: TossMotion, points: GroundPoints) -> FloatArray:
    """Return (N,) how well the height of the ground is known under each centre [m²], by linear regression."""
    base = np.column_stack([np.ones(len(points.points)), points.points[:, :2]])[points.use]
    off = motion.found.plane.above(points.points[points.use])
    free = max(len(base) - 3, 1)
    # as wide as Student's
    wide = float(stats.t.isf(CHANCE, free) / stats.norm.isf(CHANCE))
    spread = np.linalg.pinv(base.T @ base) * (off @ off) / free * wide**2
    place = np.column_stack([np.ones(len(motion.heights)), motion.tosses.states[:, :2]])
    return np.asarray(np.einsum("ni,ij,nj->n", place, spread, place))


def penetration(motion: TossMotion, points: GroundPoints, rounding: float = 0.0) -> TossLaw:
    """Judge the depth of the deepest corner [m], `rounding` half sides round.

    Noise moves it and turns it about the centre, and the ground is known as well as `points` tell it.
    """
    tosses, found, side = motion.tosses, motion.found, motion.tosses.cube.half_side
    centre = found.plane.above(tosses.states[:, :3])[:, None]
    rise = motion.heights - centre
    # a sphere in each corner: its centre is nearer to the cube's, and its lowest point a radius below that
    heights = centre + (1.0 - rounding) * rise - rounding * side
    lever = np.sqrt(np.maximum(3.0 * side * side - rise**2, 0.0))
    ground = _ground_variance(motion, points)[:, None]
    noise = np.sqrt(motion.position_noise**2 + (motion.rotation_noise * lever) ** 2 + ground)
    limits = stats.norm.isf(CHANCE / heights.size) * noise
    worst = (-heights / limits).argmax(axis=1)
    rows, every = np.arange(len(heights)), np.ones(len(heights), dtype=bool)
    return TossLaw("penetration", "m", every, -heights[rows, worst], limits[rows, worst], ~every)


def free_motion(motion: TossMotion) -> Iterator[TossLaw]:
    """Judge force and moment where no corner is within reach."""
    judged = motion.whole & ~motion.near
    cube, dt = motion.tosses.cube, motion.tosses.dt
    many = max(int(judged.sum()), 1)
    for name, unit, second, noise, factor in (
        ("flight", "N", motion.push, motion.push_noise, cube.mass / dt**2),
        ("spin", "N m", motion.twist, motion.twist_noise, cube.inertia / dt**2),
    ):
        limit = stats.chi.isf(CHANCE / many, 3) * noise
        size = np.linalg.norm(second, axis=1)
        jump = _jumps(second, lambda x: np.linalg.norm(x, axis=1), limit)
        yield TossLaw(name, unit, judged, factor * size, np.full(len(size), factor * limit), jump)


def contact_cone(motion: TossMotion, mu: float) -> Iterator[TossLaw]:
    """Judge the mean force of two frames where a corner may touch: its distance from the cone of mu [-]."""
    judged, normal = motion.whole & motion.near, motion.normal
    limit = stats.chi.isf(CHANCE / max(int(judged.sum()), 1), 3) * motion.push_noise
    factor = motion.tosses.cube.mass / motion.tosses.dt**2

    def outside(push: FloatArray) -> FloatArray:
        up = push @ normal
        across = np.linalg.norm(push - up[:, None] * normal, axis=1)
        side = np.maximum(across - mu * up, 0.0) / np.sqrt(1.0 + mu * mu)
        return np.asarray(np.where(mu * across <= -up, np.hypot(across, up), side))

    value, jump = factor * outside(motion.push), _jumps(motion.push, outside, limit)
    pulls = motion.push @ normal < 0.0
    for name, which in (("pull", pulls), ("friction", ~pulls)):
        yield TossLaw(
            name, "N", judged, np.where(which, value, 0.0), np.full(len(value), factor * limit), jump
        )


def _jumps(second: FloatArray, outside: Callable[[FloatArray], FloatArray], limit: float) -> BoolArray:
    """Return (N,) whether one displaced frame explains a row: by e it adds e, -2 e, e to three rows."""
    before, after = np.roll(second, 1, axis=0), np.roll(second, -1, axis=0)
    here = (outside(before + 0.5 * second) <= limit) & (outside(after + 0.5 * second) <= limit)
    return np.asarray(here | np.roll(here, 1) | np.roll(here, -1))
