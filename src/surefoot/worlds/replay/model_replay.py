"""The motion of a recording, run again in the whole model that it was recorded with.

Ground, props and all other shapes of the model are there, and what is no robot with feet is replayed as well:
a crate, an arm, a hopper on rails. Torques of the log are put on the joints in place of the actuators, and
tracked as in other replays; the worlds are MuJoCo's own step, and the one with exact contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, unknown_name
from surefoot.records import Ending, Log
from surefoot.worlds.mujoco.model_file import read_model_file
from surefoot.worlds.mujoco.recording import record
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper
from surefoot.worlds.replay.model_task import ModelTask, model_task
from surefoot.worlds.replay.windows import (
    WINDOW,
    ReplayReport,
    WindowReplay,
    judge_window,
    pieces_of,
    report_of,
)

OWN, EXACT = "mujoco", "mujoco-exact"
"""The worlds: a model is MuJoCo's."""


def replay_model(log: Log, world: str, model: Any) -> ReplayReport:
    """Return what becomes of a recording's motion in a world with its whole model; see `replay_log`."""
    mujoco = import_mujoco()
    model = model if isinstance(model, mujoco.MjModel) else read_model_file(model)
    if world not in (OWN, EXACT):
        raise ProblemError(unknown_name("world for the model of a recording", world, (OWN, EXACT)))
    task = model_task(log, copy(model))
    row = float(model.opt.timestep) * task.steps
    pieces = pieces_of(len(task.time), row, WINDOW)
    made = [_replay(mujoco, task, world, *piece) for piece in pieces]

    def replay_at_home() -> tuple[WindowReplay, ...]:
        if world == OWN:
            return ()
        return tuple(_replay(mujoco, task, OWN, *piece)[0] for piece in pieces)

    return report_of(world, OWN, made, replay_at_home, "motion")


def _stepper(mujoco: Any, world: str, model: Any) -> tuple[Any, Callable[[Any], None]]:
    """Return the model that is stepped, and its step."""
    if world == OWN:
        return model, lambda data: mujoco.mj_step(model, data)
    exact = copy(model)
    exact.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    stepper = MujocoStepper(exact)
    return stepper.model, stepper.step


def _replay(mujoco: Any, task: ModelTask, world: str, first: int, last: int) -> tuple[WindowReplay, Log]:
    """Replay rows `first` to `last` - 1, and judge them."""
    model, step = _stepper(mujoco, world, task.model)
    data, dofs, root = mujoco.MjData(model), task.tree.joint_dofs, task.tree.root
    places = model.jnt_qposadr[model.dof_jntid[dofs]]
    data.qpos[:], data.qvel[:] = task.qpos[first], task.qvel[first]
    seen, outcome = np.zeros((last - first, 7)), Ending.DONE
    kinds = mujoco.mjtWarning
    lost = [int(kind) for kind in (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)]
    with record(model, data, task.tree.name) as again:
        for row in range(first, last):
            mujoco.mj_kinematics(model, data)
            seen[row - first, :3], seen[row - first, 3:] = data.xpos[root], np.roll(data.xquat[root], -1)
            data.xfrc_applied[:] = 0.0
            data.xfrc_applied[task.pushed[row]] = task.pushes[row]
            for _ in range(task.steps):
                torques = task.torques[row] + task.stiffness * (task.qpos[row, places] - data.qpos[places])
                torques += task.damping * (task.qvel[row, dofs] - data.qvel[dofs])
                data.qfrc_applied[dofs] = np.clip(torques, -task.limits, task.limits)
                step(data)
                again.step()
            if not np.isfinite(data.qpos).all() or any(data.warning[kind].number for kind in lost):
                outcome = Ending.INVALID
                break
    count = row - first + 1
    start = float(task.time[first])
    logged = task.poses[first : first + count]
    return judge_window(start, outcome, seen[:count], logged, task.height, again), again
