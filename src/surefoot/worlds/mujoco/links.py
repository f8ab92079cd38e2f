"""A robot's links as MuJoCo's geoms, and what touches beside its feet: links on ground, and on links."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import quaternion_from_rotation, quaternion_wxyz, rotation_from_quaternion
from surefoot.mechanics import Box, Capsule, Geometry, Robot, Shape
from surefoot.worlds.mujoco.readings import SAME_FACE, toward
from surefoot.worlds.mujoco.spec import TOUCHING

LINK, FOOT = "link:", "foot:"


@kernel
def feet_on_ground(
    pairs: IntArray, contact_frames: FloatArray, owner: IntArray, frames: FloatArray, rows: IntArray
) -> None:
    """Set the rows (c,) of all contacts but those of a foot and the ground to -1.

    Parameters
    ----------
    pairs, contact_frames
        (c, 2) geoms, (c, 9) frames.
    owner
        (geoms,) see `owners`.
    frames
        (p, 3, 3) frames of the feet's spheres: contacts that face another way are no foot's; or none.
    rows
        (c,) first constraint row of each contact; changed.
    """
    for c in range(len(rows)):
        first, second = owner[pairs[c, 0]], owner[pairs[c, 1]]
        k, sign = max(first, second), (1.0 if second >= 0 else -1.0)
        # Owners are numbers of spheres, -1 for the ground: the lesser is -1 and the larger a sphere for such
        # a contact.
        foot = min(first, second) == -1 and k >= 0
        if not foot or (len(frames) and toward(contact_frames[c], sign, frames[k, :, 2]) < SAME_FACE):
            rows[c] = -1


@kernel
def other_rows(
    types: IntArray, ids: IntArray, forces: FloatArray, first: IntArray, on_ground: IntArray,
    touch: int, stop: int,
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
    touch, stop
        The first type of a contact, and which joints at their stops.
    """
    out = np.empty(len(types), dtype=np.int64)
    count = 0
    for r in range(len(types)):
        taken = types[r] == stop
        if types[r] >= touch:
            c = ids[r]
            # A contact's first row is its normal: one that does not press gives nothing in its other rows
            # either.
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
            **TOUCHING,
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
        self._touch = int(kinds.mjCNSTR_CONTACT_FRICTIONLESS)  # and all kinds after it
        self._stop = int(kinds.mjCNSTR_LIMIT_JOINT)
        self._owner = owner
        self._still = np.zeros(self._nv)

    def _on_ground(self, data: Any, frames: FloatArray) -> IntArray:
        """Return the first constraint row of the contacts of feet on the ground (c,), -1 for all others."""
        rows = data.contact.efc_address.copy()
        feet_on_ground(data.contact.geom, data.contact.frame, self._owner, frames, rows)
        return np.asarray(rows)

    def force(self, data: Any, frames: FloatArray) -> FloatArray:
        """Return their generalised force and that of joints at their stops (nv,), in Pinocchio's axes.

        With the (p, 3, 3) `frames` of the feet's spheres: contacts of feet with another surface are others.
        """
        rows = other_rows(
            data.efc_type, data.efc_id, data.efc_force, data.contact.efc_address,
            self._on_ground(data, frames), self._touch, self._stop,
        )  # fmt: skip
        if not len(rows):
            return self._still.copy()
        jacobian = np.asarray(data.efc_J).reshape(-1, self._nv)
        return _in_base_axes(data, np.asarray(jacobian[rows].T @ data.efc_force[rows]))

    def names(self, data: Any, model: Any) -> list[tuple[str, str]]:
        """Return the names of what touches, pair by pair, without their kind."""
        first = np.asarray(data.contact.efc_address)
        others = np.flatnonzero((self._on_ground(data, np.empty((0, 3, 3))) < 0) & (first >= 0))
        pressed = others[data.efc_force[first[others]] > 0.0]
        return [(_title(model, a), _title(model, b)) for a, b in data.contact.geom[pressed].tolist()]


def generalised_force(
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
