"""Contacts of MuJoCo as rows of numbers: force, velocity and place on the robot, in contact axes."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics import frames_on
from surefoot.worlds.mujoco.record_capture import RawBlock

FIELDS = 19
WHERE = slice(3, 12)
GAP, MU, MOMENTS, TURN, CREEP = 12, 13, slice(14, 17), 17, 18
"""A contact as a row: force, velocity, position, normal (three each), gap, friction, moments (three), turn of
its friction pyramid, creep."""
CHANNELS: dict[str, Any] = {
    "forces": slice(0, 3), "contact_velocities": slice(3, 6), "contact_positions": slice(6, 9),
    "normals": slice(9, 12), "gaps": GAP, "contact_friction": MU,
}  # fmt: skip


class BodyVelocities(Protocol):
    """Velocities of all bodies at instants, as MuJoCo has them; see `Kinematics`."""

    cvel: FloatArray
    subtree_com: FloatArray


class ConstraintForces(Protocol):
    """Contacts, c of them with ``dim`` and ``friction``, and the forces (c,) of their constraints."""

    contacts: Any

    def constraint(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return the forces (c,) of every contact's constraint of a number, and more."""


class OuterContacts(NamedTuple):
    """Contacts of the robot with anything else, as they were copied: c of them.

    Attributes
    ----------
    which, row
        (c,) numbers of the contacts in their block, and rows that they belong to.
    pair
        (c, 2) geoms of the robot, and of what it touches.
    sign
        (c,) 1 where MuJoCo's normal points to the robot, else -1.
    axes
        (c, 3, 3) MuJoCo's axes, the normal first.
    force, moment
        (c, 3) on the robot, world axes [N, N m].
    place
        (c, 3) [m].
    """

    which: IntArray
    row: IntArray
    pair: IntArray
    sign: FloatArray
    axes: FloatArray
    force: FloatArray
    moment: FloatArray
    place: FloatArray


def contact_rows(model: Any, raw: RawBlock, at: BodyVelocities, outer: OuterContacts) -> FloatArray:
    """Return contacts as rows (c, 19), but for their creep."""
    contacts = raw.contacts[outer.which]
    normal = outer.sign[:, None] * outer.axes[:, 0]
    frames = frames_on(normal)
    velocity = relative_velocities(model, at, outer.row, outer.pair, outer.place)
    rows = np.zeros((len(outer.row), FIELDS))
    rows[:, :3] = np.einsum("cji,cj->ci", frames, outer.force)
    rows[:, 3:6] = np.einsum("cji,cj->ci", frames, velocity)
    rows[:, 6:9], rows[:, 9:12] = outer.place, normal
    rows[:, GAP] = contacts["dist"]
    rows[:, MU] = np.where(contacts["dim"] > 1, contacts["friction"][:, 0], 0.0)
    rows[:, MOMENTS] = np.einsum("cji,cj->ci", frames, outer.moment)
    along = np.einsum("cji,cj->ci", frames, outer.axes[:, 1])
    rows[:, TURN] = np.arctan2(along[:, 1], along[:, 0])
    return rows


def relative_velocities(
    model: Any, at: BodyVelocities, row: IntArray, pair: IntArray, place: FloatArray
) -> FloatArray:
    """Return the velocities of geoms' material at (c, 3) places over others', world axes: (c, 3) [m/s]."""
    moving = []
    for geom in pair.T:
        body = model.geom_bodyid[geom]
        turn, arm = at.cvel[row, body], place - at.subtree_com[row, model.body_rootid[body]]
        moving.append(turn[:, 3:] + np.cross(turn[:, :3], arm))
    return np.asarray(moving[0] - moving[1])


def decoded_forces(raw: ConstraintForces, pyramids: bool) -> FloatArray:
    """Return contact forces and moments (c, 6) in MuJoCo's contact axes, from its constraints' forces.

    A pyramid's are sums over its edges, n ± mu t each.
    """
    contacts = raw.contacts
    out, dim = np.zeros((len(contacts), 6)), contacts["dim"]
    edges = pyramids & (dim > 1)
    for k in range(int(dim.max(initial=0))):
        out[:, k] = np.where(~edges & (dim > k), raw.constraint(k)[0], 0.0)
    for k in range(int(dim.max(initial=1)) - 1 if pyramids else 0):
        one, two = raw.constraint(2 * k)[0], raw.constraint(2 * k + 1)[0]
        on = edges & (dim > k + 1)
        out[:, 0] += np.where(on, one + two, 0.0)
        out[:, k + 1] += np.where(on, (one - two) * contacts["friction"][:, k], 0.0)
    return out


def mean_rows(
    step: IntArray, slot: IntArray, rows: FloatArray, weight: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return what (c, 19) contacts were in whole steps: mean forces, gaps at the first touch of each."""
    keys, first, group = np.unique(np.stack([step, slot]), axis=1, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    mean, loads = rows[first].copy(), weight * np.linalg.norm(rows[:, :3], axis=1)
    total = np.bincount(group, loads, len(first))
    for part in (slice(0, 3), MOMENTS, slice(CREEP, CREEP + 1)):
        summed = np.zeros((len(first), part.stop - part.start))
        np.add.at(summed, group, weight[:, None] * rows[:, part])
        mean[:, part] = summed
    where = np.zeros((len(first), WHERE.stop - WHERE.start))
    np.add.at(where, group, loads[:, None] * rows[:, WHERE])
    on = total > 0.0  # where, and how fast, while it pushed: work and moments are those of the step
    mean[on, WHERE] = where[on] / total[on, None]
    mean[on, 9:12] /= np.linalg.norm(mean[on, 9:12], axis=1, keepdims=True)
    return keys[0], keys[1], mean
