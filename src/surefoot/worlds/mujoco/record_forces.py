"""What moves a robot beside its contacts, and its momentum: MuJoCo's own numbers of a step.

Newton and Euler ask of the whole robot, whatever its joints are,

    d/dt (p, L) = sum of contact forces and their moments + (m g, 0) + (pushes, thrust, drag),

L about the centre of mass. What else acts on it from outside (compensated gravity, forces put on its free
joint, springs and equality constraints to the world) is no part of the right side: the audit finds it
missing, and `outside` says what the model holds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.worlds.mujoco.record_capture import RawBlock, Scheme
from surefoot.worlds.mujoco.record_instants import Instants, Kinematics
from surefoot.worlds.mujoco.record_tree import BodyTree


class TreeForces:
    """Momentum of a robot, what pushes it and its joints beside logged contacts: a row for every step.

    Attributes
    ----------
    outside
        What the model puts on the whole robot that is neither contact nor push: name to the largest force and
        moment [N, N m].
    """

    def __init__(self, mujoco: Any, model: Any, tree: BodyTree) -> None:
        self._mujoco, self._model, self._tree = mujoco, model, tree
        self._rest: BoolArray = model.jnt_actgravcomp[model.dof_jntid] == 0
        self._mass = float(model.body_mass[tree.bodies].sum())
        self.outside: dict[str, FloatArray] = {}

    def rows(self, instants: Instants, at: Kinematics) -> dict[str, Any]:
        """Return the channels of steps; the model is as it was then."""
        model, tree, raw = self._model, self._tree, instants.raw
        pushed = at.pushed
        compensated = np.where(self._rest, raw["qfrc_gravcomp"], 0.0)
        contact = raw["contact_joints"]
        rest = raw["qfrc_constraint"] - contact
        joints = raw["qfrc_passive"] - compensated + rest + contact - at.logged + pushed
        joints += self._implicit_damping(raw, instants.change)
        base = tree.base
        thrust = raw["qfrc_actuator"][:, base]
        joints[:, base] = (
            raw["qfrc_fluid"][:, base] + tree.unpowered * thrust + (contact - at.logged)[:, base]
            + pushed[:, base]
        )  # fmt: skip
        out = {
            "other_forces": instants.mean(tree.joint_forces(at, joints)),
            "solver_error": instants.solver_error,
        }
        if tree.free is None:
            return out
        out |= self._momentum(instants, at)
        whole = np.zeros_like(joints)
        whole[:, base] = raw["qfrc_fluid"][:, base] + thrust
        applied = tree.wrench(at, whole) + self._pushes(raw, at)
        shift = at.com - at.com[instants.first]  # an instant's wrench is about its own centre
        out["wrench_applied"] = instants.mean(_about(applied, shift))
        passive = raw["qfrc_passive"] - compensated - raw["qfrc_fluid"]
        for name, force in (
            ("gravity is compensated (gravcomp)", compensated),
            ("qfrc_applied on the root", raw["qfrc_applied"]),
            ("springs, dampers or callbacks on the root", passive),
            ("constraints to the world", rest),
            ("armature on the root", -model.dof_armature * instants.rate),
        ):  # fmt: skip
            self._note_outside(name, force, at)
        return out

    def _note_outside(self, name: str, force: FloatArray, at: Kinematics) -> None:
        """Keep the largest force and moment of (n, nv) forces on the root's joints."""
        if not force[:, self._tree.base].any():
            return
        whole = np.zeros_like(force)
        whole[:, self._tree.base] = force[:, self._tree.base]
        size = np.linalg.norm(self._tree.wrench(at, whole).reshape(-1, 2, 3), axis=2).max(axis=0)
        self.outside[name] = np.maximum(self.outside.get(name, 0.0), size)

    def _momentum(self, instants: Instants, at: Kinematics) -> dict[str, Any]:
        """Return momentum, its rate, and energy: rates M v̇ + h less the weight; rotors move nothing."""
        model, tree, start = self._model, self._tree, instants.starts
        own = np.zeros_like(at.momentum)
        own[:, tree.dofs] = instants.raw["start_qvel"][:, tree.dofs]
        momentum = at.momentum - model.dof_armature * own
        weight = tree.mass * np.asarray(model.opt.gravity)
        gained = self._gained_weight()
        rate = at.impulse - model.dof_armature * instants.rate + instants.raw["qfrc_bias"]
        change = tree.wrench(at, rate)
        if tree.free is not None:
            change = change + tree.free.T @ (tree.free[:, :3] @ (weight + gained))
        shift = at.com - at.com[instants.first]
        kinetic = 0.5 * np.einsum("ti,ti->t", own, momentum)
        return {
            "momentum": tree.wrench(at, momentum)[start],
            "momentum_rate": instants.mean(_about(change, shift)),
            "com": at.com[start],
            "energy": (kinetic - at.com @ weight)[start],
        }

    def _gained_weight(self) -> FloatArray:
        """Return the weight (3,) that a loop has put on its robot's bodies since its start."""
        mass = float(self._model.body_mass[self._tree.bodies].sum())
        return np.asarray((mass - self._mass) * self._model.opt.gravity)

    def _pushes(self, raw: RawBlock, at: Kinematics) -> FloatArray:
        """Return what `xfrc_applied` is about the centre of mass, with weight that was put on: (n, 6)."""
        bodies = self._tree.bodies
        wrenches = raw["xfrc_applied"][:, bodies]
        out = wrenches.sum(axis=1)
        arms = at.centres[:, bodies] - at.com[:, None]
        out[:, 3:] += np.cross(arms, wrenches[..., :3]).sum(axis=1)
        out[:, :3] += self._gained_weight()
        return np.asarray(out)

    def _implicit_damping(self, raw: RawBlock, change: FloatArray) -> FloatArray:
        """Return the forces (n, nv) that steps take implicitly at their ends.

        Euler's step takes the joints' dampers so, the implicit ones what else depends on the velocity.
        """
        model, out = self._model, np.zeros_like(change)
        if raw.schemes[0] == Scheme.EULER:
            if not model.opt.disableflags & self._mujoco.mjtDisableBit.mjDSBL_EULERDAMP:
                out -= model.dof_damping * change
        elif "qDeriv" in raw:
            ends = np.append(model.D_rowadr, model.D_rowadr[-1] + model.D_rownnz[-1])
            rows = np.repeat(np.arange(model.nv), np.diff(ends))
            terms = raw["qDeriv"] * change[:, model.D_colind]
            np.add.at(out.T, rows, terms.T)
        return out


def _about(wrench: FloatArray, shift: FloatArray) -> FloatArray:
    """Return (n, 6) wrenches about points from which (n, 3) `shift` leads to those that they are about."""
    return np.hstack([wrench[:, :3], wrench[:, 3:] + np.cross(shift, wrench[:, :3])])
