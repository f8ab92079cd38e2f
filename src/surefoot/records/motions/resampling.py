"""Configurations between frames, and velocities and accelerations at them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.libraries import import_pinocchio

if TYPE_CHECKING:
    from surefoot.mechanics import Robot


def blend_rows(rows: FloatArray, at: FloatArray) -> FloatArray:
    """Return (k, n) values at places (k,) between the rows (T, n), linearly."""
    before = np.minimum(at.astype(np.int64), max(len(rows) - 2, 0))
    share = (at - before)[:, None]
    after = np.minimum(before + 1, len(rows) - 1)
    return np.asarray((1.0 - share) * rows[before] + share * rows[after])


def blend_configurations(robot: Robot, q: FloatArray, at: FloatArray) -> FloatArray:
    """Return (k, nq) configurations at places (k,) between the frames (T, nq); rotations by slerp.

    Places are those of the frames, counted from 0 on; the base goes straight.
    """
    out = blend_rows(q, at)
    if robot.floating:
        before = np.minimum(at.astype(np.int64), max(len(q) - 2, 0))
        after = np.minimum(before + 1, len(q) - 1)
        out[:, 3:7] = slerp(q[before, 3:7], q[after, 3:7], at - before)
    return out


def slerp(first: FloatArray, second: FloatArray, share: FloatArray) -> FloatArray:
    """Return (k, 4) unit quaternions at shares (k,) of the shortest turn between unit quaternions (k, 4).

    Source: Shoemake, Animating Rotation with Quaternion Curves, SIGGRAPH 1985.
    """
    cosine = np.einsum("ki,ki->k", first, second)
    second = np.where(cosine[:, None] < 0.0, -second, second)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.sin(angle)
    small = sine < 1e-6  # there the chord is the arc to rounding
    safe = np.where(small, 1.0, sine)
    left = np.where(small, 1.0 - share, np.sin((1.0 - share) * angle) / safe)
    right = np.where(small, share, np.sin(share * angle) / safe)
    out = left[:, None] * first + right[:, None] * second
    return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


def differentiate(robot: Robot, q: FloatArray, rate: float, window: float) -> tuple[FloatArray, FloatArray]:
    """Return velocities and accelerations (T, nv) by parabolas over a window [s]; see `Motion.velocities`.

    Differences are taken from the middle frame of each window on the manifold; a parabola c0 + c1 t + c2 t²
    through them by least squares gives v = c1 and a = 2 c2 there. Base velocities are in base axes; their
    derivative is the spatial acceleration in base axes, to second order in the window.

    Raises
    ------
    ProblemError
        For fewer than three frames, or a window that is longer than the motion.
    """
    real_number("window", window, low=0.0)
    half = max(1, round(0.5 * window * rate))
    count = len(q)
    if count < 2 * half + 1:
        raise ProblemError(
            f"the motion has {count} frames, a window of {window:g} s at {rate:g} Hz needs {2 * half + 1}"
        )
    pinocchio = import_pinocchio()
    model, offsets = robot.model, np.arange(-half, half + 1)
    fit = np.linalg.pinv(np.vander(offsets / rate, 3, increasing=True))
    middles = np.arange(half, count - half)
    speed, bend = np.empty((count, model.nv)), np.empty((count, model.nv))
    away = np.empty((len(offsets), model.nv))
    for middle in middles:
        for k, offset in enumerate(offsets):
            away[k] = pinocchio.difference(model, q[middle], q[middle + offset])
        speed[middle], bend[middle] = fit[1] @ away, 2.0 * fit[2] @ away
    bend[:half], bend[count - half :] = bend[half], bend[count - half - 1]
    for k in range(half):  # where no whole window is around a frame, the next parabola goes on
        speed[k] = speed[half] - (half - k) / rate * bend[half]
        speed[count - 1 - k] = speed[count - 1 - half] + (half - k) / rate * bend[count - 1 - half]
    return speed, bend
