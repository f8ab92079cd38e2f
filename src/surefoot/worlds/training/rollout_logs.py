"""Logs of `mujoco.rollout`: its states in, a log each out."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, real_array, whole_number
from surefoot.base.errors import ProblemError
from surefoot.records import Log
from surefoot.worlds.mujoco.recording import record
from surefoot.worlds.mujoco.spec import import_mujoco

DIFFERENCE = 1e-6
"""Between a rollout's states and those of the same steps made again, over one plus their size [-]: what other
threads or another build of MuJoCo may round is far below, another control far above."""


def log_rollouts(
    model: Any, initial_state: Any, control: Any = None, *, nstep: int | None = None, state: Any = None,
    robot: str | None = None,
) -> list[Log]:  # fmt: skip
    """Return the log of every rollout that `mujoco.rollout.rollout` makes of the same arguments.

    C makes the steps of a rollout and keeps their states alone, no contact: they are made again, one by one,
    and recorded. A rollout starts without impulses of a step before, so the states are the same.

    Parameters
    ----------
    model
        An MjModel.
    initial_state
        (n, nstate) or (nstate,) in MuJoCo's mjSTATE_FULLPHYSICS.
    control
        (n, T, nu), or (T, nu) for all; None for the controls of a new data.
    nstep
        T, where there is no control.
    state
        (n, T, nstate) that `mujoco.rollout.rollout` returned: they are held against the steps made again.
    robot
        Name of the body at the robot's root, see `surefoot.record`.

    Raises
    ------
    ProblemError
        For shapes that do not fit, and a `state` that the steps do not reach.
    MissingExtra
        If MuJoCo is not installed.

    Examples
    --------
    >>> import mujoco, numpy as np
    >>> model = mujoco.MjModel.from_xml_string(
    ...     "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body name='ball' pos='0 0 0.1'>"
    ...     "<freejoint/><geom name='skin' size='0.1'/></body></worldbody></mujoco>"
    ... )
    >>> start = np.array([[0.0, 0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0]])
    >>> [len(log) for log in log_rollouts(model, start, nstep=300)]
    [300]
    """
    mujoco = import_mujoco()
    if not isinstance(model, mujoco.MjModel):
        raise ProblemError(f"log_rollouts takes an MjModel, got {type(model).__name__}")
    starts, controls, reached = _shapes(mujoco, model, initial_state, control, nstep, state)
    logs: list[Log] = []
    for k, start in enumerate(starts):
        logs.append(
            _log_one(mujoco, model, start, controls[k], None if reached is None else reached[k], robot)
        )
    return logs


def _shapes(
    mujoco: Any, model: Any, initial_state: Any, control: Any, nstep: int | None, state: Any
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Return starts (n, nstate), controls (n, T, nu), and states (n, T, nstate) or None."""
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    starts = np.atleast_2d(real_array("initial_state", initial_state))
    if starts.ndim != 2 or starts.shape[1] != size:
        raise ProblemError(f"initial_state must have shape (n, {size}), got {np.shape(initial_state)}")
    n = len(starts)
    if control is None:
        if nstep is None:
            raise ProblemError("say nstep, or give control (n, T, nu)")
        controls = np.broadcast_to(
            mujoco.MjData(model).ctrl, (n, whole_number("nstep", nstep, low=1), model.nu)
        )
    else:
        given = real_array("control", control)
        controls = given[None].repeat(n, axis=0) if given.ndim == 2 else given
        if controls.ndim != 3 or controls.shape[::2] != (n, model.nu) or not controls.shape[1]:
            raise ProblemError(f"control must have shape ({n}, T, {model.nu}), got {given.shape}")
        if nstep is not None and nstep != controls.shape[1]:
            raise ProblemError(f"control has {controls.shape[1]} steps, nstep says {nstep}")
    if state is None:
        return starts, controls, None
    reached = real_array("state", state)
    reached = reached[None] if reached.ndim == 2 else reached
    if reached.shape != (n, controls.shape[1], size):
        raise ProblemError(f"state must have shape ({n}, {controls.shape[1]}, {size}), got {reached.shape}")
    return starts, controls, reached


def _log_one(
    mujoco: Any, model: Any, start: FloatArray, controls: FloatArray, reached: FloatArray | None,
    robot: str | None,
) -> Log:  # fmt: skip
    """Return the log of one rollout."""
    data, kind = mujoco.MjData(model), mujoco.mjtState.mjSTATE_FULLPHYSICS
    mujoco.mj_setState(model, data, start, kind)
    now = np.zeros(len(start))
    with record(model, data, robot) as log:
        for t, control in enumerate(controls):
            data.ctrl[:] = control
            mujoco.mj_step(model, data)
            if reached is None:
                continue
            mujoco.mj_getState(model, data, now, kind)
            if not (np.abs(now - reached[t]) <= DIFFERENCE * (1.0 + np.abs(now))).all():
                raise ProblemError(
                    f"the steps made again leave the rollout's states at step {t}: was it another model, "
                    "other controls, or an initial_warmstart?"
                )
    return log
