"""The arithmetic of the wrench observer: what pushes a robot from outside."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.vectors import cross
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.detection_kernels import foot_forces

DAMPING, SOLE_DAMPING = 0.005, 0.0005
"""Share of a leg's lever below which its foot's force is damped, see `foot_forces`; for soles: there turns
count beside the levers, which are short."""


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
    rest, forces, speeds, wrench = np.empty(nv), np.empty((n, 6)), np.empty((n, 3)), np.zeros(6)
    for i in range(nv):
        rest[i] = bias[i] - (torques[i - 6] if i >= 6 else 0.0)
        for j in range(nv):
            rest[i] += M[i, j] * (after[j] - v[j]) / dt
    # `rest` = M a + h - Sᵀ τ: its joints' rows are the feet's Jᵀ f, its base's rows the feet's and the
    # outside's.
    foot_forces(twists, support, points, flat, rest, v, SOLE_DAMPING if flat[0] else DAMPING, forces, speeds)
    for a in range(3):
        for b in range(3):
            wrench[a] += pose[a, b] * rest[b]
            wrench[3 + a] += pose[a, b] * rest[3 + b]
    for k in range(n):
        if not touching[k]:
            continue
        # What the ground gives, at the foot, is taken off.
        arm = points[k, 0] - pose[0, 3], points[k, 1] - pose[1, 3], points[k, 2] - pose[2, 3]
        turn = cross(arm, (forces[k, 0], forces[k, 1], forces[k, 2]))
        for a in range(3):
            wrench[a] -= forces[k, a]
            wrench[3 + a] -= turn[a] + forces[k, 3 + a]
    # Weight of a load that the model has already, put back as an outside wrench: the filter estimates all of
    # it.
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
def tell_wrench(
    wrench: FloatArray, share: float, unit: FloatArray, rotation: FloatArray, base: FloatArray,
    com: FloatArray, on_base: FloatArray, on_com: FloatArray,
) -> None:  # fmt: skip
    """Fill a wrench, bounded, as it acts on the base in its own axes and about the centre of mass.

    Parameters
    ----------
    wrench, share, unit
        (6,) force and moment about the base's origin, world axes, each bounded by a share of its (6,) unit
        [N, N m].
    rotation, base, com
        (3, 3) of the base in the world; (3,) places of its origin and of the centre of mass [m].
    on_base, on_com
        Filled: (6,) about the base's origin, base axes; about the centre of mass, world axes [N, N m].
    """
    for a in range(6):
        most = share * unit[a]
        on_com[a] = min(max(wrench[a], -most), most)
    for a in range(3):
        on_base[a] = on_base[3 + a] = 0.0
        for b in range(3):
            on_base[a] += rotation[b, a] * on_com[b]
            on_base[3 + a] += rotation[b, a] * on_com[3 + b]
    arm = base[0] - com[0], base[1] - com[1], base[2] - com[2]
    # The moment moves from the base's origin to the centre of mass: + (base - com) x f.
    turn = cross(arm, (on_com[0], on_com[1], on_com[2]))
    for a in range(3):
        on_com[3 + a] += turn[a]


@kernel
def filter_wrench(
    state: FloatArray, covariance: FloatArray, wrench: FloatArray, rotation: FloatArray, noise: FloatArray,
    keep: FloatArray, drive: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Take a Kalman filter's step: states that fade, then wrench = weight of the load + rest + noise.

    All in units in which gravity is one; returned are state and covariance after it.

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
    # Wrench of a load in units of gravity: force (0, 0, -m), moment R (m r) x (0, 0, -1), linear in m and m
    # r.
    x, P = keep * state, keep[:, None] * covariance * keep + np.diag(drive)
    H = np.zeros((6, 10))
    H[:, 4:] = np.eye(6)
    H[2, 0], H[3, 1:4], H[4, 1:4] = -1.0, -rotation[1, :3], rotation[0, :3]
    gain = np.linalg.solve(H @ P @ H.T + np.diag(noise), H @ P).T
    return x + gain @ (wrench - H @ x), P - gain @ H @ P
