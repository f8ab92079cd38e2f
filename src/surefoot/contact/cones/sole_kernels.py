"""Questions to a sole, compiled: many wrenches against one sole.

`numbers` holds the centre (x, y) [m], the length that moments are counted over [m], the torsional radius over
that length [-] and mu [-]; `table`, `start` and `edges` are those of `sole_shape`. Wrenches are [force;
moment] in the contact frame. The least normal force of a wrench is N = min sum f_n over corner forces in
their cones that give its other five numbers: it holds where N <= f_z, and f_z - N is its margin.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.cones.sole_bounds import INSIDE, SOLVED, STALLED, nearest, need
from surefoot.contact.cones.sole_program import WORK, X

CENTRE_X, CENTRE_Y, LENGTH, RADIUS, MU = 0, 1, 2, 3, 4
FINEST = 1e-13
"""Relative change of a friction coefficient at which its search ends [-]: rounding."""
SEARCHES = 60
"""Newton steps of that search at most [-]: 4 to 8 are usual."""
NEAR = 1e-11
"""Normal force that may be missing where that search ends [-], as a share of the wrench's: rounding."""
NO, YES, UNSURE = 0, 1, 2
"""What `hold` says of a wrench; the first two are those of a boolean."""

FlagArray = npt.NDArray[np.int8]


@inline_kernel
def normalise(numbers: FloatArray, w: FloatArray, W: FloatArray) -> tuple[float, float]:
    """Set W (6,) to (t / mu, m_x, m_y, m_z / mu, 0) about the centre, of norm one; return its norm and size.

    Norm and size (that of the whole wrench) are in newtons; both are NaN for a wrench that is not finite.
    """
    x, y, length, mu = numbers[CENTRE_X], numbers[CENTRE_Y], numbers[LENGTH], numbers[MU]
    W[0], W[1] = w[0], w[1]
    W[2], W[3] = (w[3] - y * w[2]) / length, (w[4] + x * w[2]) / length
    W[4] = (w[5] - x * w[1] + y * w[0]) / length
    W[5] = 0.0
    top = abs(w[2])
    for j in range(5):
        top = max(top, abs(W[j]))
    total = w[0] + w[1] + w[2] + w[3] + w[4] + w[5]
    if not (math.isfinite(top) and math.isfinite(total)):
        return math.nan, math.nan
    if top == 0.0:
        return 0.0, 0.0
    size = (w[2] / top) ** 2
    for j in range(5):
        size += (W[j] / top) ** 2
    size = top * math.sqrt(size)
    if mu > 0.0:
        W[0], W[1], W[4] = W[0] / mu, W[1] / mu, W[4] / mu
    top = 0.0
    for j in range(5):
        top = max(top, abs(W[j]))
    if top == 0.0 or not math.isfinite(top):
        return top, size
    norm = 0.0
    for j in range(5):
        W[j] /= top
        norm += W[j] * W[j]
    norm = math.sqrt(norm)
    for j in range(5):
        W[j] /= norm
    return top * norm, size


@inline_kernel
def _edge_need(edges: FloatArray, W: FloatArray) -> float:
    """Return the least normal force that the tipping moments alone take: the worst edge's."""
    most = 0.0
    for i in range(edges.shape[0]):
        most = max(most, edges[i, 0] * W[2] + edges[i, 1] * W[3])
    return most


@inline_kernel
def _least(numbers: FloatArray, edges: FloatArray, W: FloatArray) -> float:
    """Return a bound from below on the normal force that W takes: sliding, yaw and tipping, each alone."""
    yaw = abs(W[4]) / math.sqrt(1.0 + numbers[RADIUS] ** 2)
    return float(max(math.sqrt(W[0] * W[0] + W[1] * W[1]), max(yaw, _edge_need(edges, W))))


@inline_kernel
def _holds(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, w: FloatArray, tol: float,
    W: FloatArray, v: FloatArray, work: FloatArray, space: FloatArray,
) -> int:  # fmt: skip
    """Return whether a wrench holds with `tol` max(1 N, its size) more normal force at the centre."""
    norm, size = normalise(numbers, w, W)
    if not norm < math.inf:
        return NO
    slack = tol * max(1.0, size)
    force = w[2] + slack
    if norm == 0.0 or force < 0.0:
        return YES if force >= 0.0 else NO
    if numbers[MU] == 0.0:
        friction = norm * math.sqrt(W[0] * W[0] + W[1] * W[1] + W[4] * W[4])
        return YES if friction <= slack and norm * _edge_need(edges, W) <= force else NO
    level = force / norm
    if _least(numbers, edges, W) > level:
        return NO
    outcome, low, high = need(table, start, numbers[RADIUS], W, level, v, work, space)
    if outcome == STALLED:
        return UNSURE
    return YES if outcome == INSIDE or (outcome == SOLVED and 0.5 * (low + high) <= level) else NO


@kernel
def hold(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, wrenches: FloatArray,
    tol: float, out: FlagArray,
) -> int:  # fmt: skip
    """Fill out (T,) with `YES` where wrenches (T, 6) are in the sole's cone, see `_holds`, else with `NO`.

    Return how many are `UNSURE`: too near to the border for doubles.
    """
    W, v, unsure = np.empty(6), np.empty(6), 0
    work, space = np.empty((table.shape[0], WORK)), np.empty((9, 6))
    for t in range(wrenches.shape[0]):
        out[t] = _holds(numbers, table, start, edges, wrenches[t], tol, W, v, work, space)
        unsure += out[t] == UNSURE
    return unsure


@inline_kernel
def _need_of(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, W: FloatArray,
    v: FloatArray, work: FloatArray, space: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return the normal force that W (6,), of norm one, takes, and the gap of its proofs; fill v and work."""
    if numbers[MU] == 0.0:
        for j in range(6):
            v[j] = 0.0
        if W[0] != 0.0 or W[1] != 0.0 or W[4] != 0.0:
            return math.inf, 0.0
        best = 0
        for i in range(edges.shape[0]):
            if edges[i, 0] * W[2] + edges[i, 1] * W[3] > edges[best, 0] * W[2] + edges[best, 1] * W[3]:
                best = i
        v[2], v[3] = -edges[best, 0], -edges[best, 1]
        return _edge_need(edges, W), 0.0
    outcome, low, high = need(table, start, numbers[RADIUS], W, math.nan, v, work, space)
    return (math.nan if outcome == STALLED else 0.5 * (low + high)), high - low


@kernel
def measure(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, wrenches: FloatArray,
    needs: FloatArray, shares: FloatArray,
) -> None:  # fmt: skip
    """Fill needs (T,) with the least normal forces [N] of wrenches (T, 6), and shares (T, 3) of them.

    N is homogeneous, so that it is the sum of what friction (f_x, f_y), the edge (m_x, m_y) and yaw (m_z)
    take each: Euler's theorem. NaN for wrenches that are not finite, and where doubles do not settle it;
    infinity for what no normal force gives.
    """
    W, v = np.empty(6), np.empty(6)
    work, space = np.empty((table.shape[0], WORK)), np.empty((9, 6))
    for t in range(wrenches.shape[0]):
        norm, _ = normalise(numbers, wrenches[t], W)
        for j in range(3):
            shares[t, j] = 0.0
        needs[t] = norm
        if not (0.0 < norm < math.inf):
            continue
        found, _ = _need_of(numbers, table, start, edges, W, v, work, space)
        needs[t] = norm * found
        shares[t, 0] = -norm * (v[0] * W[0] + v[1] * W[1])
        shares[t, 1] = -norm * (v[2] * W[2] + v[3] * W[3])
        shares[t, 2] = -norm * v[4] * W[4]


@inline_kernel
def proofs_of(
    numbers: FloatArray, norm: float, work: FloatArray, at: int, y: FloatArray, forces: FloatArray,
    v: FloatArray,
) -> None:  # fmt: skip
    """Set forces (k, 4) and v (6,) of `certify` from those of the program, work[:, at : at + 4] and y."""
    mu, length = numbers[MU], numbers[LENGTH]
    for i in range(forces.shape[0]):
        forces[i, 0], forces[i, 1] = norm * mu * work[i, at + 1], norm * mu * work[i, at + 2]
        forces[i, 2] = norm * work[i, at]
        forces[i, 3] = norm * mu * numbers[RADIUS] * length * work[i, at + 3]
    friction = mu if mu > 0.0 else 1.0
    v[0], v[1], v[2], v[5] = y[0] / friction, y[1] / friction, 1.0, y[4] / (friction * length)
    v[3], v[4] = y[2] / length, y[3] / length


@kernel
def certify(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, w: FloatArray,
    forces: FloatArray, v: FloatArray,
) -> float:  # fmt: skip
    """Fill forces (k, 4) [N, N m] and a velocity v (6,) that prove the least normal force [N]; return it.

    The forces (f_x, f_y, f_z, moment) of the corners give (f_x, f_y, m) of the wrench with that normal force;
    v, in the order (f_x, f_y, f_z, m_x, m_y, m_z) and about the centre, has v[2] = 1 and no product below
    zero with what any corner gives.
    """
    W, y = np.empty(6), np.empty(6)
    work, space = np.zeros((table.shape[0], WORK)), np.empty((9, 6))
    norm, _ = normalise(numbers, w, W)
    forces[:] = 0.0
    v[:] = 0.0
    v[2] = 1.0
    if not (0.0 < norm < math.inf):
        return norm
    found, _ = _need_of(numbers, table, start, edges, W, y, work, space)
    proofs_of(numbers, norm, work, X, y, forces, v)
    return norm * found


@kernel
def project(numbers: FloatArray, table: FloatArray, wrenches: FloatArray, out: FloatArray) -> float:
    """Fill out (T, 6) with the nearest wrenches of the cone; return the largest gap left, over the squares.

    Moments are about the centre and counted over the length.
    """
    W, v, p = np.empty(6), np.empty(6), np.empty(6)
    work, space = np.empty((table.shape[0], WORK)), np.empty((9, 6))
    x, y, length, worst = numbers[CENTRE_X], numbers[CENTRE_Y], numbers[LENGTH], 0.0
    for t in range(wrenches.shape[0]):
        w = wrenches[t]
        W[0], W[1], W[5] = w[0], w[1], w[2]
        W[2], W[3] = (w[3] - y * w[2]) / length, (w[4] + x * w[2]) / length
        W[4] = (w[5] - x * w[1] + y * w[0]) / length
        top, total = 0.0, 0.0
        for j in range(6):
            top, total = max(top, abs(W[j])), total + W[j]
        norm = 0.0
        for j in range(6):
            norm += (W[j] / top) ** 2 if top > 0.0 else 0.0
        norm = top * math.sqrt(norm) if math.isfinite(total) else math.nan  # the maximum passes NaN over
        if not (0.0 < norm < math.inf):
            for j in range(6):
                out[t, j] = 0.0 if norm == 0.0 else math.nan
            continue
        for j in range(6):
            W[j] /= norm
        worst = max(worst, nearest(table, numbers[MU], numbers[RADIUS], W, v, work, space, p))
        out[t, 0], out[t, 1], out[t, 2] = norm * p[0], norm * p[1], norm * p[5]
        out[t, 3] = norm * length * p[2] + y * out[t, 2]
        out[t, 4] = norm * length * p[3] - x * out[t, 2]
        out[t, 5] = norm * length * p[4] + x * out[t, 1] - y * out[t, 0]
    return worst


@kernel
def frictions(
    numbers: FloatArray, table: FloatArray, start: FloatArray, edges: FloatArray, wrenches: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (T,) with the least friction coefficients that hold wrenches (T, 6); infinity where none does.

    NaN for wrenches that are not finite. Where doubles do not settle it, the coefficient is less than needed
    and has a minus.

    With q = 1 / mu the normal force N(q) that a wrench takes is a maximum of straight lines, convex and
    rising: Newton's method on N(q) = f_z falls to its root from above. A root is sought from the friction
    that sliding and yaw need alone.
    """
    W, v, Q = np.empty(6), np.empty(6), np.empty(6)
    work, space = np.empty((table.shape[0], WORK)), np.empty((9, 6))
    one = numbers.copy()
    one[MU] = 1.0
    for t in range(wrenches.shape[0]):
        norm, _ = normalise(one, wrenches[t], W)
        force = wrenches[t, 2]
        if not norm < math.inf:
            out[t] = math.nan
            continue
        if norm == 0.0:
            out[t] = 0.0 if force >= 0.0 else math.inf
            continue
        level = force / norm
        yaw = abs(W[4]) / math.sqrt(1.0 + one[RADIUS] ** 2)
        friction = max(math.sqrt(W[0] * W[0] + W[1] * W[1]), yaw)
        if level < _edge_need(edges, W) or level < 0.0 or (level == 0.0 and friction > 0.0):
            out[t] = math.inf
            continue
        if friction == 0.0:
            out[t] = 0.0
            continue
        q, settled = level / friction, False
        for _ in range(SEARCHES):
            top = 0.0
            Q[0], Q[1], Q[2], Q[3], Q[4], Q[5] = q * W[0], q * W[1], W[2], W[3], q * W[4], 0.0
            for j in range(5):
                top += Q[j] * Q[j]
            top = math.sqrt(top)
            for j in range(5):
                Q[j] /= top
            outcome, low, _ = need(table, start, one[RADIUS], Q, math.nan, v, work, space)
            # N >= slope q + rest for the velocity that proves the bound from below, whatever q is
            slope = -(v[0] * W[0] + v[1] * W[1] + v[4] * W[4])
            over = top * low - level
            if not (over > NEAR * level and slope > 0.0):
                settled = outcome != STALLED and over <= NEAR * level
                break
            less = q - over / slope
            done = q - less <= FINEST * q
            q = less
            if done or not q > 0.0:
                settled = outcome != STALLED
                break
        if not q > 0.0:
            out[t] = math.inf
        else:
            out[t] = 1.0 / q if settled else -1.0 / q
