"""The arithmetic of sensors: what an IMU sees of a motion between two states."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel, window
from surefoot.base.spatial import GRAVITY


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
    """Fill mean turn rate (3,) [rad/s] and specific force (3,) [m/s²] of an IMU between two states (q, v).

    They are dt apart [s]; the IMU is at `arm` (3,) from the base's origin [m], in the base's axes half-way.
    """
    a, b, c, d = qa[3], qa[4], qa[5], qa[6]
    e, f, g, h = qb[3], qb[4], qb[5], qb[6]
    # the turn from one to the other in the first one's axes: conj(qa) qb
    x = d * e - a * h - b * g + c * f
    y = d * f - b * h - c * e + a * g
    z = d * g - c * h - a * f + b * e
    w = d * h + a * e + b * f + c * g
    # q and -q are one attitude: of the two turns between the states the shorter one.
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    # Mean turn rate: the rotation vector over dt, which is the same in the axes of both states and of all
    # between.
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
    # Mean specific force Rᵀ (Δv / dt - g) of the IMU's own place: the difference of velocities holds the
    # centripetal and Euler terms of its arm, and an impact's whole change whatever the step.
    _velocity(qa, va, arm, before)
    _velocity(qb, vb, arm, now)
    for r in range(3):
        now[r] = (now[r] - before[r]) / dt
    now[2] += GRAVITY
    _rotate(-i, -j, -k, m, now, force)


@inline_kernel
def _quantise(value: float, step: float) -> float:
    """Round to a multiple of a step; a step of zero changes nothing."""
    return value if step == 0.0 else step * np.rint(value / step)


@kernel
def sense(
    memory: FloatArray, motion: FloatArray, q: FloatArray, v: FloatArray, noise: FloatArray, first: bool,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill a row with what IMU and encoders say at a state (nq,) q, (nv,) v [m, rad], [m/s, rad/s].

    Gyro and accelerometer (3,) each, then angles and speeds of the joints (joints,) each.

    Parameters
    ----------
    memory
        Biases of gyro and accelerometer (2, 3) [rad/s], [m/s²], which walk; place of the IMU (3,) [m]; of
        both 2 scales of that walk, 2 of their noise, 2 steps and 2 ranges; noise and step of an angle [rad]
        and of a speed [rad/s]; dt [s]; the offsets of the angles (joints,) [rad], and zeros, those of the
        speeds.
    motion
        (13,) place, attitude and velocity of the base at the state before; those of this one afterwards.
    noise
        (12 + 2 joints,) standard normal numbers.
    first
        Whether there was no state before: the IMU is taken to be unaccelerated.
    """
    joints = v.shape[0] - 6
    biases, arm, figures = window(memory, 0, 2, 3), memory[6:9], memory[9:22]
    rate, force = np.empty(3), np.zeros(3)
    if first:
        rate[:], force[2] = v[3:6], GRAVITY
        _rotate(-q[3], -q[4], -q[5], q[6], force.copy(), force)
    else:
        mean_readings(motion[:7], motion[7:], q, v, figures[12], arm, rate, force)
    motion[:7], motion[7:] = q[:7], v[:6]
    for i in range(2):
        # a bias that walks, white noise, steps, and a range
        true = rate if i == 0 else force
        for r in range(3):
            biases[i, r] += figures[i] * noise[3 * i + r]
            value = true[r] + biases[i, r] + figures[2 + i] * noise[6 + 3 * i + r]
            out[3 * i + r] = min(max(_quantise(value, figures[4 + i]), -figures[6 + i]), figures[6 + i])
    offsets = memory[22:]
    for j in range(joints):
        angle = q[7 + j] + offsets[j] + figures[8] * noise[12 + j]
        speed = v[6 + j] + offsets[joints + j] + figures[10] * noise[12 + joints + j]
        out[6 + j], out[6 + joints + j] = _quantise(angle, figures[9]), _quantise(speed, figures[11])
