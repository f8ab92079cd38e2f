"""What a motion costs, its gradient and its Gauss-Newton Hessian; `costs` says what the terms are.

Every term is half a weighted sum of squared residuals r, so that ∇l = Jᵀ w r and ∇²l ≈ Jᵀ w J with J = ∂r/∂x.
All knots at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import skew

StateTable = tuple[FloatArray, FloatArray, FloatArray]
"""Weights (N + 1, 2nv), and the wanted q (N + 1, nq) and v (N + 1, nv)."""
TorqueTable = tuple[FloatArray, FloatArray]
"""R (m, m), and the wanted torques (N, m)."""
FootTable = tuple[FloatArray, FloatArray]
"""Weights of slip and landing (N, 2, p), and the gaps (2,) over which they fade."""
JointTable = tuple[FloatArray, FloatArray, FloatArray]
"""Bounds (2, 2m) on joint positions and speeds, weights (2m,) of what is beyond, coupling (2m, 2m)."""
Motion = tuple[FloatArray, FloatArray, FloatArray]
"""q (N + 1, nq), v (N + 1, nv) and torques (N, m)."""
Feet = tuple[FloatArray, FloatArray, FloatArray]
"""Contact Jacobians (N, 3p, nv) in contact axes at the knots' starts, the derivatives of J v by q, and the
gaps (N, p)."""
KIND = np.array([0, 0, 1])
"""Which weight and width a contact's axes have: slip or landing."""


class Tables(NamedTuple):
    """Costs over a horizon as arrays; they may be written to."""

    state: StateTable
    torque: TorqueTable
    foot: FootTable
    joint: JointTable


def state_errors(floating: bool, motion: Motion, state: StateTable) -> FloatArray:
    """Return the residuals of all states (N + 1, 2nv).

    Of a free flyer: its place less the wanted one in world axes, the rotation vector of R_wantedᵀ R, and its
    velocities less the wanted ones, which are given in world axes, in its own axes.
    """
    (q, v, _), (_, wanted_q, wanted_v) = motion, state
    if not floating:
        return np.hstack([q - wanted_q, v - wanted_v])
    turn = Rotation.from_quat(q[:, 3:7])
    turned = (Rotation.from_quat(wanted_q[:, 3:7]).inv() * turn).as_rotvec()
    own = (wanted_v[:, :6].reshape(-1, 2, 3) @ turn.as_matrix()).reshape(-1, 6)
    place, joints = q[:, :3] - wanted_q[:, :3], q[:, 7:] - wanted_q[:, 7:]
    return np.hstack([place, turned, joints, v[:, :6] - own, v[:, 6:] - wanted_v[:, 6:]])


def _base_rates(motion: Motion, error: FloatArray) -> FloatArray:
    """Return the derivatives (N + 1, 12, 12) of the free flyer's residuals (place, turn, velocities)."""
    q, v, _ = motion
    n, S = v.shape[1], skew(error[:, 3:6])
    angle = np.linalg.norm(error[:, 3:6], axis=1)
    some = np.where(angle > 1e-4, angle, 1.0)
    # Inverse right Jacobian of SO(3), 1 + S/2 + c S²; below 1e-4 rad 1 - cos loses all digits, and 1/12 is
    # the limit.
    c = np.where(angle > 1e-4, (1.0 - 0.5 * some * np.sin(some) / (1.0 - np.cos(some))) / some**2, 1.0 / 12.0)
    out = np.tile(np.eye(12), (len(q), 1, 1))
    out[:, :3, :3] = Rotation.from_quat(q[:, 3:7]).as_matrix()
    # the rotation vector of R exp(x) by x at zero
    out[:, 3:6, 3:6] += 0.5 * S + c[:, None, None] * (S @ S)
    # wanted velocity in body axes: Rᵀ w = v - e turns with the body
    out[:, 6:9, 3:6] = -skew(v[:, :3] - error[:, n : n + 3])
    out[:, 9:, 3:6] = -skew(v[:, 3:6] - error[:, n + 3 : n + 6])
    return out


def _joint_columns(n: int, m: int) -> IntArray:
    """Return the places (2m,) of the joints' positions and speeds in a tangent (2n,)."""
    return np.concatenate([np.arange(n - m, n), np.arange(2 * n - m, 2 * n)])


def _beyond(motion: Motion, joint: JointTable) -> FloatArray:
    """Return how far joints' positions and speeds are outside their bounds (N + 1, 2m)."""
    (q, v, torques), bounds = motion, joint[0]
    m = torques.shape[1]
    x = np.hstack([q[:, q.shape[1] - m :], v[:, v.shape[1] - m :]])
    return np.asarray(x - np.clip(x, bounds[0], bounds[1]))


def _near(feet: Feet, foot: FootTable) -> FloatArray:
    """Return c = (1 / (1 + exp(gap / width)))^½ (N, p, 3), near one on the ground and zero above it."""
    gaps, widths = feet[2], foot[1]
    # Clipped before exp can overflow: exp(±60) is nothing beside one, or all.
    share = np.clip(gaps[:, :, None] / widths, -60.0, 60.0)
    return (1.0 / np.sqrt(1.0 + np.exp(share)))[:, :, KIND]


def _point_speeds(motion: Motion, feet: Feet) -> FloatArray:
    """Return the velocities of the contact points (N, p, 3) in contact axes."""
    N, rows, _ = feet[0].shape
    return (feet[0] @ motion[1][:-1, :, None]).reshape(N, rows // 3, 3)


def motion_cost(floating: bool, motion: Motion, feet: Feet, tables: Tables) -> float:
    """Return the cost of N knots.

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    motion, feet
        See `Motion`, `Feet`; the derivatives of J v are not read here.
    tables
        See `Costs.tables`.
    """
    state, torque, foot, joint = tables
    error, over = state_errors(floating, motion, state), _beyond(motion, joint)
    off, coupling = motion[2] - torque[1], joint[2]
    total = np.sum(state[0] * error**2) + np.sum(joint[1] * over**2) + np.sum((off @ torque[0]) * off)
    if coupling.size:
        tied = error[:, _joint_columns(motion[1].shape[1], off.shape[1])]
        total += np.sum((tied @ coupling) * tied)
    if foot[0].any():
        weights = foot[0].transpose(0, 2, 1)[:, :, KIND]
        total += np.sum(weights * (_near(feet, foot) * _point_speeds(motion, feet)) ** 2)
    return 0.5 * float(total)


def cost_slopes(
    floating: bool, motion: Motion, feet: Feet, tables: Tables
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return gradients and Gauss-Newton Hessians of `motion_cost`, whose parameters these are.

    Returns
    -------
    (N + 1, 2nv), (N + 1, 2nv, 2nv), (N, m), (N, m, m)
        By the states, and by the torques.
    """
    state, torque, foot, joint = tables
    R, (N, m), n = torque[0], motion[2].shape, motion[1].shape[1]
    error, over = state_errors(floating, motion, state), _beyond(motion, joint)
    lx, lxx = state[0] * error, np.zeros((N + 1, 2 * n, 2 * n))
    each, cols = np.arange(2 * n), _joint_columns(n, m)
    lxx[:, each, each] = state[0]
    if floating:
        base, J = np.r_[:6, n : n + 6], _base_rates(motion, error)
        lx[:, base] = np.einsum("kij,ki->kj", J, lx[:, base])
        lxx[:, base[:, None], base] = J.transpose(0, 2, 1) @ (state[0][:, base, None] * J)
    lx[:, cols] += joint[1] * over
    # Gauss-Newton of max(0, .)²: a slope only where the bound is passed.
    lxx[:, cols, cols] += joint[1] * (over != 0.0)
    if joint[2].size:
        lx[:, cols] += error[:, cols] @ joint[2]
        lxx[:, cols[:, None], cols] += joint[2]
    if foot[0].any():
        near, speeds = _near(feet, foot), _point_speeds(motion, feet)
        weights = foot[0].transpose(0, 2, 1)[:, :, KIND].reshape(N, -1)
        # dc/dgap = -c (1 - c²) / (2 width) for c² = 1 / (1 + exp(gap / width)); a point's gap grows with its
        # normal velocity, whose row of J is the gap's gradient.
        fading = -0.5 * near * (1.0 - near**2) / foot[1][KIND] * speeds
        rows = near.reshape(N, -1, 1) * np.concatenate([feet[1], feet[0]], axis=2)
        rows[:, :, :n] += fading.reshape(N, -1, 1) * np.repeat(feet[0][:, 2::3], 3, axis=1)
        scaled = weights[:, :, None] * rows
        lx[:-1] += np.einsum("kij,ki->kj", scaled, (near * speeds).reshape(N, -1))
        lxx[:-1] += rows.transpose(0, 2, 1) @ scaled
    return lx, lxx, (motion[2] - torque[1]) @ R, np.tile(R, (N, 1, 1))
