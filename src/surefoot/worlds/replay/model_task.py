"""What a replay in the whole model of a recording takes from the two: states, torques, pushes of rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.records import Log
from surefoot.worlds.mujoco.record_model import body_name
from surefoot.worlds.mujoco.record_tree import BodyTree
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.replay.replay_task import refuse_not_finite, row_clock, tracking_gains

NEEDED = ("q", "v", "com")
"""Channels without which nothing is replayed."""
UNDER = ("gain", "torque limit")
"""What a loop may change in its model: torques are the log's, whatever gave them."""


@dataclass(frozen=True)
class ModelTask:
    """Everything of a recording that is replayed in its model, checked.

    Attributes
    ----------
    model, tree
        The model without its actuators, and which of its bodies are the robot.
    time, qpos, qvel
        (T,), (T, nq), (T, nv) rows, in MuJoCo's order.
    torques
        (T, joints) on the robot's hinges and slides [N m, N].
    pushes, pushed
        (T, 6) force and moment on a body about its centre of mass [N, N m], and its number.
    poses
        (T, 7) place [m] and quaternion x, y, z, w of the robot's root.
    height
        Of the first row's centre of mass over what the robot touches first [m].
    limits, stiffness, damping
        (joints,) of torques [N m, N], and of the tracking [N m/rad, N m s/rad].
    steps
        Of the model, from row to row.
    """

    model: Any
    tree: BodyTree
    time: FloatArray
    qpos: FloatArray
    qvel: FloatArray
    torques: FloatArray
    pushes: FloatArray
    pushed: IntArray
    poses: FloatArray
    height: float
    limits: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    steps: int


def model_task(log: Log, model: Any) -> ModelTask:
    """Return what is replayed of a recording in its model.

    Raises
    ------
    ProblemError
        In one line, for a model that is not the log's, or moves by what the log does not hold.
    """
    mujoco = import_mujoco()
    tree = _tree_of(mujoco, log, model)
    _refuse_unknown(mujoco, log, model, tree)
    time = np.asarray(log["time"], dtype=np.float64)
    row, _ = row_clock(time)
    steps = max(1, round(row / float(model.opt.timestep)))
    if abs(row - steps * float(model.opt.timestep)) > 1e-3 * row:
        raise ProblemError(f"its rows are {row:g} s apart, which are no steps of {model.opt.timestep:g} s")
    qpos, qvel = _states(mujoco, log, model, tree)
    torques = np.array(log["torques"]) if "torques" in log else np.zeros((len(time), tree.joints))
    limits = np.asarray(log.facts.get("model_torque_limits", np.full(tree.joints, np.inf)), dtype=np.float64)
    refuse_not_finite({"q": qpos, "v": qvel, "torques": torques})
    poses, pushes, pushed = _poses_and_pushes(mujoco, log, model, tree, qpos)
    stiffness, damping = _gains(mujoco, log, model, tree, qpos[0])
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    return ModelTask(
        model, tree, time, qpos, qvel, torques, pushes, pushed, poses, _height(log), limits, stiffness,
        damping, steps,
    )  # fmt: skip


def _tree_of(mujoco: Any, log: Log, model: Any) -> BodyTree:
    """Return the robot within the model, after checking that it is the log's."""
    if log.facts.get("kind") != "recording" or "model_bodies" not in log.facts:
        raise ProblemError("a model is for a recording of sf.record, and this is another log")
    names = [str(name) for name in log.fact("model_bodies")]
    roots = [b for b in range(1, model.nbody) if body_name(model, b) == names[0]]
    tree = BodyTree(mujoco, model, names[0]) if roots else None
    joints = [str(name) for name in log.facts.get("joints", ())]
    if tree is None or [body_name(model, b) for b in tree.bodies] != names or tree.joint_names != joints:
        raise ProblemError(
            f"the model is not the log's: it has no robot {names[0]} of the same links and joints"
        )
    masses = np.asarray(log.fact("model_masses"), dtype=np.float64)
    if not np.allclose(model.body_mass[tree.bodies], masses, rtol=1e-9):
        raise ProblemError("the model is not the log's: its links have other masses")
    return tree


def _refuse_unknown(mujoco: Any, log: Log, model: Any, tree: BodyTree) -> None:
    """Raise `ProblemError` for what moves the model and is not in the log."""
    changed = {str(kind) for kind in log.facts.get("change_kind", ())} - set(UNDER)
    if changed:
        raise ProblemError(f"its loop changed the {' and the '.join(sorted(changed))} of its model")
    if model.nmocap:
        raise ProblemError("a body of its model is moved by hand (mocap), and the log does not hold where")
    if tree.other_places.size and "others_q" not in log:
        raise ProblemError("more than its robot moves in its model, and the log does not hold where")
    lacking = [name for name in NEEDED if name not in log]
    if lacking:
        raise ProblemError(f"it has no channel {lacking[0]}")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    dofs = np.asarray(data.moment_colind)[: int(np.sum(data.moment_rownnz))]
    kinds = np.asarray(model.actuator_trntype)
    if np.setdiff1d(dofs, tree.joint_dofs).size or (kinds == int(mujoco.mjtTrn.mjTRN_BODY)).any():
        raise ProblemError("an actuator of its model moves more than the robot's hinges and slides")


def _states(mujoco: Any, log: Log, model: Any, tree: BodyTree) -> tuple[FloatArray, FloatArray]:
    """Return (T, nq) positions and (T, nv) velocities of the whole model."""
    qpos = np.tile(np.asarray(model.qpos0, dtype=np.float64), (len(log), 1))
    qvel = np.zeros((len(log), int(model.nv)))
    tree.fill_mujoco(np.asarray(log["q"]), np.asarray(log["v"]), qpos, qvel)
    if tree.other_places.size:
        qpos[:, tree.other_places], qvel[:, tree.other_dofs] = log["others_q"], log["others_v"]
    return qpos, qvel


def _poses_and_pushes(
    mujoco: Any, log: Log, model: Any, tree: BodyTree, qpos: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return `ModelTask.poses`, `pushes` and `pushed`."""
    rows, data = len(qpos), mujoco.MjData(model)
    poses, pushes, pushed = np.zeros((rows, 7)), np.zeros((rows, 6)), np.full(rows, tree.root)
    place = np.asarray(log["pushed_body"], dtype=np.int64) if "pushed_body" in log else np.full(rows, -1)
    if (place >= 0).any() and (model.opt.density or model.opt.viscosity):
        raise ProblemError("its pushes cannot be told from the drag of its air or water")
    wrenches = np.asarray(log["wrench_applied"]) if "wrench_applied" in log else pushes
    for k in range(rows):
        data.qpos[:] = qpos[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        poses[k, :3], poses[k, 3:] = data.xpos[tree.root], np.roll(data.xquat[tree.root], -1)
        if place[k] >= 0:
            pushed[k] = tree.bodies[place[k]]
            force, moment = wrenches[k, :3], wrenches[k, 3:]
            pushes[k, :3] = force
            pushes[k, 3:] = moment - np.cross(data.xipos[pushed[k]] - log["com"][k], force)
    return poses, pushes, pushed


def _height(log: Log) -> float:
    """Return how high the centre of mass is over the first contact that carries something [m]."""
    if not {"forces", "contact_positions"} <= set(log):
        return float(log["com"][0, 2])
    loaded = np.asarray(log["forces"])[..., 2] > 0.0
    if not loaded.any():
        return float(log["com"][0, 2])
    row = int(loaded.any(axis=1).argmax())
    ground = np.asarray(log["contact_positions"])[row][loaded[row], 2].min()
    return float(log["com"][row, 2] - ground)


def _gains(
    mujoco: Any, log: Log, model: Any, tree: BodyTree, qpos: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return stiffness and damping of the tracking, by the rule of other replays."""
    data, dofs = mujoco.MjData(model), tree.joint_dofs
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    units, solved = np.zeros((len(dofs), int(model.nv))), np.zeros((len(dofs), int(model.nv)))
    units[np.arange(len(dofs)), dofs] = 1.0
    if len(dofs):
        mujoco.mj_solveM(model, data, solved, units)
    inertia, dt = 1.0 / solved[np.arange(len(dofs)), dofs], float(model.opt.timestep)
    weight = tree.mass * float(np.linalg.norm(model.opt.gravity))
    return tracking_gains(inertia, weight * max(abs(_height(log)), 0.1), dt)
