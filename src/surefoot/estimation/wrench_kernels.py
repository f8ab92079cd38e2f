"""The arithmetic of the wrench observer: what pushes a robot from outside, and a Kalman filter's step."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.estimation.detection_kernels import foot_forces
from surefoot.kernels import kernel
from surefoot.numerics.vectors import cross
from surefoot.spatial import GRAVITY

DAMPING = 0.005
"""Share of a leg's lever below which its foot's force is damped, see `foot_forces`."""


@kernel
def sum_wrench(
    M: FloatArray, bias: FloatArray, v: FloatArray, after: FloatArray, dt: float, torques: FloatArray,
    twists: FloatArray, support: BoolArray, points: FloatArray, flat: BoolArray, touching: BoolArray,
    pose: FloatArray, load: FloatArray, total: FloatArray,
) -> None:  # fmt: skip
    """Add to `total` (6,) what the base's rows of M a + h = Sᵀ τ + Σ Jᵀ f + w leave: world axes [N, N m].

    The force f of a foot that touches is what its leg's own rows of the same equation ask for; the moment is
    about the base's origin.

    Parameters
    ----------
    M, bias
        (nv, nv), (nv,) mass matrix and bias forces at the start of a step [kg, N, N m].
    v, after, dt
        (nv,) velocity then and at its end [m/s, rad/s], and its length [s].
    torques
        (joints,) of the motors during it [N m].
    twists, support, points, flat
        As for `foot_forces`.
    touching
        (n,) which feet may push.
    pose
        (3, 4) rotation and place of the base in the world [-, m].
    load
        (4,) mass [kg] and first moment in base axes [kg m] of a load that M and bias know already: its weight
        is added.
    """
    nv, n = v.shape[0], points.shape[0]
    rest, forces, speeds, wrench = np.empty(nv), np.empty((n, 3)), np.empty((n, 3)), np.zeros(6)
    for i in range(nv):
        rest[i] = bias[i] - (torques[i - 6] if i >= 6 else 0.0)
        for j in range(nv):
            rest[i] += M[i, j] * (after[j] - v[j]) / dt
    foot_forces(twists, support, points, flat, rest, v, DAMPING, forces, speeds)
    for a in range(3):
        for b in range(3):
            wrench[a] += pose[a, b] * rest[b]
            wrench[3 + a] += pose[a, b] * rest[3 + b]
    for k in range(n):
        if not touching[k]:
            continue
        arm = points[k, 0] - pose[0, 3], points[k, 1] - pose[1, 3], points[k, 2] - pose[2, 3]
        turn = cross(arm, (forces[k, 0], forces[k, 1], forces[k, 2]))
        for a in range(3):
            wrench[a] -= forces[k, a]
            wrench[3 + a] -= turn[a]
    wrench[2] -= load[0] * GRAVITY
    for j in range(3):
        wrench[3] -= GRAVITY * pose[1, j] * load[1 + j]
        wrench[4] += GRAVITY * pose[0, j] * load[1 + j]
    for a in range(6):
        total[a] += wrench[a]


@kernel
def point_inertia(arm: FloatArray) -> FloatArray:
    """Return the (3, 3) inertia of a unit mass at (3,) `arm` about the origin [m²]."""
    out = np.empty((3, 3))
    square = arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]
    for i in range(3):
        for j in range(3):
            out[i, j] = (square if i == j else 0.0) - arm[i] * arm[j]
    return out


@kernel
def filter_block(
    state: FloatArray, covariance: FloatArray, mean: FloatArray, last: FloatArray, spread: FloatArray,
    pose: FloatArray, noise: FloatArray, keep: FloatArray, drive: FloatArray, watch: float,
    bounds: FloatArray,
) -> None:  # fmt: skip
    """Take a block's mean wrench into the filter: noise is what blocks differ by, and loads are bounded.

    Parameters
    ----------
    state, covariance, pose, keep, drive
        As for `filter_wrench`.
    mean, last
        (6,) of this block, and of the one before: brought up, NaN at first.
    spread
        (6,) variance of the differences: brought up.
    noise
        (6,) least variances of the measurement.
    watch
        Share of the newest difference in the spread.
    bounds
        (6,) on the mean; least and most mass; furthest place, and the least mass that it counts for; on the
        rest.
    """
    for a in range(6):
        mean[a] = min(max(mean[a], -bounds[0]), bounds[0])
        change = mean[a] - last[a] if np.isfinite(last[a]) else 0.0
        spread[a] += watch * (0.5 * change * change - spread[a])
        last[a] = mean[a]
    filter_wrench(state, covariance, mean, pose, np.maximum(noise, spread), keep, drive)
    state[0] = min(max(state[0], bounds[1]), bounds[2])
    reach = bounds[3] * max(abs(state[0]), bounds[4])
    for j in range(1, 10):
        most = reach if j < 4 else bounds[5]
        state[j] = min(max(state[j], -most), most)


@kernel
def filter_wrench(
    state: FloatArray, covariance: FloatArray, wrench: FloatArray, rotation: FloatArray, noise: FloatArray,
    keep: FloatArray, drive: FloatArray,
) -> None:  # fmt: skip
    """Take a Kalman filter's step: states that fade, then wrench = weight of the load + rest + noise.

    All in units in which gravity is one.

    Parameters
    ----------
    state, covariance
        (10,), (10, 10): mass and first moment of the load in base axes, force and moment of the rest.
    wrench
        (6,) as measured, world axes.
    rotation
        (3, 3) or more columns: of the base in the world.
    noise
        (6,) variances of the measurement.
    keep, drive
        (10,) share of each state that is left, and variance that it gains.
    """
    n = state.shape[0]
    for i in range(n):
        state[i] *= keep[i]
        for j in range(n):
            covariance[i, j] *= keep[i] * keep[j]
        covariance[i, i] += drive[i]
    H, PH = np.empty(n), np.empty(n)
    for r in range(6):
        H[:] = 0.0
        H[4 + r] = 1.0
        if r == 2:
            H[0] = -1.0
        for j in range(3):
            if r == 3:
                H[1 + j] = -rotation[1, j]
            elif r == 4:
                H[1 + j] = rotation[0, j]
        missed, spread = wrench[r], noise[r]
        for i in range(n):
            PH[i] = 0.0
            for j in range(n):
                PH[i] += covariance[i, j] * H[j]
        for i in range(n):
            missed -= H[i] * state[i]
            spread += H[i] * PH[i]
        for i in range(n):
            gain = PH[i] / spread
            state[i] += gain * missed
            for j in range(n):
                covariance[i, j] -= gain * PH[j]


@kernel
def tell_wrench(
    wrench: FloatArray, most: FloatArray, rotation: FloatArray, base: FloatArray, com: FloatArray,
    on_base: FloatArray, on_com: FloatArray,
) -> None:  # fmt: skip
    """Fill a wrench, bounded, as it acts on the base in its own axes and about the centre of mass.

    Parameters
    ----------
    wrench, most
        (6,) force and moment about the base's origin, world axes, and the bound on each [N, N m].
    rotation, base, com
        (3, 3) of the base in the world; (3,) places of its origin and of the centre of mass [m].
    on_base, on_com
        Filled: (6,) about the base's origin, base axes; about the centre of mass, world axes [N, N m].
    """
    for a in range(6):
        on_com[a] = min(max(wrench[a], -most[a]), most[a])
    for a in range(3):
        on_base[a] = on_base[3 + a] = 0.0
        for b in range(3):
            on_base[a] += rotation[b, a] * on_com[b]
            on_base[3 + a] += rotation[b, a] * on_com[3 + b]
    arm = base[0] - com[0], base[1] - com[1], base[2] - com[2]
    turn = cross(arm, (on_com[0], on_com[1], on_com[2]))
    for a in range(3):
        on_com[3 + a] += turn[a]
