"""A robot's links as MuJoCo's geoms, and what touches beside its feet: links on ground, and on links."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.collision import Geometry
from surefoot.collision.shapes import Box, Capsule, Shape
from surefoot.kernels import kernel
from surefoot.robot import Robot
from surefoot.simulation.mujoco_contacts import SAME_FACE
from surefoot.spatial import quaternion_from_rotation, quaternion_wxyz, rotation_from_quaternion

LINK, FOOT = "link:", "foot:"


@kernel
def feet_on_ground(pairs: IntArray, role: IntArray, rows: IntArray) -> None:
    """Set the rows (c,) of all contacts but those of a foot and the ground to -1.

    Parameters
    ----------
    pairs
        (c, 2) geoms.
    role
        (geoms,) 1 for a foot, 2 for the ground, 0 for anything else.
    rows
        (c,) first constraint row of each contact; changed.
    """
    for c in range(len(rows)):
        if role[pairs[c, 0]] + role[pairs[c, 1]] != 3:
            rows[c] = -1


@kernel
def other_rows(
    types: IntArray, ids: IntArray, forces: FloatArray, first: IntArray, on_ground: IntArray,
    kinds: IntArray, stop: int,
) -> IntArray:  # fmt: skip
    """Return the constraint rows (k,) of joints at their stops and of contacts but the feet's on the ground.

    Parameters
    ----------
    types, ids, forces
        (rows,) kind, contact or joint, and force [N, N m] of every row.
    first
        (c,) first row of each contact, -1 for none.
    on_ground
        (c,) the same for the feet's on the ground, -1 for all others.
    kinds, stop
        Which types are contacts, and which joints at their stops.
    """
    out = np.empty(len(types), dtype=np.int64)
    count = 0
    for r in range(len(types)):
        taken = types[r] == stop
        for kind in kinds:
            if types[r] == kind:
                c = ids[r]
                taken = on_ground[c] < 0 and first[c] >= 0 and forces[first[c]] > 0.0
        if taken:
            out[count] = r
            count += 1
    return out[:count].copy()


def add_links(mujoco: Any, spec: Any, robot: Robot, geometry: Geometry, surface: dict[str, Any]) -> None:
    """Add the solids of a robot to its MjSpec as geoms ``link:NAME``, and the pairs that may touch.

    What stands on the ground as a foot is there already, as ``foot:NAME``. Links touch the ground as the feet
    do; pairs of links, and of feet with links, are those of `Geometry.pairs`, as in the rigid world.

    Parameters
    ----------
    mujoco, spec
        The module, and the robot's MjSpec, see `robot_spec`.
    robot, geometry
        Whose solids.
    surface
        Attributes `friction`, `solref`, `solimp` of the pairs, as of the ground.
    """
    joints = range(1, robot.model.njoints)
    bodies = {
        j: spec.body("base:0" if robot.floating and j == 1 else f"joint:{robot.model.names[j]}")
        for j in joints
    }
    names = []
    for solid in geometry.solids:
        names.append(f"{LINK if solid.on_ground else FOOT}{solid.name}")
        if not solid.on_ground:
            continue
        bodies[solid.joint].add_geom(
            name=names[-1],
            pos=solid.position,
            quat=quaternion_wxyz(quaternion_from_rotation(solid.rotation)),
            contype=0,
            conaffinity=1,
            condim=3,
            density=0.0,
            **_form(mujoco, solid.shape),
        )
    sliding = surface["friction"][0]
    for a, b in geometry.pairs().tolist():
        spec.add_pair(
            geomname1=names[a], geomname2=names[b], condim=3, friction=[sliding, sliding, 0.0, 0.0, 0.0],
            solref=surface["solref"], solimp=surface["solimp"],
        )  # fmt: skip


def _form(mujoco: Any, shape: Shape) -> dict[str, Any]:
    """Return MuJoCo's type and size of a sphere, box or capsule."""
    kinds = mujoco.mjtGeom
    if isinstance(shape, Box):
        return {"type": kinds.mjGEOM_BOX, "size": shape.core}
    if isinstance(shape, Capsule):
        return {"type": kinds.mjGEOM_CAPSULE, "size": [shape.radius, 0.5 * shape.length, 0.0]}
    return {"type": kinds.mjGEOM_SPHERE, "size": [shape.radius, 0.0, 0.0]}


def owners(count: int, feet: IntArray, ground: list[int]) -> IntArray:
    """Return for each geom (count,) the number of a foot's sphere, -1 for the ground, -2 for anything else.

    >>> owners(4, np.array([2, 1]), [3])
    array([-2,  1,  0, -1])
    """
    out = np.full(count, -2, dtype=np.int64)
    out[feet], out[ground] = np.arange(len(feet)), -1
    return out


class LinkContacts:
    """Reads the contacts of a MuJoCo world that are not the feet's with the ground.

    Parameters
    ----------
    mujoco, model
        The module and the compiled model.
    owner
        See `owners`.
    """

    def __init__(self, mujoco: Any, model: Any, owner: IntArray) -> None:
        self._nv = int(model.nv)
        kinds = mujoco.mjtConstraint
        contacts = (kinds.mjCNSTR_CONTACT_FRICTIONLESS, kinds.mjCNSTR_CONTACT_PYRAMIDAL)
        self._kinds = np.array([int(kind) for kind in (*contacts, kinds.mjCNSTR_CONTACT_ELLIPTIC)])
        self._stop = int(kinds.mjCNSTR_LIMIT_JOINT)
        self._owner = owner
        self._role = np.select([owner >= 0, owner == -1], [1, 2], 0)
        self._still = np.zeros(self._nv)

    def addresses(self, data: Any, frames: FloatArray | None = None) -> IntArray:
        """Return the first constraint row of the contacts of feet on the ground (c,), -1 for all others.

        With (p, 3, 3) `frames` those of feet with another surface than that of their frame are others, too.
        """
        contact = data.contact
        rows = contact.efc_address.copy()
        feet_on_ground(contact.geom, self._role, rows)
        if frames is None:
            return np.asarray(rows)
        for c in np.flatnonzero(rows >= 0).tolist():
            first, second = self._owner[contact.geom[c]].tolist()
            along = float(contact.frame[c, :3] @ frames[max(first, second), :, 2])
            if (along if second >= 0 else -along) < SAME_FACE:
                rows[c] = -1
        return np.asarray(rows)

    def others(self, data: Any) -> IntArray:
        """Return the indices (k,) of the contacts that carry a force and are no foot's on the ground."""
        contact = data.contact
        first = np.asarray(contact.efc_address)
        out = np.flatnonzero((self.addresses(data) < 0) & (first >= 0))
        return np.asarray(out[data.efc_force[first[out]] > 0.0])

    def force(self, data: Any, addresses: IntArray | None = None) -> FloatArray:
        """Return their generalised force and that of joints at their stops (nv,), in Pinocchio's axes.

        `addresses` are those of the method, if they are known.
        """
        contact = data.contact
        given = self.addresses(data) if addresses is None else addresses
        rows = other_rows(
            data.efc_type, data.efc_id, data.efc_force, contact.efc_address, given, self._kinds, self._stop
        )
        if not len(rows):
            return self._still.copy()
        jacobian = np.asarray(data.efc_J).reshape(-1, self._nv)
        return _in_base_axes(data, np.asarray(jacobian[rows].T @ data.efc_force[rows]))

    def names(self, data: Any, model: Any) -> list[tuple[str, str]]:
        """Return the names of what touches, pair by pair, without their kind."""
        pairs = data.contact.geom[self.others(data)].tolist()
        first, second = ([_title(model, pair[k]) for pair in pairs] for k in (0, 1))
        return list(zip(first, second, strict=True))


def generalised(
    mujoco: Any, model: Any, data: Any, bodies: IntArray, places: FloatArray, forces: FloatArray
) -> FloatArray:
    """Return the generalised force (nv,) of forces (p, 3) [N] at places (p, 3) of bodies, base axes."""
    out, jacobian = np.zeros(model.nv), np.zeros((3, model.nv))
    for body, place, force in zip(bodies.tolist(), places, forces, strict=True):
        if force.any():
            mujoco.mj_jac(model, data, jacobian, None, place, body)
            out += jacobian.T @ force
    return _in_base_axes(data, out)


def _in_base_axes(data: Any, force: FloatArray) -> FloatArray:
    """Turn the first three of MuJoCo's generalised force (nv,) into the base's axes, and return it."""
    w, x, y, z = data.qpos[3:7].tolist()
    force[:3] = rotation_from_quaternion(np.array([x, y, z, w])).T @ force[:3]
    return force


def _title(model: Any, geom: int) -> str:
    """Return what a geom is called without its kind; its body's name if it has none."""
    name = str(model.geom(geom).name).split(":", 1)[-1]
    return name or str(model.body(int(model.geom_bodyid[geom])).name)
