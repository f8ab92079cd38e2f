"""The arithmetic of sensors: what an IMU sees of a motion between two states."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.spatial import GRAVITY


@inline_kernel
def _rotate(x: float, y: float, z: float, w: float, u: FloatArray, out: FloatArray) -> None:
    """Fill out with the vector u (3,) turned by a quaternion of length 1: u + 2 w (r x u) + 2 r x (r x u)."""
    a, b, c = y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]
    out[0] = u[0] + 2.0 * (w * a + y * c - z * b)
    out[1] = u[1] + 2.0 * (w * b + z * a - x * c)
    out[2] = u[2] + 2.0 * (w * c + x * b - y * a)


@inline_kernel
def _velocity(q: FloatArray, v: FloatArray, arm: FloatArray, out: FloatArray) -> None:
    """Fill out with the world velocity of a point at `arm` (3,) in the base."""
    u = np.empty(3)
    u[0] = v[0] + v[4] * arm[2] - v[5] * arm[1]
    u[1] = v[1] + v[5] * arm[0] - v[3] * arm[2]
    u[2] = v[2] + v[3] * arm[1] - v[4] * arm[0]
    _rotate(q[3], q[4], q[5], q[6], u, out)


@kernel
def mean_readings(
    qa: FloatArray, va: FloatArray, qb: FloatArray, vb: FloatArray, dt: float, arm: FloatArray,
    rate: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    """Fill mean turn rate (3,) [rad/s] and specific force (3,) [m/s²] of an IMU; see `mean_motion`."""
    a, b, c, d = qa[3], qa[4], qa[5], qa[6]
    e, f, g, h = qb[3], qb[4], qb[5], qb[6]
    # the turn from one to the other in the first one's axes: conj(qa) qb
    x = d * e - a * h - b * g + c * f
    y = d * f - b * h - c * e + a * g
    z = d * g - c * h - a * f + b * e
    w = d * h + a * e + b * f + c * g
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    length = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(length, w)
    scale = angle / length if length > 1e-12 else 2.0
    rate[0], rate[1], rate[2] = scale * x / dt, scale * y / dt, scale * z / dt
    # the middle: half the turn after the first
    s = math.sin(0.25 * angle) / length if length > 1e-12 else 0.5
    x, y, z, w = s * x, s * y, s * z, math.cos(0.25 * angle)
    i = d * x + a * w + b * z - c * y
    j = d * y + b * w + c * x - a * z
    k = d * z + c * w + a * y - b * x
    m = d * w - a * x - b * y - c * z
    before, now = np.empty(3), np.empty(3)
    _velocity(qa, va, arm, before)
    _velocity(qb, vb, arm, now)
    for r in range(3):
        now[r] = (now[r] - before[r]) / dt
    now[2] += GRAVITY
    _rotate(-i, -j, -k, m, now, force)


@inline_kernel
def _stepped(value: float, step: float) -> float:
    """Round to a multiple of a step; a step of zero changes nothing."""
    return value if step == 0.0 else step * np.rint(value / step)


@kernel
def imu_reading(
    rate: FloatArray, force: FloatArray, biases: FloatArray, noise: FloatArray, scales: FloatArray,
    steps: FloatArray, ranges: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return what an IMU makes of its true motion, (3,) [rad/s] and (3,) [m/s²]; its biases walk.

    Parameters
    ----------
    rate, force
        (3,) [rad/s], (3,) [m/s²] true means.
    biases
        (2, 3) of both [rad/s], [m/s²]; changed.
    noise
        (4, 3) standard normal numbers: for the walks of the biases, then for the readings.
    scales
        (4,) that they are multiplied by.
    steps, ranges
        (2,) smallest difference and largest value of both.
    """
    gyro, accelerometer = np.empty(3), np.empty(3)
    for r in range(3):
        for i in range(2):
            biases[i, r] += scales[i] * noise[i, r]
            true = rate[r] if i == 0 else force[r]
            told = _stepped(true + biases[i, r] + scales[2 + i] * noise[2 + i, r], steps[i])
            told = min(max(told, -ranges[i]), ranges[i])
            if i == 0:
                gyro[r] = told
            else:
                accelerometer[r] = told
    return gyro, accelerometer


@kernel
def counted(
    true: FloatArray, offsets: FloatArray, scale: float, noise: FloatArray, step: float
) -> FloatArray:
    """Return what encoders make of (joints,) angles or speeds: off, noisy, in steps [rad] or [rad/s]."""
    out = np.empty(len(true))
    for j in range(len(true)):
        out[j] = _stepped(true[j] + offsets[j] + scale * noise[j], step)
    return out
