"""Velocities of points from twists, and the Jacobians that are made of them.

A twist is [linear velocity of the body's point at the world's origin; angular velocity], world axes, as the
columns of Pinocchio's `data.J` are.
"""

from __future__ import annotations

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import Three


@inline_kernel
def point_velocity(twists: FloatArray, j: int, x: float, y: float, z: float) -> Three:
    """Return v + ω x p for column j of the (6, m) twists and the point p = (x, y, z), world axes."""
    a, b, c = twists[3, j], twists[4, j], twists[5, j]
    return twists[0, j] + b * z - c * y, twists[1, j] + c * x - a * z, twists[2, j] + a * y - b * x


@kernel
def point_jacobian(twists: FloatArray, support: BoolArray, point: FloatArray, out: FloatArray) -> None:
    """Fill out (3, nv) with the Jacobian of a point's velocity, world axes.

    `twists` is (6, nv), `support` (nv,) says which columns move the point (3,).
    """
    x, y, z = point[0], point[1], point[2]
    for j in range(twists.shape[1]):
        if support[j]:
            out[0, j], out[1, j], out[2, j] = point_velocity(twists, j, x, y, z)
        else:
            out[0, j] = out[1, j] = out[2, j] = 0.0


@kernel
def contact_jacobian(
    twists: FloatArray, support: BoolArray, body: IntArray, points: FloatArray, frames: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (3p, nv) with the Jacobians of the contact points, rows in contact axes.

    `twists` is (6, nv), `support` (bodies, nv) says which columns move each body, `body` (p,) which body
    carries each point, `points` (p, 3) where they are and `frames` (p, 3, 3) their rotation_world_contact.
    """
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        R = frames[k]
        for j in range(out.shape[1]):
            if not support[body[k], j]:
                out[3 * k, j] = out[3 * k + 1, j] = out[3 * k + 2, j] = 0.0
                continue
            p, q, r = point_velocity(twists, j, x, y, z)
            for i in range(3):
                out[3 * k + i, j] = R[0, i] * p + R[1, i] * q + R[2, i] * r


@kernel
def relative_jacobian(
    twists: FloatArray, support: BoolArray, first: IntArray, second: IntArray, points: FloatArray,
    frames: FloatArray, on: BoolArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (3p, nv) with the Jacobians of a second body's velocity against a first, at contact points.

    As `contact_jacobian`, for the bodies `first` and `second` (p,) of each point; zeros where not `on` (p,).
    """
    for k in range(points.shape[0]):
        if not on[k]:
            for i in range(3):
                for j in range(out.shape[1]):
                    out[3 * k + i, j] = 0.0
            continue
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        R = frames[k]
        for j in range(out.shape[1]):
            # a joint that carries both bodies moves neither against the other
            sign = (1.0 if support[second[k], j] else 0.0) - (1.0 if support[first[k], j] else 0.0)
            if sign == 0.0:  # moved by neither, or both alike
                out[3 * k, j] = out[3 * k + 1, j] = out[3 * k + 2, j] = 0.0
                continue
            p, q, r = point_velocity(twists, j, x, y, z)
            for i in range(3):
                out[3 * k + i, j] = sign * (R[0, i] * p + R[1, i] * q + R[2, i] * r)
