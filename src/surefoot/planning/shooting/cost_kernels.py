"""What a motion costs, its gradient and its Gauss-Newton Hessian, compiled; `costs` says what the terms are.

Every term is half a weighted sum of squared residuals r, so that ∇l = Jᵀ w r and ∇²l ≈ Jᵀ w J with J = ∂r/∂x.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.numerics.cholesky import product
from surefoot.numerics.rotations import rotation_of
from surefoot.planning.shooting.state_space import turn_between

StateTable = tuple[FloatArray, FloatArray, FloatArray]
"""Weights (N + 1, 2nv), and the wanted q (N + 1, nq) and v (N + 1, nv)."""
TorqueTable = tuple[FloatArray, FloatArray]
"""R (m, m), and the wanted torques (N, m)."""
FootTable = tuple[FloatArray, FloatArray]
"""Weights of slip and landing (N, 2, p), and the gaps (2,) over which they fade."""
JointTable = tuple[FloatArray, FloatArray, FloatArray]
"""Bounds (2, 2m) on joint positions and speeds, weights (2m,) of what is beyond, coupling (2m, 2m)."""


@inline_kernel
def _less(a: FloatArray, b: FloatArray, R: FloatArray, out: FloatArray) -> None:
    """Fill out (3,) with a - Rᵀ b."""
    for i in range(3):
        out[i] = a[i] - (R[0, i] * b[0] + R[1, i] * b[1] + R[2, i] * b[2])


@inline_kernel
def state_error(
    floating: bool, q: FloatArray, v: FloatArray, wanted_q: FloatArray, wanted_v: FloatArray, out: FloatArray
) -> None:
    """Fill out (2nv,) with a state's residuals.

    Of a free flyer: its place less the wanted one in world axes, the rotation vector of R_wantedᵀ R, and its
    velocities less the wanted ones, which are given in world axes, in its own axes.
    """
    n, first, shift = v.size, 0, 0
    if floating:
        R = np.empty((3, 3))
        first, shift = 6, 1
        rotation_of(q, R)
        for i in range(3):
            out[i] = q[i] - wanted_q[i]
        turn_between(wanted_q, q, out[3:6])
        _less(v[:3], wanted_v[:3], R, out[n : n + 3])
        _less(v[3:6], wanted_v[3:6], R, out[n + 3 : n + 6])
    for i in range(first, n):
        out[i] = q[i + shift] - wanted_q[i + shift]
        out[n + i] = v[i] - wanted_v[i]


@inline_kernel
def _fill_skew(x: float, y: float, z: float, sign: float, out: FloatArray) -> None:
    out[0, 0] = out[1, 1] = out[2, 2] = 0.0
    out[0, 1], out[0, 2], out[1, 2] = -sign * z, sign * y, -sign * x
    out[1, 0], out[2, 0], out[2, 1] = sign * z, -sign * y, sign * x


@inline_kernel
def _log_rate(turn: FloatArray, out: FloatArray) -> None:
    """Fill out (3, 3) with the derivative of the rotation vector of R exp(x) by x at zero."""
    square = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]
    angle = math.sqrt(square)
    c = 1.0 / 12.0
    if angle > 1e-4:
        c = (1.0 - 0.5 * angle * math.sin(angle) / (1.0 - math.cos(angle))) / square
    _fill_skew(turn[0], turn[1], turn[2], 0.5, out)
    for i in range(3):
        for j in range(3):
            out[i, j] += c * turn[i] * turn[j]
        out[i, i] += 1.0 - c * square


@inline_kernel
def _base_rates(q: FloatArray, error: FloatArray, v: FloatArray, n: int, out: FloatArray) -> None:
    """Fill out (12, 12) with the derivative of the free flyer's residuals (place, turn, velocities)."""
    R, part = np.empty((3, 3)), np.empty((3, 3))
    rotation_of(q, R)
    out[:] = 0.0
    _log_rate(error[3:6], part)
    for i in range(3):
        for j in range(3):
            out[i, j], out[3 + i, 3 + j] = R[i, j], part[i, j]
        out[6 + i, 6 + i] = out[9 + i, 9 + i] = 1.0
    for half in range(2):  # wanted velocity in body axes: Rᵀ w = v - e turns with the body
        f = 3 * half
        x, y, z = v[f] - error[n + f], v[f + 1] - error[n + f + 1], v[f + 2] - error[n + f + 2]
        _fill_skew(x, y, z, -1.0, part)
        for i in range(3):
            for j in range(3):
                out[6 + f + i, 3 + j] = part[i, j]


@inline_kernel
def _add_state(
    floating: bool, q: FloatArray, v: FloatArray, weights: FloatArray, error: FloatArray, lx: FloatArray,
    lxx: FloatArray,
) -> None:  # fmt: skip
    """Add gradient and Hessian of the state's residuals."""
    n = v.size
    first = 6 if floating else 0
    if floating:
        J, scaled, H = np.empty((12, 12)), np.empty((12, 12)), np.empty((12, 12))
        _base_rates(q, error, v, n, J)
        for r in range(12):
            at = r if r < 6 else n + r - 6
            w = weights[at]
            for j in range(12):
                scaled[r, j] = w * J[r, j]
                lx[j if j < 6 else n + j - 6] += scaled[r, j] * error[at]
        product(J.T, scaled, H)
        for i in range(12):
            for j in range(12):
                lxx[i if i < 6 else n + i - 6, j if j < 6 else n + j - 6] += H[i, j]
    for half in range(2):
        for i in range(first, n):
            at = half * n + i
            lx[at] += weights[at] * error[at]
            lxx[at, at] += weights[at]


@inline_kernel
def _beyond(x: float, low: float, high: float) -> float:
    """Return how far a number is outside its bounds."""
    return x - high if x > high else (x - low if x < low else 0.0)


@inline_kernel
def _joints_cost(
    floating: bool, q: FloatArray, v: FloatArray, table: JointTable, error: FloatArray, slope: FloatArray
) -> float:
    """Return the cost of joints beyond their bounds and of their coupling; fill its slope (2m,)."""
    bounds, weights, coupling = table
    m, n, total = weights.size // 2, v.size, 0.0
    base = n - m
    shift = base + 1 if floating else base
    for i in range(m):
        a = _beyond(q[shift + i], bounds[0, i], bounds[1, i])
        b = _beyond(v[base + i], bounds[0, m + i], bounds[1, m + i])
        slope[i], slope[m + i] = weights[i] * a, weights[m + i] * b
        total += 0.5 * (slope[i] * a + slope[m + i] * b)
    if coupling.size:
        for i in range(2 * m):
            at, s = base + i if i < m else n + base + i - m, 0.0
            for j in range(2 * m):
                s += coupling[i, j] * error[base + j if j < m else n + base + j - m]
            slope[i] += s
            total += 0.5 * s * error[at]
    return total


@inline_kernel
def _add_joints(
    floating: bool, q: FloatArray, v: FloatArray, table: JointTable, slope: FloatArray, lx: FloatArray,
    lxx: FloatArray,
) -> None:  # fmt: skip
    """Add gradient and Hessian of `_joints_cost`."""
    bounds, weights, coupling = table
    m, n = weights.size // 2, v.size
    base = n - m
    shift = base + 1 if floating else base
    for i in range(m):
        lx[base + i] += slope[i]
        lx[n + base + i] += slope[m + i]
        if _beyond(q[shift + i], bounds[0, i], bounds[1, i]) != 0.0:
            lxx[base + i, base + i] += weights[i]
        if _beyond(v[base + i], bounds[0, m + i], bounds[1, m + i]) != 0.0:
            lxx[n + base + i, n + base + i] += weights[m + i]
    if coupling.size:
        for i in range(2 * m):
            for j in range(2 * m):
                s = coupling[i, j]
                if s != 0.0:
                    lxx[base + i if i < m else n + base + i - m, base + j if j < m else n + base + j - m] += s


@inline_kernel
def _closeness(gap: float, width: float) -> tuple[float, float]:
    """Return c = (1 / (1 + exp(gap / width)))^½, near one on the ground and zero above it, and dc / dgap."""
    x = min(max(gap / width, -60.0), 60.0)
    share = 1.0 / (1.0 + math.exp(x))
    c = math.sqrt(share)
    return c, -0.5 * c * (1.0 - share) / width


@inline_kernel
def _speed(J: FloatArray, row: int, v: FloatArray) -> float:
    total = 0.0
    for j in range(v.size):
        total += J[row, j] * v[j]
    return total


@inline_kernel
def _feet_cost(
    v: FloatArray,
    J: FloatArray,
    gaps: FloatArray,
    weights: FloatArray,
    widths: FloatArray,
) -> float:
    """Return the cost of feet that slip near the ground, or land fast."""
    total = 0.0
    for c in range(gaps.size):
        for a in range(3):
            weight = weights[a // 2, c]
            if weight > 0.0:
                move = _closeness(gaps[c], widths[a // 2])[0] * _speed(J, 3 * c + a, v)
                total += 0.5 * weight * move * move
    return total


@inline_kernel
def _add_row(weight: float, row: FloatArray, residual: float, lx: FloatArray, lxx: FloatArray) -> None:
    """Add gradient and Hessian of a residual with its derivative."""
    for i in range(row.size):
        s = weight * row[i]
        if s != 0.0:
            lx[i] += s * residual
            for j in range(row.size):
                lxx[i, j] += s * row[j]


@inline_kernel
def _add_feet(
    v: FloatArray, place: tuple[FloatArray, FloatArray, FloatArray], weights: FloatArray,
    widths: FloatArray, lx: FloatArray, lxx: FloatArray,
) -> None:  # fmt: skip
    """Add gradient and Hessian of `_feet_cost`; `place` holds J, the derivative of J v by q, and the gaps."""
    J, rates, gaps = place
    n = v.size
    row = np.empty(2 * n)
    for c in range(gaps.size):
        normal = 3 * c + 2
        for a in range(3):
            weight = weights[a // 2, c]
            if weight > 0.0:
                near, slope = _closeness(gaps[c], widths[a // 2])
                speed = _speed(J, 3 * c + a, v)
                for j in range(n):
                    row[j] = near * rates[3 * c + a, j] + slope * speed * J[normal, j]
                    row[n + j] = near * J[3 * c + a, j]
                _add_row(weight, row, near * speed, lx, lxx)


@inline_kernel
def _torque_cost(torques: FloatArray, R: FloatArray, wanted: FloatArray, lu: FloatArray) -> float:
    """Fill lu with R (u - wanted) and return half its product with u - wanted."""
    total = 0.0
    for i in range(torques.size):
        lu[i] = 0.0
        for j in range(torques.size):
            lu[i] += R[i, j] * (torques[j] - wanted[j])
        total += 0.5 * lu[i] * (torques[i] - wanted[i])
    return total


@kernel
def motion_cost(
    floating: bool,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    feet: tuple[FloatArray, FloatArray, FloatArray],
    state: StateTable, torque: TorqueTable, foot: FootTable, joint: JointTable,
) -> float:  # fmt: skip
    """Return the cost of N knots.

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    motion
        q (N + 1, nq), v (N + 1, nv) and torques (N, m).
    feet
        Contact Jacobians (N, 3p, nv) in contact axes at the knots' starts, the derivatives of J v by q (not
        read here), and gaps (N, p).
    state, torque, foot, joint
        See `Costs.tables`.
    """
    q, v, torques = motion
    N, n = torques.shape[0], v.shape[1]
    error, slope, lu, total = np.empty(2 * n), np.empty(joint[1].size), np.empty(torques.shape[1]), 0.0
    for k in range(N + 1):
        state_error(floating, q[k], v[k], state[1][k], state[2][k], error)
        for i in range(2 * n):
            total += 0.5 * state[0][k, i] * error[i] * error[i]
        total += _joints_cost(floating, q[k], v[k], joint, error, slope)
        if k < N:
            total += _torque_cost(torques[k], torque[0], torque[1][k], lu)
            total += _feet_cost(v[k], feet[0][k], feet[2][k], foot[0][k], foot[1])
    return total


@kernel
def cost_slopes(
    floating: bool,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    feet: tuple[FloatArray, FloatArray, FloatArray],
    state: StateTable, torque: TorqueTable, foot: FootTable, joint: JointTable,
    lx: FloatArray, lxx: FloatArray, lu: FloatArray, luu: FloatArray,
) -> None:  # fmt: skip
    """Fill gradients (N + 1, 2nv), (N, m) and Gauss-Newton Hessians of `motion_cost`, knot by knot.

    Parameters
    ----------
    floating, motion, feet, state, torque, foot, joint
        As for `motion_cost`.
    lx, lxx, lu, luu
        To be filled: (N + 1, 2nv), (N + 1, 2nv, 2nv), (N, m), (N, m, m).
    """
    q, v, torques = motion
    J, rates, gaps = feet
    N, n = torques.shape[0], v.shape[1]
    error, slope = np.empty(2 * n), np.empty(joint[1].size)
    lx[:] = 0.0
    lxx[:] = 0.0
    for k in range(N + 1):
        state_error(floating, q[k], v[k], state[1][k], state[2][k], error)
        _add_state(floating, q[k], v[k], state[0][k], error, lx[k], lxx[k])
        _joints_cost(floating, q[k], v[k], joint, error, slope)
        _add_joints(floating, q[k], v[k], joint, slope, lx[k], lxx[k])
        if k < N:
            _torque_cost(torques[k], torque[0], torque[1][k], lu[k])
            luu[k] = torque[0]
            _add_feet(v[k], (J[k], rates[k], gaps[k]), foot[0][k], foot[1], lx[k], lxx[k])
