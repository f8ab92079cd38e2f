"""Which of a MuJoCo model's bodies are the robot, and its state in Pinocchio's order."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ModelError, ProblemError, unknown_name
from surefoot.base.spatial import quaternion_xyzw, rotation_from_quaternion

_SIZES = {"free": (7, 6), "ball": (4, 3), "one": (1, 1)}
"""Positions and velocities of a joint."""
UNNAMED = "MuJoCo Model"
"""What MuJoCo calls a model without a name."""


class Posture(Protocol):
    """Where a tree's root was at n instants; see `Kinematics`."""

    xpos: FloatArray
    xmat: FloatArray
    com: FloatArray
    anchors: FloatArray


def _actuator_counts(mujoco: Any, model: Any) -> dict[int, int]:
    """Return how many actuators drive joints of each root: a sack on its back may weigh more than a robot."""
    out: dict[int, int] = {}
    joint = int(mujoco.mjtTrn.mjTRN_JOINT)
    for k in range(model.nu):
        if int(model.actuator_trntype[k]) != joint:
            continue
        body = int(model.jnt_bodyid[model.actuator_trnid[k, 0]])
        while model.body_weldid[model.body_parentid[body]] != 0:
            body = int(model.body_parentid[body])
        out[body] = out.get(body, 0) + 1
    return out


def _holds(model: Any, joint: int, dof: int) -> bool:
    """Return whether a slide or hinge does more than to let its body move."""
    held = model.jnt_stiffness[joint], model.dof_damping[dof], model.dof_frictionloss[dof]
    return bool(model.jnt_limited[joint]) or bool(np.any(held))


def _mount(model: Any, root: int) -> list[int]:
    """Return the bodies between a root and the world."""
    out, body = [], int(model.body_parentid[root])
    while body != 0:
        out.append(body)
        body = int(model.body_parentid[body])
    return out


class BodyTree:
    """A robot within a MuJoCo model: a body and all below it.

    Attributes
    ----------
    name, title
        Of its root body; of the model, where it names itself and nothing else moves in it, else the same.
    bodies, place
        Numbers of its bodies, and body to place among them.
    mount
        Numbers of the bodies that stand still and that its root hangs on: it can collide with them as with
        itself.
    mass
        Of all of them [kg].
    joint_names, joints
        Names and number of its hinges and slides.
    others
        Roots of the other bodies that move.
    joint_dofs, dofs
        Numbers of its hinges and slides, and of all its degrees of freedom in MuJoCo, in the log's order.
    other_places, other_dofs
        Places in MuJoCo's positions, and velocities, of what else moves in the model.
    base, unpowered
        Of those, its root's joints'; and which of them no hinge or slide of the log is: 1, else 0.
    free
        (k, 6) the wrenches, world axes about the centre of mass, against which nothing holds its root: all
        six of a free joint's, those along slides and about a last hinge of a root that moves in a plane. None
        for a root that is bolted to the world, or slides on rails that hold it: stops, springs, friction.
    """

    def __init__(self, mujoco: Any, model: Any, robot: str | None) -> None:
        moving = [b for b in range(1, model.nbody) if model.body_weldid[b] == b]
        roots = [b for b in moving if model.body_weldid[model.body_parentid[b]] == 0]
        # a body that a loop moves by hand (mocap) is no robot
        free = [b for b in roots if int(model.body_mocapid[b]) < 0]
        if not free:
            raise ModelError("nothing moves in this model")
        names = {b: str(model.body(b).name) or f"body {b}" for b in range(model.nbody)}
        if robot is None:
            driven = _actuator_counts(mujoco, model)
            root = max(free, key=lambda b: (driven.get(int(b), 0), float(model.body_subtreemass[b])))
        elif robot in names.values():
            root = next(b for b, name in names.items() if name == robot)
            if int(model.body_mocapid[root]) >= 0:
                raise ProblemError(f"{robot} is moved by hand (mocap): no robot of its own")
        else:
            raise ProblemError(unknown_name("body", robot, names.values()))
        self.name, self.root = names[root], root
        below = {root}
        for b in range(root + 1, model.nbody):  # parents come first
            if int(model.body_parentid[b]) in below:
                below.add(b)
        self.bodies = np.array(sorted(below))
        self.mount = _mount(model, root)
        self.place = {int(body): k for k, body in enumerate(self.bodies)}
        self.mass = float(model.body_subtreemass[root])
        self.others = [
            names[b]
            for b in roots
            if b not in below and int(model.body_rootid[b]) != int(model.body_rootid[root])
        ]
        model_name = bytes(model.names).split(b"\0", 1)[0].decode(errors="replace").removesuffix(" scene")
        named = model_name not in ("", UNNAMED) and robot is None and not self.others
        self.title = model_name if named else self.name
        known = {int(mujoco.mjtJoint.mjJNT_FREE): "free", int(mujoco.mjtJoint.mjJNT_BALL): "ball"}
        self._plan: list[tuple[str, int, int]] = []
        self.joint_names: list[str] = []
        self.joint_dofs: list[int] = []
        for j in range(model.njnt):
            if int(model.jnt_bodyid[j]) not in below:
                continue
            kind = known.get(int(model.jnt_type[j]), "one")
            self._plan.append((kind, int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])))
            if kind == "one":
                self.joint_names.append(str(model.joint(j).name) or f"joint {j}")
                self.joint_dofs.append(self._plan[-1][2])
        self.joints = len(self.joint_dofs)
        dofs = [dof + k for kind, _, dof in self._plan for k in range(_SIZES[kind][1])]
        self.dofs = np.array(dofs, dtype=np.int64)
        places = [at + k for kind, at, _ in self._plan for k in range(_SIZES[kind][0])]
        self.other_places = np.setdiff1d(np.arange(model.nq), places)
        self.other_dofs = np.setdiff1d(np.arange(model.nv), dofs)
        own = [j for j in range(model.njnt) if int(model.jnt_bodyid[j]) == root]
        self._roots = [(int(model.jnt_type[j]), j, int(model.jnt_dofadr[j])) for j in own]
        bodies = model.dof_bodyid[self.dofs]
        self.base = self.dofs[bodies == root]
        self.unpowered = np.array([0.0 if dof in self.joint_dofs else 1.0 for dof in self.base])
        self.free = self._free_wrenches(mujoco, model)

    def _free_wrenches(self, mujoco: Any, model: Any) -> FloatArray | None:
        """Return `free`; None as well for slides that are not perpendicular, or that come after a hinge."""
        kinds = mujoco.mjtJoint
        free, slide, hinge = int(kinds.mjJNT_FREE), int(kinds.mjJNT_SLIDE), int(kinds.mjJNT_HINGE)
        types = [kind for kind, _, _ in self._roots]
        if int(model.body_weldid[model.body_parentid[self.root]]) != 0:
            return None
        if types == [free]:
            return np.eye(6)
        slides = [slide] * types.count(slide)
        if not slides or (types != slides and types != [*slides, hinge]):
            return None
        if any(_holds(model, j, dof) for _, j, dof in self._roots):
            return None  # a rail with stops, springs or friction
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        out = np.zeros((len(types), 6))
        for row, (kind, j, _) in zip(out, self._roots, strict=True):
            row[3 * (kind == hinge) :][:3] = data.xaxis[j]
        return out if np.allclose(out @ out.T, np.eye(len(out)), atol=1e-9) else None

    def wrench(self, at: Posture, joints: FloatArray) -> FloatArray:
        """Return what forces (n, nv) on the root's joints are about the centre of mass: (n, 6) world axes."""
        out = np.zeros((len(joints), 6))
        if self.free is None:
            return out
        if len(self.free) == 6:
            dof = self._roots[0][2]
            out[:, :3] = joints[:, dof : dof + 3]
            turn = np.einsum("tij,tj->ti", at.xmat, joints[:, dof + 3 : dof + 6])
            out[:, 3:] = turn + np.cross(at.xpos - at.com, out[:, :3])
            return out
        for row, (_, j, dof) in zip(self.free, self._roots, strict=True):
            if row[:3].any():
                out[:, :3] += row[:3] * joints[:, dof, None]
            else:
                moment = np.cross(at.anchors[:, j] - at.com, out[:, :3]) @ row[3:]
                out[:, 3:] = row[3:] * (joints[:, dof] + moment)[:, None]
        return out

    def joint_forces(self, at: Posture, joints: FloatArray) -> FloatArray:
        """Return forces (n, nv) on MuJoCo's joints in the log's order and axes."""
        out, place = joints[:, self.dofs], 0
        for kind, _, _ in self._plan:
            if kind == "free":
                out[:, place : place + 3] = np.einsum("tji,tj->ti", at.xmat, out[:, place : place + 3])
            place += _SIZES[kind][1]
        return out

    def torques(self, actuators: FloatArray, applied: FloatArray) -> FloatArray:
        """Return what (n, nv) actuators and the user put on the hinges and slides: (n, joints) [N m, N]."""
        return np.asarray(actuators[:, self.joint_dofs] + applied[:, self.joint_dofs])

    def pushed_place(self, applied: FloatArray) -> IntArray:
        """Return the place of the body on which (n, nbody, 6) `xfrc_applied` puts the most; -1 for none."""
        size = np.abs(applied[:, self.bodies]).sum(axis=2)
        return np.where(size.any(axis=1), size.argmax(axis=1), -1)

    def pinocchio(self, qpos: FloatArray, qvel: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (T, nq), (T, nv) [m, -, rad]: quaternions x, y, z, w, free bodies' velocity in own axes."""
        q: list[FloatArray] = []
        v: list[FloatArray] = []
        for kind, at, dof in self._plan:
            if kind == "one":
                q.append(qpos[:, at : at + 1])
                v.append(qvel[:, dof : dof + 1])
                continue
            first = at + (3 if kind == "free" else 0)
            quaternion = quaternion_xyzw(qpos[:, first : first + 4])
            quaternion = quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)  # as MuJoCo reads it
            if kind == "free":
                R = rotation_from_quaternion(quaternion)
                q.append(qpos[:, at : at + 3])
                v.append(np.einsum("tji,tj->ti", R, qvel[:, dof : dof + 3]))
                dof += 3
            q.append(quaternion)
            v.append(qvel[:, dof : dof + 3])
        return np.hstack(q), np.hstack(v)

    def fill_mujoco(self, q: FloatArray, v: FloatArray, qpos: FloatArray, qvel: FloatArray) -> None:
        """Write (T, nq), (T, nv) of `pinocchio` into (T, nq), (T, nv) of the whole model, in its order."""
        have = have_dof = 0
        for kind, at, dof in self._plan:
            places, rates = _SIZES[kind]
            here, mine = q[:, have : have + places], v[:, have_dof : have_dof + rates]
            have, have_dof = have + places, have_dof + rates
            qpos[:, at : at + places], qvel[:, dof : dof + rates] = here, mine
            if kind != "one":
                qpos[:, at + places - 4 : at + places] = np.roll(here[:, -4:], 1, axis=1)
            if kind == "free":
                R = rotation_from_quaternion(here[:, 3:])
                qvel[:, dof : dof + 3] = np.einsum("tij,tj->ti", R, mine[:, :3])
