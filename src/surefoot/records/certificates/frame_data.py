"""A motion as the arrays that its certificate is found from: bodies, points, motors, window and noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.windows import sliding_mean
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain, file_actuators
from surefoot.records.certificates.body_tree import (
    FREE,
    OTHER,
    TURNS_ON,
    BodyTree,
    body_places,
    body_tree,
)
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.certificates.contact_cones import PointArrays, Rules
from surefoot.records.certificates.frame_kernels import Answer, Model, solve_frames
from surefoot.records.certificates.point_kernels import point_centres, slide_speeds
from surefoot.records.certificates.torque_rows import MotorArrays
from surefoot.records.certificates.touching_points import TouchingPoints
from surefoot.records.certificates.window_kernels import MotionArrays, Window, fill_momenta, frame_weights
from surefoot.records.motions.motion import Motion


class Noise(NamedTuple):
    """White noise of a motion's data: of the needed wrench [m g] and of joint angles [rad]."""

    wrench: float
    joints: float


@dataclass(frozen=True, eq=False)
class FrameData:
    """All arrays of a motion with the rules that they are judged by, and the noise of the data.

    `motors_at` gives what the joints can give where the motion is played at another pace, and `paced_motors`
    keeps it.
    """

    model: Model
    noise: Noise
    motors_at: Callable[[float], MotorArrays]
    paced_motors: dict[float, MotorArrays] = field(default_factory=dict)

    @property
    def frames(self) -> IntArray:
        """(n,) the frames whose windows lie in the motion."""
        count, reach = len(self.model.motion.com), self.model.window.reach
        return np.arange(reach, max(count - reach, reach), dtype=np.int64)

    def solve(self, frames: IntArray, **rules: Any) -> Answer:
        """Return the answers of (n,) frames, under rules of which some may be others."""
        count, joints = len(self.model.motion.com), len(self.model.motion.joints)
        answer = Answer(
            np.full(count, np.nan),
            np.full(count, np.nan),
            np.full((count, 6), np.nan),
            np.zeros((count, joints)),
            np.full((count, 6), np.nan),
            np.zeros(count, dtype=np.int64),
            np.zeros(count, dtype=np.int64),
            np.full(count, np.nan),
            np.full(count, np.nan),
        )
        model = self.model._replace(rules=self.model.rules._replace(**rules))
        pace = rules.get("pace", 1.0)
        if pace != 1.0:
            if pace not in self.paced_motors:
                self.paced_motors[pace] = self.motors_at(pace)
            model = model._replace(motors=self.paced_motors[pace])
        solve_frames(model, frames, answer)
        return answer


def frame_data(
    robot: Robot, motion: Motion, points: TouchingPoints, sliding_mu: tuple[float, float],
    terrain: Terrain | None, window: float | None, settings: CertificateSettings,
) -> FrameData:  # fmt: skip
    """Return the arrays of a motion; the window is chosen by its noise unless it is given [s]."""
    tree, step = body_tree(robot), 1.0 / motion.rate
    arrays = _motion_arrays(robot, tree, motion.q, step)
    rules = Rules(
        settings.clearance, settings.stick, 1.0, *sliding_mu, 1.0, True, float(tree.mass.sum()), settings.arm
    )
    chosen, noise = _window(arrays, rules, step, window, settings)
    kept = _point_arrays(points, arrays, terrain, step, chosen)
    rules = rules._replace(clearance=settings.clearance + standing_height(kept, settings))
    motors_at = partial(_motors, robot, arrays, step, noise, settings)
    model = Model(
        tree, arrays, kept, motors_at(1.0), _moves(tree, arrays.joints), chosen, frame_weights(chosen), rules
    )
    return FrameData(model, noise, motors_at)


def _motion_arrays(robot: Robot, tree: BodyTree, q: FloatArray, step: float) -> MotionArrays:
    """Return places and momenta of all bodies."""
    turns, origins = body_places(robot, tree, q)
    count, bodies = turns.shape[:2]
    joints = np.flatnonzero((tree.kind != FREE) & (tree.kind != OTHER))
    first = tree.first_q[joints]
    on = tree.kind[joints] == TURNS_ON
    angles = q[:, first].copy()
    angles[:, on] = np.unwrap(np.arctan2(q[:, first[on] + 1], q[:, first[on]]), axis=0)
    motion = MotionArrays(
        turns, origins, np.empty((count, bodies, 3)), np.empty((count - 1, bodies, 6)),
        np.empty((count - 1, bodies, 3)), np.empty((count, 3)), joints, angles,
    )  # fmt: skip
    fill_momenta(tree, step, motion)
    return motion


def deviation(increments: FloatArray) -> FloatArray:
    """Return the white noise (n,) of the sums of (T, n) increments, by the median of their third differences.

    A sum's fourth difference, whose noise has 70 times its variance, hardly knows of what a robot can do
    between frames; of fewer than five increments nothing is known, and it is zero.
    """
    if len(increments) < 5:
        return np.zeros(increments.shape[1])
    return np.asarray(1.4826 * np.median(np.abs(np.diff(increments, 3, axis=0)), axis=0) / np.sqrt(70.0))


def wrench_noise(motion: MotionArrays, rules: Rules, step: float) -> FloatArray:
    """Return the noise (6,) of the integral of the momentum [over m g, and over `arm` m g; s²]."""
    total = motion.momenta.sum(axis=1)
    middle = 0.5 * (motion.com[1:] + motion.com[:-1])
    total[:, 3:] -= np.cross(middle, total[:, :3])
    scale = rules.mass * GRAVITY * np.repeat([1.0, rules.arm], 3)
    return deviation(total * step / scale)


def _window(
    motion: MotionArrays, rules: Rules, step: float, given: float | None, settings: CertificateSettings
) -> tuple[Window, Noise]:
    """Return the window, the longer one where the data are noisy, and the noise that is left."""
    sigma = float(np.linalg.norm(wrench_noise(motion, rules, step)))
    joints = float(np.max(deviation(np.diff(motion.angles, axis=0)), initial=0.0))
    base = settings.window if given is None else given
    window = window_of(base, settings.mean, step)
    if given is None and left_noise(sigma, window) > settings.quiet:
        half = 0.5 * settings.long_window
        window = window_of(half, half, step)
    return window, Noise(left_noise(sigma, window), joints)


def left_noise(sigma: float, window: Window) -> float:
    """Return the deviation of the needed wrench by that of places [m g]: 2 sigma / (mean length)."""
    return 2.0 * sigma / (window.mean * window.length * window.step**2)


def window_of(length: float, mean: float, step: float) -> Window:
    """Return the window whose intervals are nearest to a length and a mean [s]."""
    n, m = max(round(length / step), 1), max(round(mean / step), 1)
    n += (n - m) % 2
    return Window(n, m, (n + m) // 2, step)


def _point_arrays(
    points: TouchingPoints, motion: MotionArrays, terrain: Terrain | None, step: float, window: Window
) -> PointArrays:
    """Return those points that come near the ground, and feet."""
    body = points.joints - 1
    centres = point_centres(motion.turns, motion.origins, body, points.places)
    if terrain is None:
        gaps, normals = centres[..., 2] - points.radii, np.array([[[0.0, 0.0, 1.0]]])
    else:
        gaps, normals = terrain.nearest(centres)
        gaps = gaps - points.radii
    near = np.flatnonzero((gaps.min(axis=0) < NEAR) | (points.foot >= 0))
    body, radii, centres = body[near], points.radii[near], np.ascontiguousarray(centres[:, near])
    normals = normals if terrain is None else np.ascontiguousarray(normals[:, near])
    slides = slide_speeds(centres, motion.rates, body, radii, normals, step)
    slides = sliding_mean(slides, window.mean) if window.mean > 1 else slides
    lowest = np.ascontiguousarray(centres - radii[:, None] * normals)
    return PointArrays(
        near, body, points.mu[near], lowest, np.ascontiguousarray(gaps[:, near]), normals, slides
    )


def standing_height(points: PointArrays, settings: CertificateSettings) -> float:
    """Return how high the resting points of a motion stand above the ground in the middle of it [m].

    Retargeted feet stand where another model had its ground: all of a motion is a centimetre too high. More
    than `CertificateSettings.stand` is a motion that hangs, and below the ground needs no allowance: then it
    is zero.
    """
    if not len(points.slides) or not points.slides.shape[1]:
        return 0.0
    rests = np.linalg.norm(points.slides, axis=2) <= settings.stick
    heights = np.where(rests, points.gaps[:-1], np.inf).min(axis=1)
    heights = heights[heights <= settings.clearance + settings.stand]
    middle = float(np.median(heights)) if len(heights) else 0.0
    return middle if 0.0 < middle <= settings.stand else 0.0


NEAR = 0.3
"""Points that never come nearer to the ground than this are left out [m]."""


def _motors(
    robot: Robot, motion: MotionArrays, step: float, noise: Noise, settings: CertificateSettings, pace: float
) -> MotorArrays:
    """Return what the joints can give at every frame: a stop any torque away from it, a motor its limit."""
    model, own = robot.model, file_actuators(robot)
    place = np.array([model.joints[int(b) + 1].idx_v for b in motion.joints], dtype=np.int64) - robot.base_dof
    angle = np.array([model.joints[int(b) + 1].idx_q for b in motion.joints], dtype=np.int64)
    single = np.array([model.joints[int(b) + 1].nq == 1 for b in motion.joints], dtype=np.bool_)
    limit, fastest = robot.effort_limits[place], robot.speed_limits[place] * settings.overspeed
    low, high = np.tile(-limit, (len(motion.com), 1)), np.tile(limit, (len(motion.com), 1))
    near = settings.at_stop + settings.sigmas * noise.joints
    least = np.where(single, model.lowerPositionLimit[angle], -np.inf)
    most = np.where(single, model.upperPositionLimit[angle], np.inf)
    speed = pace * np.gradient(motion.angles, step, axis=0) if len(motion.com) > 1 else np.zeros_like(low)
    high[speed > fastest] = 0.0
    low[speed < -fastest] = 0.0
    low[motion.angles >= most - near] = -np.inf
    high[motion.angles <= least + near] = np.inf
    return MotorArrays(low, high, own.armature[place])


def _moves(tree: BodyTree, joints: IntArray) -> BoolArray:
    """Return which joints move which bodies: (j, b)."""
    bodies = len(tree.parent)
    above = np.eye(bodies, dtype=np.bool_)
    for b in range(bodies):
        if tree.parent[b] >= 0:
            above[b] |= above[tree.parent[b]]
    return np.ascontiguousarray(above[:, joints].T)
