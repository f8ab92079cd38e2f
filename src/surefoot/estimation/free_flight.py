"""What the frames before the first touch say: how a toss begins, how noisy the recording is, and gravity.

Recorded velocities are differences of noisy poses. In free flight the true motion has twelve numbers (the
inertia of a cube is the same about every axis, so that it turns at a constant rate): they are fitted to all
frames before the first touch, by least squares, and a simulation starts from the fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.arrays import FloatArray, IntArray
from surefoot.estimation.ground_plane import GroundPlane, corners
from surefoot.estimation.tosses import Tosses
from surefoot.spatial import GRAVITY

MARGIN = 0.04
"""Height of the lowest corner above the ground that counts as flight, in sides."""
FEWEST, MOST = 4, 40
"""Frames that a fit needs, and those it takes."""
ENOUGH = 8
"""Frames from which a toss has a say in noise and gravity."""
TURNS = 4
"""Gauss-Newton steps of the rotation; the second is below the noise."""
SURE = 0.2
"""Standard error of gravity [m/s²] above which the standard value is taken."""


@dataclass(frozen=True)
class TossFlight:
    """The fit of the frames before the first touch.

    Attributes
    ----------
    starts
        (B, 13) first state of each toss: position, quaternion, velocity, angular velocity, all in world axes.
    frames
        (B,) frames that were used; 0 where there were too few and the recorded velocities serve.
    position_noise
        Standard deviation of a recorded coordinate [m]; 0 if no toss flies long enough.
    rotation_noise
        Of a recorded angle about an axis [rad].
    """

    starts: FloatArray
    frames: IntArray
    position_noise: float
    rotation_noise: float


def flying_frames(tosses: Tosses, plane: GroundPlane) -> IntArray:
    """Return (B,) the number of frames before a corner first comes close to the ground."""
    low = plane.above(corners(tosses)).min(axis=1)
    down = low < MARGIN * tosses.cube.width
    out = np.empty(len(tosses), dtype=np.int64)
    for k, (a, b) in enumerate(zip(tosses.starts[:-1], tosses.starts[1:], strict=True)):
        out[k] = int(np.argmax(down[a:b])) if down[a:b].any() else b - a
    return np.minimum(out, MOST)


def gravity_terms(tosses: Tosses, frames: IntArray) -> FloatArray:
    """Return (B, 2): the information that each toss has on its fall, and that times the acceleration.

    With position and velocity eliminated, acceleration along -z is a regression on what is left of t² / 2;
    the sums over tosses give the estimate, and sums over resampled tosses its bootstrap.
    """
    out = np.zeros((len(tosses), 2))
    for k in np.flatnonzero(frames >= ENOUGH):
        t = np.arange(frames[k]) * tosses.dt
        base = np.column_stack([np.ones(t.size), t])
        curve = 0.5 * t * t
        curve -= base @ np.linalg.lstsq(base, curve, rcond=None)[0]
        z = tosses.states[tosses.starts[k] : tosses.starts[k] + t.size, 2]
        out[k] = curve @ curve, -curve @ z
    return out


def gravity_of(terms: FloatArray, weights: FloatArray) -> FloatArray:
    """Return (S,) gravity [m/s²] for (S, B) weights of the tosses; the standard one where none flies."""
    information, moment = weights @ terms[:, 0], weights @ terms[:, 1]
    return np.where(information > 0.0, moment / np.maximum(information, 1e-300), GRAVITY)


def fit_free_flight(tosses: Tosses, frames: IntArray, gravity: float) -> TossFlight:
    """Fit the free flight of every toss, (B,) frames of each."""
    starts = np.empty((len(tosses), 13))
    used = np.where(frames >= FEWEST, frames, 0)
    variances = []
    for k, first in enumerate(tosses.starts[:-1]):
        if used[k] == 0:
            row = tosses.states[first]
            starts[k] = row
            starts[k, 10:] = Rotation.from_quat(row[3:7]).apply(row[10:])
            continue
        rows = tosses.states[first : first + used[k]]
        t = np.arange(used[k]) * tosses.dt
        starts[k], residuals = _fit(rows, t, gravity)
        if used[k] >= ENOUGH:
            variances.append(residuals / (3.0 * (int(used[k]) - 2)))
    # the median toss: a few tosses lose a fiducial for a frame
    noise = np.sqrt(np.median(variances, axis=0)) if variances else np.zeros(2)
    return TossFlight(starts, used, float(noise[0]), float(noise[1]))


def _fit(rows: FloatArray, t: FloatArray, gravity: float) -> tuple[FloatArray, FloatArray]:
    """Return the state at t = 0 and the sums of squared residuals of position and rotation."""
    base = np.column_stack([np.ones(t.size), t])
    lifted = rows[:, :3] + 0.5 * np.outer(t * t, [0.0, 0.0, gravity])
    linear, *_ = np.linalg.lstsq(base, lifted, rcond=None)
    turns = Rotation.from_quat(rows[:, 3:7])
    start = turns[0]
    rate = (turns[1:] * turns[:-1].inv()).as_rotvec().mean(axis=0) / (t[1] - t[0])
    for _ in range(TURNS):
        left = (turns * (Rotation.from_rotvec(np.outer(t, rate)) * start).inv()).as_rotvec()
        change, *_ = np.linalg.lstsq(base, left, rcond=None)
        start, rate = Rotation.from_rotvec(change[0]) * start, rate + change[1]
    left = (turns * (Rotation.from_rotvec(np.outer(t, rate)) * start).inv()).as_rotvec()
    state = np.concatenate([linear[0], start.as_quat(), linear[1], rate])
    return state, np.array([np.sum((lifted - base @ linear) ** 2), np.sum(left**2)])
