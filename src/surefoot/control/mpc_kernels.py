"""A whole plan in one compiled call: the model of the horizon, the solve, and the motion that follows.

Each call from Python into a kernel takes as long as a Newton step over a few steps of the horizon.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control import mpc_model
from surefoot.kernels import kernel
from surefoot.solvers.dual_newton.horizon import newton


@kernel
def plan_forces(
    contacts: BoolArray, feet: FloatArray, frames: FloatArray, bounds: FloatArray, rotation: FloatArray,
    motion: FloatArray, ref_rotation: FloatArray, reference: FloatArray, points: FloatArray, mass: float,
    inverse: FloatArray, weights: FloatArray, terminal: float, rho: float, dt: float, outside: FloatArray,
    fading: float, passes: int, tol: float, patience: int, limit: int,
) -> tuple[int, int, float, FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return the verdict on the input, the steps, the error bound [N] and what `mpc_model.finish` does.

    Parameters
    ----------
    contacts, feet, frames, bounds, rotation, motion, ref_rotation, reference
        As for `mpc_model.build`, and so are mass, inverse, weights, terminal, dt, outside and fading.
    points
        (N, n, 3) guess of the points, see `dual_newton.horizon.newton`; those of the answer on return.
    rho, tol, patience, limit
        As for `newton`.
    passes
        Convex programs; from the second on with the sway of the plan before.
    """
    N, n = contacts.shape
    sway = mpc_model.expected_sway(motion, reference, dt)
    total, error, verdict = 0, math.inf, mpc_model.GOOD
    forces, world = np.empty((N, n, 3)), np.empty((N, n, 3))
    planned, turn = np.empty((N + 1, 3, 3)), np.empty((N + 1, 3))
    for _ in range(passes):
        verdict, step, foot, M, limits, centre, q, drift, heading = mpc_model.build(
            rotation, motion, ref_rotation, reference, feet, contacts, frames, bounds, mass, inverse, weights,
            terminal, dt, outside, fading, sway,
        )  # fmt: skip
        if verdict != mpc_model.GOOD:
            break
        force = np.empty((step.size, 3))
        count, error = newton(
            weights, terminal, dt, q, step, foot, M, limits, centre, rho, tol, patience, limit, points, force
        )
        if not math.isfinite(error):
            verdict = mpc_model.NOT_FINITE
            break
        total += count
        forces, world, planned, turn = mpc_model.finish(
            step, foot, M, force, drift, frames, heading, reference, dt
        )
        for k in range(N):
            for a in range(3):  # as planned, over each step
                off = planned[k, 0, a] - reference[k, 0, a]
                sway[k, a] = 0.5 * (off + planned[k + 1, 0, a] - reference[k + 1, 0, a])
    return verdict, total, error, forces, world, planned, turn
