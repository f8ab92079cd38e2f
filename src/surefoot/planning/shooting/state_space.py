"""Differences of states, and their inverse, compiled: a free flyer's place and rotation, and vectors.

A tangent of a configuration is (position in body axes, rotation vector in body axes, joints): the same to
first order as Pinocchio's. Quaternions are (x, y, z, w).
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.numerics.rotations import rotation_of


@inline_kernel
def turn_between(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Fill out (3,) with the rotation vector of R_aᵀ R_b, of length at most pi, from quaternions at [3:7]."""
    x = a[6] * b[3] - a[3] * b[6] - a[4] * b[5] + a[5] * b[4]
    y = a[6] * b[4] - a[4] * b[6] - a[5] * b[3] + a[3] * b[5]
    z = a[6] * b[5] - a[5] * b[6] - a[3] * b[4] + a[4] * b[3]
    w = a[6] * b[6] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0 / w
    out[0], out[1], out[2] = scale * x, scale * y, scale * z


@kernel
def difference(floating: bool, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Fill out (nv,) with the tangent at the configuration a (nq,) that leads to b (nq,)."""
    shift = 1 if floating else 0
    if floating:
        R = np.empty((3, 3))
        rotation_of(a, R)
        for i in range(3):
            out[i] = 0.0
            for j in range(3):
                out[i] += R[j, i] * (b[j] - a[j])
        turn_between(a, b, out[3:6])
    for i in range(6 if floating else 0, out.size):
        out[i] = b[i + shift] - a[i + shift]


@kernel
def retract(floating: bool, a: FloatArray, tangent: FloatArray, out: FloatArray) -> None:
    """Fill out (nq,) with the configuration to which a tangent (nv,) at a (nq,) leads."""
    shift = 1 if floating else 0
    if floating:
        R = np.empty((3, 3))
        rotation_of(a, R)
        for i in range(3):
            out[i] = a[i]
            for j in range(3):
                out[i] += R[i, j] * tangent[j]
        x, y, z = tangent[3], tangent[4], tangent[5]
        angle = math.sqrt(x * x + y * y + z * z)
        s = math.sin(0.5 * angle) / angle if angle > 1e-12 else 0.5
        x, y, z, w = s * x, s * y, s * z, math.cos(0.5 * angle)
        out[3] = a[6] * x + a[3] * w + a[4] * z - a[5] * y
        out[4] = a[6] * y + a[4] * w + a[5] * x - a[3] * z
        out[5] = a[6] * z + a[5] * w + a[3] * y - a[4] * x
        out[6] = a[6] * w - a[3] * x - a[4] * y - a[5] * z
        size = 1.0 / math.sqrt(out[3] ** 2 + out[4] ** 2 + out[5] ** 2 + out[6] ** 2)
        for i in range(3, 7):
            out[i] *= size
    for i in range(6 if floating else 0, tangent.size):
        out[i + shift] = a[i + shift] + tangent[i]


@kernel
def feedback(
    floating: bool, here: tuple[FloatArray, FloatArray], nominal: tuple[FloatArray, FloatArray],
    torques: FloatArray, step: FloatArray, share: float, gains: FloatArray, limits: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (m,) with torques + share step + K (x ⊖ x_nominal), within the limits (2, m).

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    here, nominal
        (nq,) and (nv,) of the state and of the one that the torques belong to.
    torques, step
        (m,) [N m].
    share
        Of the step.
    gains
        K (m, 2nv).
    limits
        Lower and upper bounds (2, m) [N m].
    out
        (m,) to be filled.
    """
    n = here[1].size
    off = np.empty(2 * n)
    difference(floating, nominal[0], here[0], off[:n])
    for i in range(n):
        off[n + i] = here[1][i] - nominal[1][i]
    for i in range(out.size):
        total = torques[i] + share * step[i]
        for j in range(2 * n):
            total += gains[i, j] * off[j]
        out[i] = min(max(total, limits[0, i]), limits[1, i])


@kernel
def defect(
    floating: bool, start: tuple[FloatArray, FloatArray], end: tuple[FloatArray, FloatArray], out: FloatArray
) -> float:
    """Fill out (2nv,) with a state less another, as a tangent at the other, and return its 1-norm.

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    start, end
        (nq,) and (nv,) of where a knot starts, and of where the knot before it ended.
    out
        (2nv,) to be filled.
    """
    n, total = start[1].size, 0.0
    difference(floating, start[0], end[0], out[:n])
    for i in range(n):
        out[n + i] = end[1][i] - start[1][i]
    for i in range(2 * n):
        total += abs(out[i])
    return total
