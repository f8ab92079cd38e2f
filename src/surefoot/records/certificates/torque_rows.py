"""Limits on torques as further dimensions of what a frame needs; compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.records.certificates.body_tree import BodyTree
from surefoot.records.certificates.contact_cones import Contacts, PointArrays
from surefoot.records.certificates.window_kernels import MotionArrays, Window, joint_line, on_joint


class MotorArrays(NamedTuple):
    """What j joints can give at T frames.

    Attributes
    ----------
    low, high
        (T, j) [N m, N].
    inertia
        (j,) of rotors [kg m²].
    """

    low: FloatArray
    high: FloatArray
    inertia: FloatArray


@kernel
def add_rotors(
    motion: MotionArrays, motors: MotorArrays, window: Window, pace: float, k: int, torques: FloatArray
) -> None:
    """Add to (j,) torques what speeds up the rotors about frame k [N m]."""
    first, last = k - window.reach, k + (window.length - window.mean) // 2
    n = window.mean
    for j in range(torques.shape[0]):
        change = motion.angles[last + n, j] - motion.angles[last, j]
        change -= motion.angles[first + n, j] - motion.angles[first, j]
        torques[j] += pace * pace * motors.inertia[j] * change / (n * window.length * window.step**2)


@inline_kernel
def take_forces(
    tree: BodyTree, motion: MotionArrays, k: int, points: PointArrays, contacts: Contacts, count: int,
    moves: BoolArray, forces: FloatArray, arm: float, torques: FloatArray,
) -> None:  # fmt: skip
    """Take from (j,) torques what (count, 3) forces do on the joints [over m g and `arm`]."""
    axis, place = np.empty(3), np.empty(3)
    for j in range(motion.joints.shape[0]):
        joint_line(tree, motion, j, k, axis, place)
        kind = tree.kind[motion.joints[j]]
        for c in range(count):
            if moves[j, points.body[contacts.point[c]]]:
                torques[j] -= _row(kind, axis, place, contacts, c, forces[c]) / arm


@inline_kernel
def _row(
    kind: int, axis: FloatArray, place: FloatArray, contacts: Contacts, c: int, force: FloatArray
) -> float:
    """Return what a force (3,) of a cone's axes does on a joint [m]."""
    wrench = np.empty(6)
    p = contacts.places[c]
    for i in range(3):
        wrench[i] = 0.0
        for a in range(3):
            wrench[i] += contacts.frames[c, i, a] * force[a]
    wrench[3] = p[1] * wrench[2] - p[2] * wrench[1]
    wrench[4] = p[2] * wrench[0] - p[0] * wrench[2]
    wrench[5] = p[0] * wrench[1] - p[1] * wrench[0]
    return on_joint(kind, axis, place, wrench)


@inline_kernel
def add_torque_row(
    tree: BodyTree, motion: MotionArrays, k: int, points: PointArrays, contacts: Contacts, count: int,
    moves: BoolArray, j: int, row: int, sign: float, arm: float,
) -> None:  # fmt: skip
    """Fill dimension 6 + row of the maps (c, 3, d) with joint j, behind the cones a ray of lesser ones."""
    axis, place, one = np.empty(3), np.empty(3), np.zeros(3)
    joint_line(tree, motion, j, k, axis, place)
    kind = tree.kind[motion.joints[j]]
    for c in range(count):
        for a in range(3):
            one[:] = 0.0
            one[a] = 1.0
            on = moves[j, points.body[contacts.point[c]]]
            contacts.maps[c, a, 6 + row] = _row(kind, axis, place, contacts, c, one) / arm if on else 0.0
    at = count + row
    contacts.mu[at] = 0.0
    for other in range(row + 1):
        contacts.maps[count + other, 2, 6 + row] = 0.0
        contacts.maps[at, 2, 6 + other] = 0.0
    for i in range(6):
        contacts.maps[at, 2, i] = 0.0
    contacts.maps[at, 2, 6 + row] = -sign
