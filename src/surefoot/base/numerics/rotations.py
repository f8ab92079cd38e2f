"""Rotations in compiled code; `surefoot.base.spatial` has what is not called a thousand times a second."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel


@inline_kernel
def rotation_of(q: FloatArray, out: FloatArray) -> None:
    """Fill out (3, 3) with the rotation of the quaternion q[3:7] of a configuration (nq,), of any length."""
    x, y, z, w = q[3], q[4], q[5], q[6]
    # over the square of the length: an integrated quaternion need not be of length one
    s = 2.0 / (x * x + y * y + z * z + w * w)
    out[0, 0], out[0, 1], out[0, 2] = 1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)
    out[1, 0], out[1, 1], out[1, 2] = s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)
    out[2, 0], out[2, 1], out[2, 2] = s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)


@inline_kernel
def rotation_about(axis: FloatArray, c: float, s: float, out: FloatArray) -> None:
    """Fill out (3, 3) with the turn about a unit axis (3,) by the angle of cosine c, sine s (Rodrigues)."""
    for j in range(3):
        for k in range(3):
            out[j, k] = (1.0 - c) * axis[j] * axis[k] + (c if j == k else 0.0)
    out[0, 1] -= s * axis[2]
    out[0, 2] += s * axis[1]
    out[1, 0] += s * axis[2]
    out[1, 2] -= s * axis[0]
    out[2, 0] -= s * axis[1]
    out[2, 1] += s * axis[0]


@inline_kernel
def turn_between(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Fill out (3,) with the rotation vector of R_aᵀ R_b, of length at most pi, from quaternions (4,)."""
    x = a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1]
    y = a[3] * b[1] - a[1] * b[3] - a[2] * b[0] + a[0] * b[2]
    z = a[3] * b[2] - a[2] * b[3] - a[0] * b[1] + a[1] * b[0]
    w = a[3] * b[3] + a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    # q and -q are one rotation: the one with w >= 0 turns by at most pi
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.sqrt(x * x + y * y + z * z)
    # atan2 keeps its digits near both ends, where an arc cosine loses them
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0 / w
    out[0], out[1], out[2] = scale * x, scale * y, scale * z


@inline_kernel
def log_between(A: FloatArray, B: FloatArray, out: FloatArray) -> None:
    """Fill out (3,) with the rotation vector of A Bᵀ, rotations (3, 3), of length at most pi [rad]."""
    x = y = z = trace = 0.0
    for k in range(3):
        trace += A[0, k] * B[0, k] + A[1, k] * B[1, k] + A[2, k] * B[2, k]
        # A Bᵀ without forming it: its skew part is sin axis, its trace 1 + 2 cos
        x += 0.5 * (A[2, k] * B[1, k] - A[1, k] * B[2, k])
        y += 0.5 * (A[0, k] * B[2, k] - A[2, k] * B[0, k])
        z += 0.5 * (A[1, k] * B[0, k] - A[0, k] * B[1, k])
    sine, cosine = math.sqrt(x * x + y * y + z * z), 0.5 * (trace - 1.0)
    if sine > 1e-9:
        scale = math.atan2(sine, cosine) / sine
        out[0], out[1], out[2] = scale * x, scale * y, scale * z
    elif cosine > 0.0:
        out[0], out[1], out[2] = x, y, z
    else:  # half a turn: any of the two axes will do; A Bᵀ + 1 = 2 axis axisᵀ
        best, column = -1.0, 0
        for c in range(3):
            d = 1.0 + A[c, 0] * B[c, 0] + A[c, 1] * B[c, 1] + A[c, 2] * B[c, 2]
            if d > best:
                best, column = d, c
        for r in range(3):
            d = A[r, 0] * B[column, 0] + A[r, 1] * B[column, 1] + A[r, 2] * B[column, 2]
            out[r] = math.pi * (d + (1.0 if r == column else 0.0)) / math.sqrt(2.0 * best)
