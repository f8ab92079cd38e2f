"""MuJoCo's Runge-Kutta method with the exact law in each of its four stages.

Every stage's forces are those with which a whole step from the step's first velocity would be lawful: the
velocity that the four make together is a mean of lawful ones, with positive weights, and so lawful where the
contacts stay the same.

Where nothing touches in any stage the step is MuJoCo's own: its method for turning bodies is of a higher
order than the mean of angular velocities that is taken here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray

AHEAD = (0.5, 0.5, 1.0)
"""Shares of the step at which stages two to four are evaluated, each from the one before."""
WEIGHTS = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)


def finish_runge_kutta(
    mujoco: Any, model: Any, data: Any, evaluate: Callable[[Any, FloatArray], None]
) -> None:
    """Advance the data, of which the first stage is evaluated; see `mj_RungeKutta`."""
    h, time = float(model.opt.timestep), data.time
    q, v, act = data.qpos.copy(), data.qvel.copy(), data.act.copy()
    if data.nefc == 0:
        first, first_dot = data.qacc.copy(), data.act_dot.copy()
        mujoco.mj_RungeKutta(model, data, 4)
        if data.nefc == 0:
            return
        # something touched on the way: once more, from the state at the start
        data.time, data.qpos[:], data.qvel[:], data.act[:] = time, q, v, act
        data.qacc[:], data.act_dot[:] = first, first_dot
    speeds, rates, acts = [v], [data.qacc.copy()], [data.act_dot.copy()]
    for share in AHEAD:
        place = q.copy()
        mujoco.mj_integratePos(model, place, speeds[-1], share * h)
        speeds.append(v + share * h * rates[-1])
        data.qpos[:], data.qvel[:], data.act[:] = place, speeds[-1], act + share * h * acts[-1]
        data.time = time + share * h
        evaluate(data, v)
        rates.append(data.qacc.copy())
        acts.append(data.act_dot.copy())
    mean_speed = sum(w * s for w, s in zip(WEIGHTS, speeds, strict=True))
    rate = sum(w * r for w, r in zip(WEIGHTS, rates, strict=True))
    last, last_dot = data.qacc.copy(), data.act_dot.copy()
    data.time, data.qpos[:], data.qvel[:], data.act[:] = time, q, v, act
    # activations and the clock advance as MuJoCo's do: an Euler step without implicit damping
    data.qacc[:] = rate
    data.act_dot[:] = sum(w * a for w, a in zip(WEIGHTS, acts, strict=True))
    flags, bit = int(model.opt.disableflags), int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    model.opt.disableflags = flags | bit
    try:
        mujoco.mj_Euler(model, data)
    finally:
        model.opt.disableflags = flags
    data.qacc[:], data.act_dot[:] = last, last_dot
    data.qacc_warmstart[:] = last
    data.qpos[:] = q
    mujoco.mj_integratePos(model, data.qpos, np.ascontiguousarray(mean_speed), h)
