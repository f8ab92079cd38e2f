"""Which of a MuJoCo model's bodies are the robot, and its state in Pinocchio's order."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ModelError, ProblemError, unknown_name
from surefoot.spatial import quaternion_xyzw, rotation_from_quaternion


class BodyTree:
    """A robot within a MuJoCo model: a body and all below it.

    Attributes
    ----------
    name
        Of its root body.
    bodies
        Numbers of its bodies.
    mass
        Of all of them [kg].
    joint_names, joints
        Names and number of its hinges and slides.
    others
        Roots of the other bodies that move.
    """

    def __init__(self, mujoco: Any, model: Any, robot: str | None) -> None:
        moving = [b for b in range(1, model.nbody) if model.body_weldid[b] == b]
        roots = [b for b in moving if model.body_weldid[model.body_parentid[b]] == 0]
        if not roots:
            raise ModelError("nothing moves in this model")
        names = {b: str(model.body(b).name) or f"body {b}" for b in range(model.nbody)}
        if robot is None:
            root = max(roots, key=lambda b: float(model.body_subtreemass[b]))
        elif robot in names.values():
            root = next(b for b, name in names.items() if name == robot)
        else:
            raise ProblemError(unknown_name("body", robot, names.values()))
        self.name, self.root = names[root], root
        below = {root}
        for b in range(root + 1, model.nbody):  # parents come first
            if int(model.body_parentid[b]) in below:
                below.add(b)
        self.bodies = np.array(sorted(below))
        self.mass = float(model.body_subtreemass[root])
        self.others = [
            names[b]
            for b in roots
            if b not in below and int(model.body_rootid[b]) != int(model.body_rootid[root])
        ]
        kinds = mujoco.mjtJoint
        self._plan: list[tuple[str, int, int]] = []
        self.joint_names: list[str] = []
        self._dofs: list[int] = []
        for j in range(model.njnt):
            if int(model.jnt_bodyid[j]) not in below:
                continue
            kind, at, dof = model.jnt_type[j], int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
            if kind == kinds.mjJNT_FREE:
                self._plan.append(("free", at, dof))
            elif kind == kinds.mjJNT_BALL:
                self._plan.append(("ball", at, dof))
            else:
                self._plan.append(("one", at, dof))
                self.joint_names.append(str(model.joint(j).name) or f"joint {j}")
                self._dofs.append(dof)
        self.joints = len(self._dofs)

    def torques(self, data: Any) -> FloatArray:
        """Return what actuators and the user put on the hinges and slides: (joints,) [N m, N]."""
        return np.asarray(data.qfrc_actuator[self._dofs] + data.qfrc_applied[self._dofs])

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
            if kind == "free":
                R = rotation_from_quaternion(quaternion)
                q.append(qpos[:, at : at + 3])
                v.append(np.einsum("tji,tj->ti", R, qvel[:, dof : dof + 3]))
                dof += 3
            q.append(quaternion)
            v.append(qvel[:, dof : dof + 3])
        return np.hstack(q), np.hstack(v)
