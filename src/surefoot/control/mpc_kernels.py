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
    given: mpc_model.Given, body: mpc_model.Body, points: FloatArray, passes: int, tol: float, patience: int,
    limit: int,
) -> tuple[int, int, float, FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return the verdict on the input, the steps, the error bound [N] and what `mpc_model.finish` does.

    Parameters
    ----------
    given, body
        See `mpc_model`.
    points
        (N, n, 3) guess of the points, see `dual_newton.horizon.newton`; those of the answer on return.
    passes
        Convex programs; from the second on with the sway of the plan before.
    tol, patience, limit
        As for `newton`.
    """
    N, n = given.contacts.shape
    reference, dt = given.reference, body.dt
    sway, cost = (
        mpc_model.expected_sway(given.motion, reference, dt),
        tracking(body.weights, body.terminal, dt, N),
    )
    total, error, verdict = 0, math.inf, mpc_model.GOOD
    forces, world = np.empty((N, n, 3)), np.empty((N, n, 3))
    planned, turn = np.empty((N + 1, 3, 3)), np.empty((N + 1, 3))
    for _ in range(passes):
        verdict, step, foot, M, limits, centre, q, drift, heading = mpc_model.build(given, body, sway)
        if verdict != mpc_model.GOOD:
            break
        force = np.empty((step.size, 3))
        count, error = newton(
            cost, q, step, foot, M, limits, centre, body.rho, tol, patience, limit, points, force
        )
        if not math.isfinite(error):
            verdict = mpc_model.NOT_FINITE
            break
        total += count
        forces, world, planned, turn = mpc_model.finish(
            step, foot, M, force, drift, given.frames, heading, reference, dt
        )
        for k in range(N):
            for a in range(3):  # as planned, over each step
                off = planned[k, 0, a] - reference[k, 0, a]
                sway[k, a] = 0.5 * (off + planned[k + 1, 0, a] - reference[k + 1, 0, a])
    return verdict, total, error, forces, world, planned, turn
