"""A whole plan in one compiled call: the model of the horizon, the solve, and the motion that follows.

Each call from Python into a kernel takes as long as a Newton step over a few steps of the horizon.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control import mpc_model
from surefoot.kernels import kernel
from surefoot.solvers.dual_newton.horizon import newton
from surefoot.solvers.dual_newton.riccati import tracking


@kernel
def plan_forces(
    given: mpc_model.Given, body: mpc_model.Body, points: FloatArray, tol: float, patience: int, limit: int
) -> tuple[int, int, float, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the verdict on the input, the steps, the error bound [N] and what `mpc_model.finish` does.

    Parameters
    ----------
    given, body
        See `mpc_model`.
    points
        (N, n, 3) guess of the points, see `dual_newton.horizon.newton`; those of the answer on return.
    tol, patience, limit
        As for `newton`.
    """
    reference, dt = given.reference, body.dt
    sway = mpc_model.expected_sway(given.motion, reference, dt)
    verdict, step, foot, M, limits, centre, q, drift, heading = mpc_model.build(given, body, sway)
    count, error, force = 0, math.inf, np.zeros((step.size, 3))
    if verdict == mpc_model.GOOD:
        cost = tracking(body.weights, body.terminal, dt, given.contacts.shape[0])
        count, error = newton(
            cost, q, step, foot, M, limits, centre, body.rho, tol, patience, limit, points, force
        )
        if not math.isfinite(error):
            verdict = mpc_model.NOT_FINITE
    forces, world, planned, turn = mpc_model.finish(
        step, foot, M, force, drift, given.frames, heading, reference, dt
    )
    return verdict, count, error, forces, world, planned, turn
