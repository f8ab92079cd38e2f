"""The kernel behind `can_stand`: the contact forces with the most margin, or a separating wrench.

    maximise t  subject to  A f = w,  f - t e in K,

where e is the axis of every cone, scaled so that t is the Euclidean distance of each contact's force
to its cone's boundary. Its dual is

    minimise y.w  subject to  A' y in K*,  (A e).y = 1,

so that t < 0 comes with a y that proves it: every admissible force has y.(A f) >= 0, and y.w < 0.
Both programs always have strict interior points (t may be as negative as it likes), unless the contacts
can squeeze without limit; then t is infinite.

Coordinates: a friction cone is the Lorentz cone of u = (f_z, f_x / mu, f_y / mu), so that mu = 0 needs no
case of its own. Wrenches are divided by the load and by a length, so that no tolerance has a unit.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.equilibrium.cone_program import UNBOUNDED, minimise
from surefoot.equilibrium.reduction import coordinates, orthonormal_rows, pull_back, reflect, turn_first_row
from surefoot.kernels import inline_kernel, kernel

FEASIBLE, INFEASIBLE, UNREACHABLE, ENDLESS = 0, 1, 2, 3
"""Outcomes: margin >= 0; margin < 0; load outside the range of the contact forces; margin without bound."""

GAP = 1e-10
"""Gap between margin and certificate at which the search ends, as a share of the load."""
BAND = 1e-9
"""Forces that leave their cones by less than this share of the load count as possible."""
FRICTIONLESS = 1e-6
"""Friction below which the margin of a contact is its normal force: its cone has no width to speak of."""
_ENDLESS_MARGIN = 1e6
_SQUEEZE = 0.1


@inline_kernel
def depth(x: FloatArray, e: FloatArray, lorentz: int) -> float:
    """Return the largest t with x - t e in the cone, e > 0 on the axes."""
    least = math.inf
    for k in range(lorentz):
        i = 3 * k
        least = min(least, (x[i] - math.hypot(x[i + 1], x[i + 2])) / e[i])
    for i in range(3 * lorentz, x.size):
        least = min(least, x[i] / e[i])
    return least


@kernel
def most_margin(
    A: FloatArray, e: FloatArray, w: FloatArray, lorentz: int
) -> tuple[int, float, FloatArray, FloatArray]:
    """Maximise t with A x = w, x - t e in K; all quantities scaled (|w| about 1, rows about 1).

    Parameters
    ----------
    A, e, w
        (p, m), (m,), (p,).
    lorentz
        Number of 3-D Lorentz cones at the front of x; the rest are half-lines.

    Returns
    -------
    tuple[int, float, FloatArray, FloatArray]
        Outcome, t, x (m,) and y (p,) with A' y in K* and (A e).y = 1 (zero where there is none).
    """
    p, m = A.shape
    Q, T, pivots = np.empty((p, m)), np.empty((p, p)), np.empty(p, dtype=np.int64)
    b, a, h, full = np.zeros(p), np.zeros(p), np.zeros(p), np.zeros(p)
    x, y = np.zeros(m), np.zeros(p)
    rank = orthonormal_rows(A, Q, T, pivots)
    if coordinates(T, pivots, rank, w, b) > BAND:
        _unreachable(T, pivots, rank, w, full, y)
        return UNREACHABLE, -math.inf, x, y
    for i in range(m):
        for j in range(rank):
            x[i] += Q[j, i] * b[j]
    least_norm = x.copy()
    size, steepest = 0.0, 0.0
    for j in range(rank):
        for i in range(m):
            a[j] += Q[j, i] * e[i]
    for i in range(m):
        size += e[i] * e[i]
        steepest = max(steepest, e[i])
    alpha = turn_first_row(Q, rank, a, h, b)
    t0 = depth(x, e, lorentz)
    if alpha <= 1e-9 * math.sqrt(size):
        for i in range(m):
            x[i] += (_SQUEEZE - t0) * e[i]
        return ENDLESS, math.inf, x, y
    start = 1.0 / (steepest * max(1, lorentz)) - 1.5 * min(t0, 0.0)
    if t0 > 0.0:
        start = max(0.0, start - t0)
    for i in range(m):
        x[i] += start * e[i]
    dual, z = np.empty(rank - 1), np.empty(m)
    tol, floor = GAP * alpha, b[0] - _ENDLESS_MARGIN * alpha
    status, _ = minimise(Q[1:rank], b[1:rank], Q[0], lorentz, x, dual, z, tol, floor, b[0])
    t = b[0]
    for i in range(m):
        t -= Q[0, i] * x[i]
    t /= alpha
    for i in range(m):
        x[i] += t * e[i]
    _restore(Q, b, rank, x)
    t = depth(x, e, lorentz)
    if status == UNBOUNDED:
        share = (_SQUEEZE - t0) / (t - t0)
        for i in range(m):
            x[i] = least_norm[i] + share * (x[i] - least_norm[i])
        return ENDLESS, math.inf, x, y
    full[0] = 1.0 / alpha
    for j in range(1, rank):
        full[j] = -dual[j - 1] / alpha
    reflect(h, rank, full)
    pull_back(T, pivots, rank, full, y)
    return (FEASIBLE if t * steepest >= -BAND else INFEASIBLE), t, x, y


@inline_kernel
def _restore(Q: FloatArray, b: FloatArray, rank: int, x: FloatArray) -> None:
    """Move x onto Q x = b by the shortest way: the equations then hold to rounding."""
    for j in range(rank):
        s = b[j]
        for i in range(x.size):
            s -= Q[j, i] * x[i]
        for i in range(x.size):
            x[i] += s * Q[j, i]


@kernel
def _unreachable(
    T: FloatArray, pivots: IntArray, rank: int, w: FloatArray, row: FloatArray, y: FloatArray
) -> None:
    """Set y to a direction in which no contact force acts (A' y = 0) but the load does (y.w < 0)."""
    p = T.shape[0]
    worst = 0.0
    best = np.zeros(p)
    for j in range(p):
        for q in range(rank):
            row[q] = T[j, q]
        pull_back(T, pivots, rank, row, y)
        s = w[j]
        for q in range(p):
            s -= y[q] * w[q]
        if abs(s) > worst:
            worst = abs(s)
            sign = -1.0 if s > 0.0 else 1.0
            for q in range(p):
                best[q] = -sign * y[q]
            best[j] += sign
    for q in range(p):  # as a slice it would take 2 s to compile
        y[q] = best[q]


@kernel
def stand(
    positions: FloatArray, rotations: FloatArray, mu: FloatArray, about: FloatArray, load: FloatArray
) -> tuple[int, float, FloatArray, FloatArray]:
    """Hold a load with point contacts and exact friction cones, with the most margin.

    Parameters
    ----------
    positions, rotations, mu
        (n, 3) [m], (n, 3, 3) rotation_world_contact, (n,).
    about
        (3,) the point that moments refer to [m].
    load
        (6,) [force; moment] that the contacts must give together, world axes.

    Returns
    -------
    tuple[int, float, FloatArray, FloatArray]
        Outcome, margin [N], forces (3 n,) in contact frames [N], and y (6,) with y.(A e) = 1, so that
        y.load >= margin, equal at the optimum.
    """
    n = mu.size
    A, e, w = np.empty((6, 3 * n)), np.zeros(3 * n), np.empty(6)
    length = spread(positions, about)
    for i in range(n):
        _columns(positions[i], rotations[i], mu[i], about, length, A, 3 * i)
        e[3 * i] = axis_scale(mu[i])
    scale = load_scale(load, length)
    for k in range(3):
        w[k], w[k + 3] = load[k] / scale, load[k + 3] / (scale * length)
    outcome, t, x, y = most_margin(A, e, w, n)
    for i in range(n):
        height = x[3 * i] * scale
        x[3 * i], x[3 * i + 1] = mu[i] * x[3 * i + 1] * scale, mu[i] * x[3 * i + 2] * scale
        x[3 * i + 2] = height
    for k in range(3):
        y[k + 3] /= length
    return outcome, t * scale, x, y


@inline_kernel
def axis_scale(mu: float) -> float:
    """Return how far the axis must move for a distance of one to the cone's boundary (1 if frictionless)."""
    return math.sqrt(1.0 + mu * mu) / mu if mu > FRICTIONLESS else 1.0


@inline_kernel
def spread(positions: FloatArray, about: FloatArray) -> float:
    """Return the root mean square distance of the contacts from a point; 1 where all are there."""
    s = 0.0
    for i in range(positions.shape[0]):
        for k in range(3):
            s += (positions[i, k] - about[k]) ** 2
    s = math.sqrt(s / max(1, positions.shape[0]))
    return s if s > 0.0 else 1.0


@inline_kernel
def load_scale(load: FloatArray, length: float) -> float:
    """Return the size of a load as a force; 1 for no load at all."""
    s = 0.0
    for k in range(3):
        s += load[k] ** 2 + (load[k + 3] / length) ** 2
    return math.sqrt(s) if s > 0.0 else 1.0


@inline_kernel
def _columns(
    position: FloatArray, R: FloatArray, mu: float, about: FloatArray, length: float, A: FloatArray, at: int
) -> None:
    """Write the three wrench columns of one contact: normal, and mu times each tangent."""
    d0 = (position[0] - about[0]) / length
    d1 = (position[1] - about[1]) / length
    d2 = (position[2] - about[2]) / length
    for k in range(3):
        axis, factor = (2, 1.0) if k == 0 else (k - 1, mu)
        f0, f1, f2 = factor * R[0, axis], factor * R[1, axis], factor * R[2, axis]
        A[0, at + k], A[1, at + k], A[2, at + k] = f0, f1, f2
        A[3, at + k] = d1 * f2 - d2 * f1
        A[4, at + k] = d2 * f0 - d0 * f2
        A[5, at + k] = d0 * f1 - d1 * f0
