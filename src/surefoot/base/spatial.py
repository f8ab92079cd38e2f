"""Rotations, wrenches and twists: the only home of sign and order conventions.

Wrench = [force; moment], twist = [linear; angular] (Pinocchio's order). Quaternions are (x, y, z, w)
with the Hamilton product. `X_from_y` style names read right to left: ``rotation_world_contact`` takes
contact coordinates to world coordinates. All functions accept leading batch axes unless they say
otherwise.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError

GRAVITY = 9.81
"""Standard acceleration of gravity [m/s^2]; it acts along -z of the world."""


def skew(vector: ArrayLike) -> FloatArray:
    """Return the matrix S with S @ b = vector x b.

    Parameters
    ----------
    vector
        (..., 3).

    Returns
    -------
    FloatArray
        (..., 3, 3), antisymmetric, in the unit of the vector.

    Examples
    --------
    >>> skew([1.0, 2.0, 3.0]) @ [0.0, 0.0, 1.0]
    array([ 2., -1.,  0.])
    """
    v = np.asarray(vector, dtype=np.float64)
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def unit(name: str, vector: ArrayLike, tolerance: float = 1e-6) -> FloatArray:
    """Return a (3,) vector of length one; refuse a length that is off by more than `tolerance`.

    Raises
    ------
    ProblemError
        If the vector is zero, not finite, or not unit within the tolerance.
    """
    v = finite_array(name, vector, (3,))
    length = float(np.linalg.norm(v))
    if abs(length - 1.0) > tolerance:
        raise ProblemError(f"{name} must have length 1, got length {length:g}")
    return v / length


def rotation_from_normal(normal: ArrayLike, heading: ArrayLike = (1.0, 0.0, 0.0)) -> FloatArray:
    """Return the contact frame of a surface: z along the normal, x along the heading in the surface.

    Parameters
    ----------
    normal
        (3,) unit normal out of the ground, world axes.
    heading
        (3,) direction that x follows after projection into the surface; where it is (almost) along
        the normal, the world axis least aligned with the normal takes its place.

    Returns
    -------
    FloatArray
        (3, 3) rotation_world_contact, right-handed.

    Examples
    --------
    >>> rotation_from_normal([0.0, 0.0, 1.0])
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    z = unit("normal", normal)
    h = finite_array("heading", heading, (3,))
    x = h - (h @ z) * z
    if np.linalg.norm(x) < 1e-6 * max(float(np.linalg.norm(h)), 1e-300):
        axis = np.eye(3)[int(np.argmin(np.abs(z)))]
        x = axis - (axis @ z) * z
    x = x / np.linalg.norm(x)
    y = np.cross(z, x)
    return np.column_stack([x, y, z]) + 0.0  # + 0.0 turns -0.0 into 0.0


def rotation_about(axis: ArrayLike, angle: float) -> FloatArray:
    """Return the rotation (3, 3) by `angle` [rad] about a unit axis (3,) (Rodrigues)."""
    s = skew(unit("axis", axis))
    return np.asarray(np.eye(3) + np.sin(angle) * s + (1.0 - np.cos(angle)) * (s @ s))


def rotation_exp(turn: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) by a rotation vector (3,) [rad]."""
    angle = float(np.linalg.norm(turn))
    return rotation_about(turn / angle, angle) if angle > 0.0 else np.eye(3)


def rotation_log(rotation: ArrayLike) -> FloatArray:
    """Return the rotation vector [rad] of a (3, 3) rotation, of length at most pi.

    The inverse of `rotation_exp`; near pi it goes through the quaternion, where
    the usual formula loses its digits.
    """
    x, y, z, w = quaternion_from_rotation(rotation)
    v = np.array([x, y, z])
    sine = float(np.linalg.norm(v))
    if sine < 1e-12:
        return 2.0 * v
    return np.asarray(v * (2.0 * np.arctan2(sine, w) / sine))


def quaternion_about(axis: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Return the quaternions (..., 4), x, y, z, w, of turns by angles (...) [rad] about a unit axis (3,).

    Sine and cosine of the half angle: it goes on beyond a full turn, which changes the sign.

    Examples
    --------
    >>> quaternion_about([0.0, 0.0, 1.0], [0.0, np.pi]).round(3)
    array([[0., 0., 0., 1.],
           [0., 0., 1., 0.]])
    """
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    along = np.sin(half) * np.asarray(axis, dtype=np.float64) + 0.0  # + 0.0 turns -0.0 into 0.0
    return np.concatenate([along, np.cos(half)], axis=-1)


def quaternion_from_rotation(rotation: ArrayLike) -> FloatArray:
    """Return the quaternion (x, y, z, w), w >= 0, of a (3, 3) rotation (Shepperd's method)."""
    R = finite_array("rotation", rotation, (3, 3))
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    k = int(np.argmax([R[0, 0], R[1, 1], R[2, 2], trace]))
    if k == 3:
        q = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1.0 + trace])
    else:
        i, j, m = k, (k + 1) % 3, (k + 2) % 3
        q = np.empty(4)
        q[i] = 1.0 + 2.0 * R[i, i] - trace
        q[j] = R[j, i] + R[i, j]
        q[m] = R[m, i] + R[i, m]
        q[3] = R[m, j] - R[j, m]
    q /= np.linalg.norm(q)
    return np.asarray(-q if q[3] < 0 else q)


def rotation_from_quaternion(quaternion: ArrayLike) -> FloatArray:
    """Return the (..., 3, 3) rotation of a quaternion (x, y, z, w); it is normalised first."""
    q = np.asarray(quaternion, dtype=np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    s = skew(q[..., :3])
    return np.asarray(np.eye(3) + 2.0 * q[..., 3, None, None] * s + 2.0 * (s @ s))


def base_velocity(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return the linear velocity (3,) of a floating base in world axes [m/s], by Pinocchio's q and v.

    >>> base_velocity(np.array([0.0, 0.0, 0.3, 0.0, 0.0, 1.0, 0.0]), np.array([0.5, 0.0, 0.1, 0.0, 0.0, 0.0]))
    array([-0.5,  0. ,  0.1])
    """
    return np.asarray(rotation_from_quaternion(q[3:7]) @ v[:3])


def heading_of(quaternion: FloatArray) -> FloatArray:
    """Return where the x axis of a body points along the level, (2,), for a unit quaternion x, y, z, w (4,).

    Examples
    --------
    >>> heading_of(np.array([0.0, 0.0, np.sin(0.25 * np.pi), np.cos(0.25 * np.pi)])).round(3) + 0.0
    array([0., 1.])
    """
    x, y, z, w = quaternion
    c, s = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w)
    return np.array([c, s]) / math.hypot(c, s)


def tilt_of(quaternion: FloatArray) -> float:
    """Return the angle [rad] between a body's z axis and the vertical, for a quaternion (4,) of any length.

    Examples
    --------
    >>> tilt_of(quaternion_about([1.0, 0.0, 0.0], 0.5))
    0.5
    """
    x, y, z, w = quaternion
    # Not the arc cosine of R_zz: that loses half of its digits near upright.
    return 2.0 * math.atan2(math.hypot(x, y), math.hypot(z, w))


def quaternion_xyzw(wxyz: ArrayLike) -> FloatArray:
    """Turn (..., 4) quaternions [-] from MuJoCo's order (w, x, y, z) into Pinocchio's (x, y, z, w)."""
    return np.roll(np.asarray(wxyz, dtype=np.float64), -1, axis=-1)


def quaternion_wxyz(xyzw: ArrayLike) -> FloatArray:
    """Turn (..., 4) quaternions [-] from Pinocchio's order (x, y, z, w) into MuJoCo's (w, x, y, z)."""
    return np.roll(np.asarray(xyzw, dtype=np.float64), 1, axis=-1)
