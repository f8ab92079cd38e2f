"""A robot's links as MuJoCo's geoms, and what touches beside its feet: links on ground, and on links."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.collision import Geometry
from surefoot.collision.shapes import Box, Capsule, Shape
from surefoot.robot import Robot
from surefoot.spatial import quaternion_from_rotation, quaternion_wxyz, rotation_from_quaternion

LINK, FOOT = "link:", "foot:"


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


class LinkContacts:
    """Reads the contacts of a MuJoCo world that are not the feet's with the ground.

    Parameters
    ----------
    mujoco, model
        The module and the compiled model.
    feet, ground
        Geoms of the feet's spheres and of the ground.
    """

    def __init__(self, mujoco: Any, model: Any, feet: IntArray, ground: list[int]) -> None:
        self._nv = int(model.nv)
        kinds = mujoco.mjtConstraint
        self._kinds = [
            int(kinds.mjCNSTR_CONTACT_FRICTIONLESS),
            int(kinds.mjCNSTR_CONTACT_PYRAMIDAL),
            int(kinds.mjCNSTR_CONTACT_ELLIPTIC),
        ]
        self._stop = int(kinds.mjCNSTR_LIMIT_JOINT)
        self._foot, self._ground = np.zeros(model.ngeom, dtype=bool), np.zeros(model.ngeom, dtype=bool)
        self._foot[feet], self._ground[ground] = True, True

    def _feet_on_ground(self, pairs: IntArray) -> BoolArray:
        """Return which of the pairs (c, 2) of geoms are a foot and the ground."""
        if not len(pairs):
            return np.zeros(0, dtype=bool)
        return np.asarray((self._foot[pairs] & self._ground[pairs[:, ::-1]]).any(axis=1))

    def addresses(self, data: Any) -> IntArray:
        """Return the first constraint row of the contacts of feet on the ground (c,), -1 for all others."""
        contact = data.contact
        return np.where(self._feet_on_ground(contact.geom), contact.efc_address, -1).astype(np.int32)

    def others(self, data: Any) -> IntArray:
        """Return the indices (k,) of the contacts that carry a force and are no foot's on the ground."""
        contact = data.contact
        out = np.flatnonzero(~self._feet_on_ground(contact.geom) & (contact.efc_address >= 0))
        return np.asarray(out[data.efc_force[contact.efc_address[out]] > 0.0])

    def force(self, data: Any) -> FloatArray:
        """Return their generalised force and that of joints at their stops (nv,), in Pinocchio's axes."""
        rows = np.isin(data.efc_type, self._kinds) & np.isin(data.efc_id, self.others(data))
        rows |= data.efc_type == self._stop
        if not rows.any():
            return np.zeros(self._nv)
        jacobian = np.asarray(data.efc_J).reshape(-1, self._nv)
        out = np.asarray(jacobian[rows].T @ data.efc_force[rows])
        w, x, y, z = data.qpos[3:7].tolist()
        out[:3] = rotation_from_quaternion(np.array([x, y, z, w])).T @ out[:3]
        return out

    def names(self, data: Any, model: Any) -> list[tuple[str, str]]:
        """Return the names of what touches, pair by pair, without their kind."""
        pairs = data.contact.geom[self.others(data)].tolist()
        first, second = ([_title(model, pair[k]) for pair in pairs] for k in (0, 1))
        return list(zip(first, second, strict=True))


def _title(model: Any, geom: int) -> str:
    """Return what a geom is called without its kind; its body's name if it has none."""
    name = str(model.geom(geom).name).split(":", 1)[-1]
    return name or str(model.body(int(model.geom_bodyid[geom])).name)
