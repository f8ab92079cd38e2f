"""The instants of recorded steps at which MuJoCo worked out forces, with the kinematics there.

Most steps have one, whose forces were copied. The four of Runge and Kutta are not kept by MuJoCo: they are
made again from the state before the step. Kinematics follow from positions and velocities, by MuJoCo's own
functions in data of the recording's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.worlds.mujoco.record_capture import OF_STATE, START, RawBlock, RawSteps, Scheme
from surefoot.worlds.mujoco.record_tree import BodyTree

EXACT = 1e-3
"""A step that was made again ends in the same velocities to this share: solvers stop early."""
SURE = 100
"""Iterations of the solver that the forces of a doubtful one are compared with."""
SAME = 1e-9
"""Share to which accelerations agree where a step was made again exactly."""
_WEIGHTS = np.array([1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0])
_NODES = (0.0, 0.5, 0.5, 1.0)


@dataclass
class Instants:
    """Instants of consecutive steps, n of them, in order.

    Attributes
    ----------
    raw
        What was copied there.
    step
        (n,) step of each, counted from the first.
    weight
        (n,) share of the step.
    change
        (n, nv) of the velocities over the whole step.
    rate
        (n, nv) of the velocities at the instant.
    first
        (n,) first instant of the step of each.
    solver_error
        (steps,) largest error of a contact force [N].
    """

    raw: RawBlock
    step: IntArray
    weight: FloatArray
    change: FloatArray
    rate: FloatArray
    first: IntArray
    solver_error: FloatArray

    def mean(self, values: FloatArray) -> FloatArray:
        """Return the mean (steps, ...) of what (n, ...) was at the instants, by their weights."""
        if len(self.step) == len(self.solver_error):
            return values
        weighted = self.weight.reshape(-1, *[1] * (values.ndim - 1)) * values
        return np.asarray(np.add.reduceat(weighted, np.unique(self.first), axis=0))

    @property
    def starts(self) -> IntArray:
        """(steps,) the first instant of every step."""
        return np.unique(self.first)


class StepReplay:
    """Steps made again where MuJoCo does not keep what is asked for.

    Attributes
    ----------
    four
        Whether steps were of Runge and Kutta.
    missed
        Those that came out otherwise.
    unsure
        Steps whose solver did not converge, and that came out otherwise.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model
        self._data = mujoco.MjData(model)
        self._spec = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        self._sure = _sure_model(mujoco, model)
        self._check = None if self._sure is None else mujoco.MjData(self._sure)
        self.missed = self.unsure = 0
        self.four = False

    def instants(self, block: RawBlock) -> Instants:
        """Return the instants of steps that were all integrated by the same scheme."""
        change = block["end_qvel"] - block["start_qvel"]
        if len(block) and block.schemes[0] == Scheme.RK4:
            return self._stages(block, change)
        every = np.arange(len(block))
        error = np.zeros(len(block))
        for row in block.doubtful if self._sure is not None else ():
            error[row] = self._error_of(block, row)
        rate = change / block.step[:, None]
        return Instants(block, every, np.ones(len(block)), change, rate, every, error)

    def _stages(self, block: RawBlock, change: FloatArray) -> Instants:
        """Return the four instants of every step of Runge and Kutta."""
        self.four = True
        mujoco, model, stage = self._mujoco, self._model, self._data
        raw, error = RawSteps(mujoco, model, stage, 4 * len(block), again=False), np.zeros(len(block))
        rates = np.zeros((len(block), 4, model.nv))
        for row in range(len(block)):
            q, v, act = self._begin(block, row)
            h, end = block.step[row], block.time[row]
            speed, rate, growth = v, np.zeros_like(v), np.zeros_like(act)
            for k, node in enumerate(_NODES):
                stage.qpos[:] = q
                mujoco.mj_integratePos(model, stage.qpos, speed, node * h)
                stage.qvel[:], stage.act[:] = v + node * h * rate, act + node * h * growth
                stage.time = end + node * h
                raw.remember()
                mujoco.mj_forward(model, stage)
                raw.take_instant(h, Scheme.RK4)
                speed, rate, growth = stage.qvel.copy(), stage.qacc.copy(), stage.act_dot.copy()
                rates[row, k] = rate
                if k == 0:
                    error[row] = self._error(stage)
            mean = h * (_WEIGHTS @ rates[row])
            self.missed += not np.abs(mean - change[row]).max() <= EXACT * (1.0 + np.abs(change[row]).max())
        steps = np.repeat(np.arange(len(block)), 4)
        return Instants(
            raw.rows(0, raw.count), steps, np.tile(_WEIGHTS, len(block)), change[steps],
            rates.reshape(-1, model.nv), 4 * steps, error,
        )  # fmt: skip

    def _begin(self, block: RawBlock, row: int) -> list[FloatArray]:
        """Put the replay's data to where a step started, and return positions, velocities, activations."""
        state, data = block.state(row), self._data
        if state is not None:
            self._mujoco.mj_setState(self._model, data, state, self._spec)
        else:
            for name in OF_STATE[len(START) :]:
                getattr(data, name)[:] = block[name][row]
        parts = [block[f"start_{name}"][row] for name in ("qpos", "qvel", "act")]
        data.qpos[:], data.qvel[:], data.act[:] = parts
        data.qacc_warmstart[:] = block["start_qacc_warmstart"][row]
        data.time = block.time[row]
        return parts

    def _error_of(self, block: RawBlock, row: int) -> float:
        """Return the largest error of a contact force of a step whose solver may have stopped early [N]."""
        self._begin(block, row)
        self._mujoco.mj_forward(self._model, self._data)
        found, made = self._data.qacc, block["qacc"][row]
        if not np.abs(found - made).max(initial=0.0) <= SAME * (1.0 + np.abs(made).max(initial=0.0)):
            self.unsure += 1
            return 0.0
        self._data.qacc_warmstart[:] = made
        return self._error(self._data)

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


class Kinematics:
    """Where bodies and geoms were at instants, how fast, and what forces there are on the joints.

    Attributes
    ----------
    xpos, xmat, com
        (n, 3), (n, 3, 3) of the root body, (n, 3) centre of mass of its tree [m].
    anchors
        (n, joints, 3) of all joints [m].
    centres
        (n, nbody, 3) of the bodies' masses [m].
    geom_xpos, geom_xmat
        (n, ngeom, 3), (n, ngeom, 3, 3) [m].
    cvel, subtree_com
        (n, nbody, 6), (n, nbody, 3) as MuJoCo has them.
    momentum, impulse
        (n, nv) M times the robot's own velocities, and M times the rates, with the rotors.
    logged, pushed
        (n, nv) what forces of contacts, and what `xfrc_applied`, put on the joints.
    """

    _FIELDS = ("xpos", "xmat", "xipos", "xanchor", "geom_xpos", "geom_xmat", "cvel", "subtree_com")

    def __init__(self, mujoco: Any, model: Any, data: Any, tree: BodyTree) -> None:
        self._mujoco, self._model, self._data, self._tree = mujoco, model, data, tree
        self._views = [getattr(data, name) for name in self._FIELDS]
        self._momentum, self._impulse = np.zeros(model.nv), np.zeros(model.nv)
        self._logged, self._pushed = np.zeros(model.nv), np.zeros(model.nv)
        self._parts = [
            *(view.reshape(-1) for view in self._views),
            self._momentum, self._impulse, self._logged, self._pushed,
        ]  # fmt: skip
        self._make_mass = getattr(mujoco, "mj_makeM", mujoco.mj_crb)  # tendons' rotors are in the first alone

    def trace(self, instants: Instants, contacts: tuple[IntArray, FloatArray, FloatArray, IntArray]) -> None:
        """Go through instants; contacts are rows (c,), forces (c, 3) [N], places (c, 3) [m], bodies (c,)."""
        mujoco, model, data, raw = self._mujoco, self._model, self._data, instants.raw
        n, nv = len(raw), model.nv
        q, v, mocap = raw["start_qpos"], raw["start_qvel"], model.nmocap > 0
        own = np.zeros((n, nv))
        own[:, self._tree.dofs] = v[:, self._tree.dofs]
        qpos, qvel, crowd = data.qpos, data.qvel, raw["xfrc_applied"]
        pushes = np.any(crowd[:, self._tree.bodies], axis=(1, 2)).tolist()
        row, force, place, body = contacts
        ends = np.searchsorted(row, np.arange(n + 1)).tolist()
        bodies, none, apply = body.tolist(), np.zeros(3), mujoco.mj_applyFT
        flat = np.zeros((n, sum(part.size for part in self._parts)))
        for i in range(n):
            qpos[:], qvel[:] = q[i], v[i]
            if mocap:
                data.mocap_pos[:], data.mocap_quat[:] = raw["mocap_pos"][i], raw["mocap_quat"][i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            self._make_mass(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_mulM(model, data, self._momentum, own[i])
            mujoco.mj_mulM(model, data, self._impulse, instants.rate[i])
            self._logged.fill(0.0)
            for c in range(ends[i], ends[i + 1]):
                apply(model, data, force[c], none, place[c], bodies[c], self._logged)
            self._pushed.fill(0.0)
            if pushes[i]:
                pushed = np.flatnonzero(np.any(crowd[i, self._tree.bodies], axis=1))
                for b in self._tree.bodies[pushed].tolist():
                    apply(model, data, crowd[i, b, :3], crowd[i, b, 3:], data.xipos[b], b, self._pushed)
            np.concatenate(self._parts, out=flat[i])
        self._unpack(flat)

    def _unpack(self, flat: FloatArray) -> None:
        """Give the parts of flat rows their names."""
        found, at = dict[str, FloatArray](), 0
        for name, part, view in zip(self._FIELDS, self._parts, self._views, strict=False):
            found[name] = flat[:, at : at + part.size].reshape(-1, *view.shape)
            at += part.size
        root = self._tree.root
        self.xpos, self.xmat = found["xpos"][:, root], found["xmat"][:, root].reshape(-1, 3, 3)
        self.com, self.centres = found["subtree_com"][:, root], found["xipos"]
        self.anchors, self.geom_xpos = found["xanchor"], found["geom_xpos"]
        self.geom_xmat = found["geom_xmat"].reshape(*found["geom_xmat"].shape[:2], 3, 3)
        self.cvel, self.subtree_com = found["cvel"], found["subtree_com"]
        nv = self._model.nv
        joints = flat[:, at:].reshape(len(flat), 4, nv)
        self.momentum, self.impulse, self.logged, self.pushed = joints.transpose(1, 0, 2)


def _sure_model(mujoco: Any, model: Any) -> Any:
    """Return a model that solves the same contacts to the end; None where forces are changed afterwards."""
    if model.opt.noslip_iterations > 0:
        return None
    from copy import copy

    sure = copy(model)
    sure.opt.solver, sure.opt.iterations = mujoco.mjtSolver.mjSOL_NEWTON, SURE
    sure.opt.tolerance = 0.0
    return sure
