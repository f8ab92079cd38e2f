"""What may touch the ground about a frame of a motion, and the cones of its forces; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.records.certificates.window_kernels import MotionArrays, Window

MOST_ROWS = 24
"""Torque limits of one frame that may bind together."""


class PointArrays(NamedTuple):
    """The p points that may touch the ground, at T frames, world axes.

    Attributes
    ----------
    owner
        (p,) which of the robot's `TouchingPoints` each is.
    body
        (p,) the body that carries each.
    mu
        (p,) friction of what sticks [-].
    places
        (T, p, 3) the lowest places of the points [m].
    gaps
        (T, p) distance to the ground [m].
    normals
        (T, p, 3) of the ground there; (1, 1, 3) for level ground [-].
    slides
        (T - 1, p, 3) velocity along the ground between frames [m/s].
    """

    owner: IntArray
    body: IntArray
    mu: FloatArray
    places: FloatArray
    gaps: FloatArray
    normals: FloatArray
    slides: FloatArray


class Rules(NamedTuple):
    """What counts as a contact, and what it can give.

    Attributes
    ----------
    clearance
        Distance to the ground up to which a point may touch it [m].
    stick
        Speed up to which it may stick [m/s].
    mu_scale
        Factor on the friction of what sticks [-].
    sliding_low, sliding_high
        Friction of what slides [-].
    pace
        Factor on the speed of the motion [-].
    torques
        Whether limits on torques count.
    mass, arm
        Units: [kg], and [m] by which moments are divided.
    """

    clearance: float
    stick: float
    mu_scale: float
    sliding_low: float
    sliding_high: float
    pace: float
    torques: bool
    mass: float
    arm: float


class Touch(NamedTuple):
    """What may touch the ground in a window.

    Attributes
    ----------
    points, sliding
        Number of points, and of those that slide.
    slowest, lowest
        Speed of the slowest [m/s], and distance of the lowest point to the ground [m].
    """

    points: int
    sliding: int
    slowest: float
    lowest: float


class Contacts(NamedTuple):
    """The cones of one frame, with room for torque rows.

    Attributes
    ----------
    point
        (c,) index of each one's point.
    frames
        (c, 3, 3) axes of its forces, the third one the cone's [-].
    mu
        (c,) friction, 0 for a ray along the third axis [-].
    places
        (c, 3) from the centre of mass [m].
    maps
        (c, 3, d) from its forces to what is needed [-].
    """

    point: IntArray
    frames: FloatArray
    mu: FloatArray
    places: FloatArray
    maps: FloatArray


@kernel
def room_for(points: int) -> Contacts:
    """Return memory for the cones of so many points and for torque rows."""
    top = 6 * points + MOST_ROWS
    return Contacts(
        np.zeros(top, dtype=np.int64),
        np.zeros((top, 3, 3)),
        np.zeros(top),
        np.zeros((top, 3)),
        np.zeros((top, 3, 6 + MOST_ROWS)),
    )


@inline_kernel
def _frame_on(axis: FloatArray, out: FloatArray) -> None:
    """Fill a rotation (3, 3) whose third column is along (3,) axis."""
    size = np.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    x, y, z = axis[0] / size, axis[1] / size, axis[2] / size
    if abs(x) < 0.8:
        side = np.sqrt(y * y + z * z)
        out[0, 0], out[1, 0], out[2, 0] = 0.0, z / side, -y / side
    else:
        side = np.sqrt(x * x + z * z)
        out[0, 0], out[1, 0], out[2, 0] = z / side, 0.0, -x / side
    out[0, 2], out[1, 2], out[2, 2] = x, y, z
    a, b, c = out[0, 0], out[1, 0], out[2, 0]
    out[0, 1], out[1, 1], out[2, 1] = y * c - z * b, z * a - x * c, x * b - y * a


@inline_kernel
def _add(
    contacts: Contacts, count: int, point: int, mu: float, axis: FloatArray, place: FloatArray,
    com: FloatArray, arm: float,
) -> int:  # fmt: skip
    """Add a cone about an axis at a place; return the new count."""
    if count >= contacts.mu.shape[0]:
        return count
    contacts.point[count], contacts.mu[count] = point, mu
    _frame_on(axis, contacts.frames[count])
    for i in range(3):
        contacts.places[count, i] = place[i] - com[i]
    for a in range(3):
        f, p, row = contacts.frames[count, :, a], contacts.places[count], contacts.maps[count, a]
        row[0], row[1], row[2] = f[0], f[1], f[2]
        row[3] = (p[1] * f[2] - p[2] * f[1]) / arm
        row[4] = (p[2] * f[0] - p[0] * f[2]) / arm
        row[5] = (p[0] * f[1] - p[1] * f[0]) / arm
    return count + 1


@inline_kernel
def _touch(
    points: PointArrays, p: int, first: int, last: int, rules: Rules, place: FloatArray, which: IntArray
) -> tuple[int, float]:
    """Fill the mean place of a point while it may touch, and the first, middle and last such intervals.

    Returns
    -------
    Number of frames in which it may touch, and its least speed in the intervals beside them [m/s].
    """
    count, slowest = 0, np.inf
    place[:] = 0.0
    for s in range(first, last + 1):
        if points.gaps[s, p] <= rules.clearance:
            count += 1
            for i in range(3):
                place[i] += points.places[s, p, i]
    if count == 0:
        return 0, slowest
    place /= count
    found = 0
    for s in range(first, last):
        if points.gaps[s, p] <= rules.clearance or points.gaps[s + 1, p] <= rules.clearance:
            v = points.slides[s, p]
            slowest = min(slowest, np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2))
            which[0] = s if found == 0 else which[0]
            which[2] = s
            found += 1
    which[1] = (which[0] + which[2]) // 2
    return count, slowest


@kernel
def gather(
    motion: MotionArrays, points: PointArrays, window: Window, rules: Rules, k: int, contacts: Contacts
) -> tuple[int, Touch]:
    """Fill the cones of frame k.

    Returns
    -------
    Number of cones, and what touches.
    """
    first, last = k - window.reach, k + window.reach
    count, touching, sliding, slowest, lowest = 0, 0, 0, np.inf, np.inf
    place, axis, which = np.empty(3), np.empty(3), np.zeros(3, dtype=np.int64)
    level = points.normals.shape[0] == 1
    for p in range(points.body.shape[0]):
        for s in range(first, last + 1):
            lowest = min(lowest, points.gaps[s, p])
        seen, speed = _touch(points, p, first, last, rules, place, which)
        if seen == 0:
            continue
        touching += 1
        slowest = min(slowest, speed)
        normal = points.normals[0, 0] if level else points.normals[which[1], p]
        if speed <= rules.stick:
            count = _add(
                contacts, count, p, rules.mu_scale * points.mu[p], normal, place, motion.com[k], rules.arm
            )
            continue
        sliding += 1
        for n in range(3):
            s = which[n]
            if n > 0 and s == which[n - 1]:
                continue
            v = points.slides[s, p]
            size = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
            for mu in (rules.sliding_low, rules.sliding_high):
                for i in range(3):
                    axis[i] = normal[i] - mu * v[i] / size
                count = _add(contacts, count, p, 0.0, axis, place, motion.com[k], rules.arm)
    return count, Touch(touching, sliding, slowest, lowest)
