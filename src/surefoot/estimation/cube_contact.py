"""The corners of a cube on a plane: where they are, and the impulses they exchange with it.

Everything is in the axes of the plane (z its normal, the origin in it) and per unit of the cube's mass: an
impulse is a change of velocity [m/s]. The inertia is the same about every axis, so that of it only the
squared radius of gyration I / m enters.

Under the rigid law a corner that arrives with u_n leaves with at least -e u_n (Newton), and one that holds on
keeps its gap. Soft laws are taken implicitly, as compliance and bias of the same contact problem: the force
f = max(0, k p + d p') of a spring and damper at the end of a step of length t, where p = -(gap + t u_n), is

    0 <= f  ⟂  u_n + f / (k t + d) + k gap / (k t + d) >= 0,

and Hunt and Crossley's f = k p (1 + d p') is linearised about the velocity of the last pass, from above,
where Newton's method on a convex force converges without overshooting. Both share the Coulomb cone.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.compiled import UNSOLVED, WARM, solve_compiled

MU, RESTITUTION, HALF, RADIUS, GYRATION, GRAVITY, LAW, STIFFNESS, DAMPING = 0, 1, 2, 3, 4, 5, 8, 9, 10
SIZE = 11
"""Where a model keeps what, and its length; gravity takes three, stiffness and damping are per mass."""
RIGID, SPRING_DAMPER, HUNT_CROSSLEY = 0, 1, 2
"""Values of LAW."""
CLOSED = 2e-5
"""Gap up to which a corner touches [m]."""
RISE = 0.1
"""Share of a penetration that a closed corner takes back per step, at most at `RISE_SPEED` [m/s]."""
RISE_SPEED = 0.02
TOLERANCE, ITERATIONS = 1e-8, 400
"""Of a contact problem."""
PASSES, SAME = 4, 1e-6
"""Linearisations of a law that is not linear, and the change of velocity [m/s] that ends them."""


@inline_kernel
def place(state: FloatArray, model: FloatArray, arms: FloatArray, gaps: FloatArray) -> None:
    """Fill (8, 3) arms [m] from the centre to the lowest points of the corners, and their (8,) gaps."""
    x, y, z, w = state[3], state[4], state[5], state[6]
    a, r = model[HALF] - model[RADIUS], model[RADIUS]
    X0, X1, X2 = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)
    Y0, Y1, Y2 = 2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)
    Z0, Z1, Z2 = 2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)
    for k in range(8):
        p, q, s = (a if k & 1 else -a), (a if k & 2 else -a), (a if k & 4 else -a)
        arms[k, 0] = p * X0 + q * Y0 + s * Z0
        arms[k, 1] = p * X1 + q * Y1 + s * Z1
        arms[k, 2] = p * X2 + q * Y2 + s * Z2 - r
        gaps[k] = state[2] + arms[k, 2]


@inline_kernel
def rise(v: FloatArray, arms: FloatArray, k: int) -> float:
    """Return the normal velocity of a corner [m/s]; v is (6,), linear and angular."""
    return float(v[2] + v[3] * arms[k, 1] - v[4] * arms[k, 0])


@inline_kernel
def _fill(model: FloatArray, arms: FloatArray, near: IntArray, v: FloatArray, packed: FloatArray) -> None:
    """Fill G = 1 + [r]× (m / I) [r]×ᵀ of the near corners, and below it their free velocities g."""
    share = 1.0 / model[GYRATION]
    m = packed.shape[1]
    for i in range(m // 3):
        k = near[i]
        for j in range(m // 3):
            h = near[j]
            dot = arms[k, 0] * arms[h, 0] + arms[k, 1] * arms[h, 1] + arms[k, 2] * arms[h, 2]
            for a in range(3):
                for b in range(3):
                    entry = -share * arms[h, a] * arms[k, b]
                    if a == b:
                        entry += 1.0 + share * dot
                    packed[3 * i + a, 3 * j + b] = entry
        packed[m, 3 * i] = v[0] + v[4] * arms[k, 2] - v[5] * arms[k, 1]
        packed[m, 3 * i + 1] = v[1] + v[5] * arms[k, 0] - v[3] * arms[k, 2]
        packed[m, 3 * i + 2] = rise(v, arms, k)


@inline_kernel
def _soften(
    model: FloatArray, gaps: FloatArray, near: IntArray, t: float, speeds: FloatArray, packed: FloatArray
) -> None:
    """Add a soft law's compliance and bias to the normal rows, linearised at the (n,) normal speeds."""
    k, d = model[STIFFNESS], model[DAMPING]
    m = packed.shape[1]
    for i in range(m // 3):
        gap = gaps[near[i]]
        if model[LAW] == SPRING_DAMPER:
            slope, start = k * t + d, -k * gap  # f = start - slope u
        else:
            u = speeds[i]
            depth, more = max(0.0, -gap - t * u), max(0.0, 1.0 - d * u)
            slope = k * t * more + k * depth * d
            start = k * depth * more + slope * u
        slope = max(slope, 1e-12 / t)
        packed[3 * i + 2, 3 * i + 2] += 1.0 / (t * slope)
        packed[m, 3 * i + 2] -= start / slope


@inline_kernel
def _shift(
    model: FloatArray, gaps: FloatArray, arms: FloatArray, near: IntArray, t: float, before: FloatArray,
    calm: float, packed: FloatArray,
) -> None:  # fmt: skip
    """Add the rigid law's bias: leave with -e times the speed of arrival, or keep the gap."""
    m = packed.shape[1]
    for i in range(m // 3):
        gap, arrival = gaps[near[i]], rise(before, arms, near[i])
        # Newton's restitution
        if arrival < -calm:
            packed[m, 3 * i + 2] += model[RESTITUTION] * arrival
        # open: it may close within the step
        elif gap > 0.0:
            packed[m, 3 * i + 2] += gap / t
        else:
            packed[m, 3 * i + 2] -= min(-RISE * gap / t, RISE_SPEED)


@kernel
def exchange(
    model: FloatArray, arms: FloatArray, gaps: FloatArray, near: IntArray, t: float, calm: float,
    before: FloatArray, v: FloatArray, last: FloatArray,
) -> bool:  # fmt: skip
    """Give the near corners their impulses over a time t; return whether the certificate accepts them.

    Parameters
    ----------
    model
        See `MU`, ...
    arms, gaps
        Of all corners.
    near
        (n,) the corners that may touch.
    t
        Length of the step [s].
    calm
        Speed up to which an arrival is none (rigid law) [m/s].
    before
        (6,) velocity before the step, linear and angular.
    v
        (6,) free velocity, gravity included; the impulses are added to it.
    last
        (8, 4) impulses of all corners in the last step (a guess) and its length; the new ones are kept.
    """
    n = near.size
    m = 3 * n
    packed, buffer, speeds = np.zeros((m + 2, m)), np.zeros((2 * n + 3, 3)), np.empty(n)
    for i in range(n):
        packed[m + 1, i], packed[m + 1, n + i], packed[m + 1, 2 * n + i] = model[MU], 0.0, np.inf
        speeds[i] = rise(v, arms, near[i])
    warm = _recall(near, last, t, buffer)
    done = 0
    # a law that is not linear is linearised where the last pass ended
    for number in range(PASSES if model[LAW] == HUNT_CROSSLEY else 1):
        _fill(model, arms, near, v, packed)
        if model[LAW] == RIGID:
            _shift(model, gaps, arms, near, t, before, calm, packed)
        else:
            _soften(model, gaps, near, t, speeds, packed)
        done = solve_compiled(
            packed[:m], packed[m:], TOLERANCE, ITERATIONS, WARM if warm or number > 0 else 0, buffer
        )
        change = 0.0
        for i in range(
            n
        ):  # G as it was softened holds the compliance: the corner's own speed is less by that
            s = _speed(arms, near, buffer, model, v, i)
            change, speeds[i] = max(change, abs(s - speeds[i])), s
        if change < SAME:
            break
    _apply(model, arms, near, buffer, v)
    _remember(near, buffer, t, last)
    return done < UNSOLVED


@inline_kernel
def _recall(near: IntArray, last: FloatArray, t: float, buffer: FloatArray) -> bool:
    """Fill the buffer's forces with those of the last step; return False where a corner had none."""
    known = near.size > 1
    for i in range(near.size):
        k = near[i]
        known = known and last[k, 2] > 0.0
        for a in range(3):
            buffer[i, a] = last[k, a] * (t / last[k, 3] if last[k, 3] > 0.0 else 0.0)
    return known


@inline_kernel
def _remember(near: IntArray, buffer: FloatArray, t: float, last: FloatArray) -> None:
    """Keep the impulses of a step of length t."""
    for k in range(8):
        for a in range(3):
            last[k, a] = 0.0
        last[k, 3] = t
    for i in range(near.size):
        for a in range(3):
            last[near[i], a] = buffer[i, a]


@inline_kernel
def _turn(
    model: FloatArray, arms: FloatArray, near: IntArray, buffer: FloatArray, i: int
) -> tuple[float, float, float]:
    """Return the change of angular velocity by the impulse of near corner i."""
    k, share = near[i], 1.0 / model[GYRATION]
    x, y, z = buffer[i, 0], buffer[i, 1], buffer[i, 2]
    return (
        share * (arms[k, 1] * z - arms[k, 2] * y),
        share * (arms[k, 2] * x - arms[k, 0] * z),
        share * (arms[k, 0] * y - arms[k, 1] * x),
    )


@inline_kernel
def _speed(
    arms: FloatArray, near: IntArray, buffer: FloatArray, model: FloatArray, v: FloatArray, i: int
) -> float:
    """Return the normal speed of near corner i under the impulses."""
    speed = rise(v, arms, near[i])
    for j in range(near.size):
        x, y, _ = _turn(model, arms, near, buffer, j)
        speed += buffer[j, 2] + x * arms[near[i], 1] - y * arms[near[i], 0]
    return speed


@inline_kernel
def _apply(model: FloatArray, arms: FloatArray, near: IntArray, buffer: FloatArray, v: FloatArray) -> None:
    """Add the impulses to the velocity."""
    for i in range(near.size):
        x, y, z = _turn(model, arms, near, buffer, i)
        v[0] += buffer[i, 0]
        v[1] += buffer[i, 1]
        v[2] += buffer[i, 2]
        v[3] += x
        v[4] += y
        v[5] += z
