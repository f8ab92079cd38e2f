"""Robots from MJCF files: MuJoCo reads the file, and what it compiled is built again on Pinocchio.

MuJoCo is asked because defaults, includes, angles, references and inertias from shapes are its own language.
A body's joints are put one after the other at their anchors; `ref` turns into the place of the joint, so that
configurations are MuJoCo's own, but for the base's quaternion. Rotor inertia (armature), damping and
friction of joints are noted, and left out of the dynamics as for URDF files: joints are ideal torque sources
unless a world or a controller is given actuators (`rotors.joint_figures`). What would change
how the robot rests (closed chains, springs, tendons that pull) is not left out but refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError, needs
from surefoot.base.libraries import import_pinocchio
from surefoot.base.spatial import quaternion_xyzw, rotation_from_quaternion
from surefoot.mechanics.robot.mjcf_unsupported import beyond_a_tree, unreadable_mjcf
from surefoot.mechanics.robot.parser_output import parser_output

FREE_ENOUGH = 3
"""Joints of the first body without motors that stand for a free base: three of a robot in a plane [-]."""
POSES = ("home", "standing", "stand", "half_sitting")
"""Names of keyframes that are nominal poses, the first that the file has."""
_AXES = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}


@dataclass(frozen=True, eq=False)
class MjcfRobot:
    """What an MJCF file describes.

    Attributes
    ----------
    model, collision
        Pinocchio's Model and collision GeometryModel. Bodies are frames of the model; so are sites and named
        shapes, which the shapes of feet are read from.
    floating
        Whether the base is free.
    poses
        (nq,) of each keyframe.
    missing_meshes
        Files of meshes that are not there, by body.
    loose
        Joints of the first body that no actuator moves, in a file that has actuators.
    """

    model: Any
    collision: Any
    floating: bool
    poses: dict[str, FloatArray]
    missing_meshes: dict[str, list[str]] = field(default_factory=dict)
    loose: tuple[str, ...] = ()


def is_mjcf(path: Path) -> bool:
    """Return whether a file is MJCF by its first tag; False for what cannot be read."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            head = file.read(20000)
    except OSError:
        return False
    urdf, mjcf = head.find("<robot"), head.find("<mujoco")
    return mjcf >= 0 and (urdf < 0 or mjcf < urdf)


def read_mjcf(path: Path, fixed_base: bool | None) -> MjcfRobot:
    """Return the robot of an MJCF file.

    Parameters
    ----------
    path
        The file.
    fixed_base
        Whether the base is bolted to the world; None for what the file says, by its free joint.

    Raises
    ------
    MissingExtra
        If MuJoCo or Pinocchio is not installed.
    ModelError
        For a file that MuJoCo cannot read, or a robot that is not one tree of hinges and slides: closed
        chains, joints with springs, tendons that pull.
    """
    with needs("mujoco", "sim"):
        import mujoco
    from surefoot.mechanics.robot.mjcf_missing import compile_present

    pinocchio = import_pinocchio()
    with parser_output():
        try:
            compiled, missing = compile_present(mujoco, path)
        except (ValueError, OSError) as error:
            raise ModelError(unreadable_mjcf(path, error)) from error
    beyond = beyond_a_tree(mujoco, compiled)
    if beyond:
        raise ModelError(
            f"{path} is more than a tree of hinges and slides with motors, and would not move without it as "
            f"it does: {'; '.join(beyond)}. A copy of the file without it can be loaded"
        )
    return replace(_Builder(mujoco, pinocchio, compiled, fixed_base, path).build(), missing_meshes=missing)


def _root(compiled: Any, path: Path) -> int:
    """Return the body from which the robot's tree grows.

    Trees without any shape are left aside if another one has some: files of robots with fewer motors keep
    joints of the full robot's on bodies of their own, out of sight.
    """
    trees = [b for b in range(1, compiled.nbody) if compiled.body_parentid[b] == 0]
    moving = [b for b in trees if (compiled.body_treeid[compiled.body_rootid == b] >= 0).any()] or trees
    shaped = [b for b in moving if compiled.body_geomnum[compiled.body_rootid == b].any()]
    moving = shaped if len(shaped) == 1 else moving
    if len(moving) != 1:
        names = ", ".join(compiled.body(b).name or f"body {b}" for b in moving) or "none"
        raise ModelError(f"{path} must hold one robot, it has {len(moving)} that move: {names}")
    return moving[0]


def check_base(robot: MjcfRobot, path: Path) -> None:
    """Refuse a robot that would stand on feet and whose base hangs on joints without motors.

    Raises
    ------
    ModelError
        Where they would count as motors without limit that hold the robot in the air.
    """
    if len(robot.loose) >= FREE_ENOUGH and not robot.floating:
        raise ModelError(
            f"{path}: the base hangs on {len(robot.loose)} joints without motors, which stand for a free one "
            f"({', '.join(robot.loose)}). Put a <freejoint/> in their place, or load it with fixed_base=True"
        )


class _Builder:
    """Builds Pinocchio's model from MuJoCo's, body by body."""

    def __init__(
        self, mujoco: Any, pinocchio: Any, compiled: Any, fixed_base: bool | None, path: Path
    ) -> None:
        self.mujoco, self.pin, self.compiled, self.path = mujoco, pinocchio, compiled, path
        self.root = _root(compiled, path)
        first = int(compiled.body_jntadr[self.root])
        self.free = first if first >= 0 and self._is_free(first) else None
        self.floating = self.free is not None if fixed_base is None else not fixed_base
        self.model, self.collision = pinocchio.Model(), pinocchio.GeometryModel()
        self.model.name = path.stem
        self.model.gravity.linear = np.array(compiled.opt.gravity)
        self.place: dict[int, tuple[int, Any]] = {0: (0, pinocchio.SE3.Identity())}
        self.frame: dict[int, int] = {}
        self.source: list[int] = []  # MuJoCo's addresses of our joints' configurations
        self.joints: list[tuple[int, int]] = []  # our joints and MuJoCo's

    def build(self) -> MjcfRobot:
        """Return the robot."""
        compiled = self.compiled
        bodies = [b for b in range(1, compiled.nbody) if compiled.body_rootid[b] == self.root]
        for body in bodies:
            self._add(body)
        self._note_losses()
        for body in bodies:
            self._name(body)
        mass = float(self.pin.computeTotalMass(self.model))
        if self.floating and not 0.0 < mass < np.inf:
            raise ModelError(f"{self.path} describes no robot that can move: its total mass is {mass:g} kg")
        poses = {
            compiled.key(k).name: self._configuration(np.array(compiled.key_qpos[k]))
            for k in range(compiled.nkey)
        }
        return MjcfRobot(self.model, self.collision, self.floating, poses, loose=self._loose())

    def _loose(self) -> tuple[str, ...]:
        """Return the names of the first body's joints that no actuator moves."""
        c, first = self.compiled, int(self.compiled.body_jntadr[self.root])
        joints = range(first, first + int(c.body_jntnum[self.root]))
        moved = set(np.array(c.actuator_trnid)[:, 0].tolist())
        return tuple(c.joint(j).name or f"joint_{j}" for j in joints if c.nu and j not in moved)

    def _note_losses(self) -> None:
        """Note rotor inertia, damping and dry friction where ideal joints leave them out."""
        indices, joints = np.array(self.joints, dtype=np.int64).reshape(-1, 2).T
        ours, theirs = np.array(self.model.idx_vs)[indices], self.compiled.jnt_dofadr[joints]
        self.model.rotorInertia[ours] = self.compiled.dof_armature[theirs]
        self.model.damping[ours] = self.compiled.dof_damping[theirs]
        self.model.upperDryFrictionLimit[ours] = self.compiled.dof_frictionloss[theirs]

    def _configuration(self, qpos: FloatArray) -> FloatArray:
        """Return MuJoCo's configuration in our order."""
        base = np.zeros(0)
        if self.floating:
            base = np.array(self.pin.neutral(self.model))[:7]
            if self.free is not None:
                at = int(self.compiled.jnt_qposadr[self.free])
                base = np.concatenate([qpos[at : at + 3], quaternion_xyzw(qpos[at + 3 : at + 7])])
        return np.concatenate([base, qpos[self.source]])

    def _add(self, body: int) -> None:
        """Add a body with its joints, or weld it to its parent."""
        c, pin, model = self.compiled, self.pin, self.model
        parent, from_parent = self.place[int(c.body_parentid[body])]
        here = from_parent * self._pose(c.body_pos[body], c.body_quat[body])
        first, count = int(c.body_jntadr[body]), int(c.body_jntnum[body])
        joints = [j for j in range(first, first + count) if not self._is_free(j)]
        if body == self.root and self.floating:
            parent = model.addJoint(parent, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
            here = pin.SE3.Identity()
        for joint in joints:
            parent, here = self._joint(joint, parent, here)
        self.place[body] = parent, here
        if c.body_mass[body] > 0.0:
            inertia = pin.Inertia(float(c.body_mass[body]), np.zeros(3), np.diag(c.body_inertia[body]))
            middle = self._pose(c.body_ipos[body], c.body_iquat[body])
            model.appendBodyToJoint(parent, inertia.se3Action(middle), here)
        name = c.body(body).name or f"body_{body}"
        self.frame[body] = int(model.addBodyFrame(name, parent, here, 0))

    def _joint(self, joint: int, parent: int, here: Any) -> tuple[int, Any]:
        """Return the new joint and the place of its body in it."""
        c, pin = self.compiled, self.pin
        kinds = self.mujoco.mjtJoint
        kind, name = int(c.jnt_type[joint]), c.joint(joint).name or f"joint_{joint}"
        axis, anchor = np.array(c.jnt_axis[joint]), np.array(c.jnt_pos[joint])
        address = int(c.jnt_qposadr[joint])
        start = float(c.qpos0[address])
        if kind == int(kinds.mjJNT_HINGE):
            back, made = pin.SE3(pin.exp3(-start * axis), np.zeros(3)), self._along(axis, "R", "Revolute")
        elif kind == int(kinds.mjJNT_SLIDE):
            back, made = pin.SE3(np.eye(3), -start * axis), self._along(axis, "P", "Prismatic")
        else:
            raise ModelError(f"{self.path}: joint {name} is neither a hinge nor a slide")
        low, high = c.jnt_range[joint] if c.jnt_limited[joint] else (-np.inf, np.inf)
        effort, anchored = self._effort(joint), pin.SE3(np.eye(3), anchor)
        index = self.model.addJoint(
            parent, made, here * anchored * back, name, np.array([effort]), np.array([np.inf]),
            np.array([float(low)]), np.array([float(high)]),
        )  # fmt: skip
        self.source.append(address)
        self.joints.append((int(index), joint))
        return index, anchored.inverse()

    def _along(self, axis: FloatArray, short: str, long: str) -> Any:
        """Return the joint about or along an axis; the model of a coordinate axis is quicker."""
        letter = _AXES.get(tuple(axis.tolist()))
        if letter:
            return getattr(self.pin, f"JointModel{short}{letter}")()
        return getattr(self.pin, f"JointModel{long}Unaligned")(axis)

    def _effort(self, joint: int) -> float:
        """Return the largest torque of the actuators on a joint [N m]; infinite where nothing limits it."""
        c, total, found = self.compiled, 0.0, False
        kinds = self.mujoco.mjtTrn
        on_joints = np.isin(c.actuator_trntype, [int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT)])
        for k in np.flatnonzero(on_joints & (c.actuator_trnid[:, 0] == joint)).tolist():
            found = True
            limit = np.inf
            if c.actuator_forcelimited[k]:
                limit = float(np.abs(c.actuator_forcerange[k]).max())
            fixed = int(c.actuator_gaintype[k]) == 0 and int(c.actuator_biastype[k]) == 0
            if c.actuator_ctrllimited[k] and fixed:
                gain = abs(float(c.actuator_gainprm[k, 0]))
                limit = min(limit, gain * float(np.abs(c.actuator_ctrlrange[k]).max()))
            gear = abs(float(c.actuator_gear[k, 0]))
            total += gear * limit if gear > 0.0 else 0.0
        limit = total if found else np.inf
        if c.jnt_actfrclimited[joint]:
            limit = min(limit, float(np.abs(c.jnt_actfrcrange[joint]).max()))
        return limit

    def _name(self, body: int) -> None:
        """Add a body's sites and shapes; a named shape has a frame of its own, unless the name is taken."""
        c = self.compiled
        joint, here = self.place[body]
        for site in range(c.nsite):
            if int(c.site_bodyid[site]) == body and c.site(site).name:
                place = here * self._pose(c.site_pos[site], c.site_quat[site])
                self._frame(c.site(site).name, joint, place, self.frame[body])
        first = int(c.body_geomadr[body])
        for geom in range(first, first + int(c.body_geomnum[body])):
            if not self._collides(geom):
                continue
            place = here * self._pose(c.geom_pos[geom], c.geom_quat[geom])
            name = c.geom(geom).name
            frame = self._frame(name, joint, place, self.frame[body]) if name else None
            if frame is None:
                frame = self._site_at(body, place, geom)
            shape = self._shape(geom)
            if shape is not None:
                item = self.pin.GeometryObject(
                    name or f"geom_{geom}", joint, self.frame[body] if frame is None else frame, place, shape
                )
                self.collision.addGeometryObject(item)

    def _collides(self, geom: int) -> bool:
        """Return whether a shape can touch anything: by its bits, or by a pair of its own."""
        c = self.compiled
        paired = bool((c.pair_geom1 == geom).any() or (c.pair_geom2 == geom).any())
        return bool(c.geom_contype[geom] or c.geom_conaffinity[geom]) or paired

    def _frame(self, name: str, joint: int, place: Any, body: int) -> int | None:
        """Return a new frame fixed to a joint, of a body's frame; None if there is one of that name."""
        if self.model.existFrame(name):
            return None
        kind = self.pin.FrameType.OP_FRAME
        return int(self.model.addFrame(self.pin.Frame(name, joint, body, place, kind)))

    def _site_at(self, body: int, place: Any, geom: int) -> int | None:
        """Return the frame of a site in the middle of a shape without a frame: a foot's, most often."""
        c, reach = self.compiled, float(self.compiled.geom_size[geom, 0])
        if int(c.geom_type[geom]) == int(self.mujoco.mjtGeom.mjGEOM_MESH):
            return None  # it is the shape of the body, not of a place on it
        for site in range(c.nsite):
            if int(c.site_bodyid[site]) == body and c.site(site).name:
                frame = self.model.getFrameId(c.site(site).name)
                if np.linalg.norm(self.model.frames[frame].placement.translation - place.translation) < reach:
                    return int(frame)
        return None

    def _shape(self, geom: int) -> Any:
        """Return coal's shape; None for what it has none for here."""
        import coal

        kinds, size = self.mujoco.mjtGeom, np.array(self.compiled.geom_size[geom], dtype=np.float64)
        makers = {
            int(kinds.mjGEOM_SPHERE): lambda: coal.Sphere(size[0]),
            int(kinds.mjGEOM_CAPSULE): lambda: coal.Capsule(size[0], 2.0 * size[1]),
            int(kinds.mjGEOM_CYLINDER): lambda: coal.Cylinder(size[0], 2.0 * size[1]),
            int(kinds.mjGEOM_BOX): lambda: coal.Box(*(2.0 * size)),
            int(kinds.mjGEOM_ELLIPSOID): lambda: coal.Ellipsoid(*size),
            int(kinds.mjGEOM_MESH): lambda: self._mesh(coal, int(self.compiled.geom_dataid[geom])),
        }
        maker = makers.get(int(self.compiled.geom_type[geom]))
        return maker() if maker else None

    def _mesh(self, coal: Any, mesh: int) -> Any:
        """Return a mesh as its triangles, as readers of URDF files have it."""
        c = self.compiled
        first, faces = int(c.mesh_vertadr[mesh]), int(c.mesh_faceadr[mesh])
        vertices = np.array(c.mesh_vert[first : first + int(c.mesh_vertnum[mesh])], dtype=np.float64)
        triangles = np.array(c.mesh_face[faces : faces + int(c.mesh_facenum[mesh])], dtype=np.int64)
        shape = coal.BVHModelOBBRSS()
        shape.beginModel(len(triangles), len(vertices))
        shape.addVertices(vertices)
        shape.addTriangles(triangles)
        shape.endModel()
        return shape

    def _is_free(self, joint: int) -> bool:
        return int(self.compiled.jnt_type[joint]) == int(self.mujoco.mjtJoint.mjJNT_FREE)

    def _pose(self, place: FloatArray, wxyz: FloatArray) -> Any:
        rotation = rotation_from_quaternion(quaternion_xyzw(np.array(wxyz)))
        return self.pin.SE3(rotation, np.array(place, dtype=np.float64))


def nominal_of(poses: dict[str, FloatArray]) -> FloatArray | None:
    """Return the keyframe (nq,) [m, -, rad] that is a nominal pose, None if there is none."""
    return next((poses[name].copy() for name in POSES if name in poses), None)
