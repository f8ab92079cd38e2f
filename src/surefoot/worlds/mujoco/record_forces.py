"""What moves a robot beside its contacts, and its momentum: MuJoCo's own numbers of a step.

Newton and Euler ask of the whole robot, whatever its joints are,

    d/dt (p, L) = sum of contact forces and their moments + (m g, 0) + (pushes, thrust, drag),

L about the centre of mass. What else acts on it from outside (compensated gravity, forces put on its free
joint, springs and equality constraints to the world) is no part of the right side: the audit finds it
missing, and `outside` says what the model holds.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.worlds.mujoco.record_tree import BodyTree

EXACT = 1e-3
"""A step that was made again ends in the same velocities to this share: solvers stop early."""
SURE = 100
"""Iterations of the solver that the forces of a doubtful one are compared with."""
_WEIGHTS = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)
_NODES = (0.0, 0.5, 0.5, 1.0)


class ForceStages:
    """The instants of a step at which MuJoCo works out forces: one, or the four of Runge and Kutta.

    Attributes
    ----------
    four
        Whether it is four.
    missed
        Steps of Runge and Kutta that came out otherwise when made again.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model
        self.four = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
        self._data: Any = mujoco.MjData(model) if self.four else None
        self._start: tuple[FloatArray, ...] = ()
        self.missed = 0

    def remember(self, data: Any) -> None:
        """Keep the state that the next step starts from."""
        self._start = data.qpos.copy(), data.qvel.copy(), data.act.copy(), data.qacc_warmstart.copy()

    def of(self, data: Any) -> Iterator[tuple[float, Any]]:
        """Yield weight and data of every instant of the step that `data` has just made.

        The data is the same object each time, moved on.
        """
        if not self.four:
            yield 1.0, data
            return
        mujoco, model, stage, h = self._mujoco, self._model, self._data, float(self._model.opt.timestep)
        mujoco.mj_copyData(stage, model, data)
        q, v, act, stage.qacc_warmstart[:] = self._start
        # The stages of the classical scheme are not kept by MuJoCo: they are run again from the state before
        # the step.
        speed, rate, growth = v, np.zeros_like(v), np.zeros_like(act)
        mean = np.zeros_like(v)
        for weight, node in zip(_WEIGHTS, _NODES, strict=True):
            stage.qpos[:] = q
            mujoco.mj_integratePos(model, stage.qpos, speed, node * h)
            stage.qvel[:], stage.act[:] = v + node * h * rate, act + node * h * growth
            stage.time = data.time - h + node * h
            mujoco.mj_forward(model, stage)
            speed, rate, growth = stage.qvel.copy(), stage.qacc.copy(), stage.act_dot.copy()
            mean += weight * rate
            yield weight, stage
        change = data.qvel - v
        self.missed += not np.abs(h * mean - change).max() <= EXACT * (1.0 + np.abs(change).max())


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
        self._touch = int(mujoco.mjtConstraint.mjCNSTR_CONTACT_FRICTIONLESS)  # and all kinds after it
        self._damped = _damping(mujoco, model)
        self._rest = model.jnt_actgravcomp[model.dof_jntid] == 0
        self._mass = float(model.body_mass[tree.bodies].sum())
        self._rows: list[dict[str, Any]] = []
        self.outside: dict[str, FloatArray] = {}
        self._sure = _sure_model(mujoco, model)
        self._check = None if self._sure is None else mujoco.MjData(self._sure)

    def begin(self, data: Any, v: FloatArray) -> None:
        """Open the row of a step, at its start, where the velocities were v (nv,)."""
        tree, own = self._tree, np.zeros_like(v)
        own[tree.dofs] = v[tree.dofs]
        momentum = self._times_mass(data, own)
        weight, centre = tree.mass * self._model.opt.gravity, data.subtree_com[tree.root].copy()
        self._rows.append({
            "other_forces": np.zeros(len(tree.dofs)), "solver_error": self._error(data),
            "momentum": tree.wrench(data, momentum), "momentum_rate": np.zeros(6), "com": centre,
            "energy": float(0.5 * own @ momentum - weight @ centre), "wrench_applied": np.zeros(6),
        })  # fmt: skip

    def add(self, data: Any, weight: float, change: FloatArray, rate: FloatArray, logged: FloatArray) -> None:
        """Add what acts at an instant of the step.

        Parameters
        ----------
        data
            There.
        weight
            Of the instant.
        change
            (nv,) of the velocities over the step.
        rate
            (nv,) of the velocities at this instant.
        logged
            (nv,) what the forces of the contacts in the log put on the joints.
        """
        model, tree, row = self._model, self._tree, self._rows[-1]
        pushed, push = self._external_forces(data)
        compensated = np.where(self._rest, data.qfrc_gravcomp, 0.0)
        contact, rest = self._constraints(data)
        joints = data.qfrc_passive - compensated + rest + contact - logged + pushed
        if self._damped is not None:  # what an implicit step takes at its end
            joints += self._damped(data) @ change
        base = tree.base
        thrust, unlogged = data.qfrc_actuator[base], (contact - logged)[base]
        joints[base] = data.qfrc_fluid[base] + tree.unpowered * thrust + unlogged + pushed[base]
        row["other_forces"] += weight * tree.joint_forces(data, joints)
        if tree.free is None:
            return
        shift = data.subtree_com[tree.root] - row["com"]  # an instant's wrench is about its own centre
        row["momentum_rate"] += weight * _about(self._momentum_rate(data, rate), shift)
        whole = np.zeros(model.nv)
        whole[base] = data.qfrc_fluid[base] + thrust
        push[:3] += self._gained_weight()
        row["wrench_applied"] += weight * _about(tree.wrench(data, whole) + push, shift)
        passive = data.qfrc_passive - compensated - data.qfrc_fluid
        for name, force in (
            ("gravity is compensated (gravcomp)", compensated),
            ("qfrc_applied on the root", data.qfrc_applied),
            ("springs, dampers or callbacks on the root", passive),
            ("constraints to the world", rest),
            ("armature on the root", -model.dof_armature * rate),
        ):  # fmt: skip
            if force[base].any():
                whole[base] = force[base]
                size = np.linalg.norm(tree.wrench(data, whole).reshape(2, 3), axis=1)
                self.outside[name] = np.maximum(self.outside.get(name, 0.0), size)

    def rows(self) -> dict[str, Any]:
        """Return the channels."""
        out: dict[str, Any] = {name: np.array([row[name] for row in self._rows]) for name in self._rows[0]}
        if self._tree.free is None:
            out = {name: out[name] for name in ("other_forces", "solver_error")}
        if not out["solver_error"].any():
            del out["solver_error"]
        return out

    def _gained_weight(self) -> FloatArray:
        """Return the weight (3,) that a loop has put on its robot's bodies since its start."""
        mass = float(self._model.body_mass[self._tree.bodies].sum())
        return np.asarray((mass - self._mass) * self._model.opt.gravity)

    def _momentum_rate(self, data: Any, rate: FloatArray) -> FloatArray:
        """Return the rate (6,) of momentum: M v̇ + h less the weight; rotors move nothing."""
        model, tree = self._model, self._tree
        out = tree.wrench(data, self._times_mass(data, rate) + data.qfrc_bias)
        weight = np.zeros(6)
        if tree.free is not None:
            weight[:3] = tree.mass * model.opt.gravity + self._gained_weight()
            out += tree.free.T @ (tree.free @ weight)
        return out

    def _times_mass(self, data: Any, v: FloatArray) -> FloatArray:
        """Return M v (nv,) without the rotors, which move nothing."""
        joints = np.zeros(self._model.nv)
        self._mujoco.mj_mulM(self._model, data, joints, v)
        return np.asarray(joints - self._model.dof_armature * v)

    def _external_forces(self, data: Any) -> tuple[FloatArray, FloatArray]:
        """Return what `xfrc_applied` is on the joints (nv,), and about the centre of mass (6,)."""
        joints, wrench = np.zeros(self._model.nv), np.zeros(6)
        for body in self._tree.bodies[data.xfrc_applied[self._tree.bodies].any(axis=1)].tolist():
            force, moment, at = data.xfrc_applied[body, :3], data.xfrc_applied[body, 3:], data.xipos[body]
            self._mujoco.mj_applyFT(self._model, data, force, moment, at, body, joints)
            wrench[:3] += force
            wrench[3:] += moment + np.cross(at - data.subtree_com[self._tree.root], force)
        return joints, wrench

    def _constraints(self, data: Any) -> tuple[FloatArray, FloatArray]:
        """Return what contacts put on the joints, and what limits, friction and equalities do: (nv,) each."""
        contact = np.zeros(self._model.nv)
        if data.nefc:
            touches = data.efc_type >= self._touch
            if touches.any():
                self._mujoco.mj_mulJacTVec(self._model, data, contact, np.where(touches, data.efc_force, 0.0))
        return contact, data.qfrc_constraint - contact

    def _error(self, data: Any) -> float:
        """Return the largest error of a contact force [N]; zero where the solver says that it converged."""
        mujoco, model, sure, check = self._mujoco, self._model, self._sure, self._check
        if sure is None or not data.ncon:
            return 0.0
        done = data.solver_niter[: max(int(data.nisland), 1)]
        if model.opt.solver != mujoco.mjtSolver.mjSOL_PGS and (done < model.opt.iterations).all():
            return 0.0
        mujoco.mj_copyData(check, model, data)
        mujoco.mj_fwdConstraint(sure, check)
        own, other, worst = np.zeros(6), np.zeros(6), 0.0
        for c in range(data.ncon):
            mujoco.mj_contactForce(model, data, c, own)
            mujoco.mj_contactForce(sure, check, c, other)
            worst = max(worst, float(np.linalg.norm(own[:3] - other[:3])))
        return worst


def _about(wrench: FloatArray, shift: FloatArray) -> FloatArray:
    """Return a (6,) wrench about a point from which (3,) `shift` leads to the one that it is about."""
    return np.concatenate([wrench[:3], wrench[3:] + np.cross(shift, wrench[:3])])


def _sure_model(mujoco: Any, model: Any) -> Any:
    """Return a model that solves the same contacts to the end; None where forces are changed afterwards."""
    if model.opt.noslip_iterations > 0:
        return None
    from copy import copy

    sure = copy(model)
    sure.opt.solver, sure.opt.iterations = mujoco.mjtSolver.mjSOL_NEWTON, SURE
    sure.opt.tolerance = 0.0
    return sure


def _damping(mujoco: Any, model: Any) -> Any:
    """Return the derivative of joint forces by velocities that a step takes implicitly; None for none.

    Euler's step takes the joints' dampers so, the implicit ones what else depends on the velocity.
    """
    kinds, off = mujoco.mjtIntegrator, mujoco.mjtDisableBit
    if model.opt.integrator == kinds.mjINT_EULER:
        if model.opt.disableflags & off.mjDSBL_EULERDAMP or not model.dof_damping.any():
            return None
        diagonal = -np.diag(model.dof_damping)
        return lambda data: diagonal
    if model.opt.integrator == kinds.mjINT_RK4:
        return None

    def derivative(data: Any) -> Any:
        from scipy.sparse import csr_array

        ends = np.append(model.D_rowadr, model.D_rowadr[-1] + model.D_rownnz[-1])
        return csr_array((data.qDeriv, model.D_colind, ends), shape=(model.nv, model.nv))

    return derivative
