"""What proves an answer of `rows`: that no force keeps them, or how near forces are to the best."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.contact.solvers.dual_newton.dense import DUAL, HIGH, LOW, MU, TARGET, VALUE

Program = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""columns, sets, points, duals and H of `dense.minimise`, with the rows last among sets and duals."""

# columns of `rows`, one each: roots of the weights of T f - q and of q, multiplier, q, the multiplier's move
HEAVY, LIGHT, MULTIPLIER, LAST, MOVED = 0, 1, 2, 3, 4
ROUNDING = 1e-14  # of a sum of a few dozen products, against the sum of their sizes


@kernel
def proves_empty(columns: FloatArray, sets: FloatArray, rows: FloatArray) -> bool:
    """Tell whether MOVED separates every T f from every q: max over f, q of MOVED . (T f - q) < 0.

    A contact without a largest force whose gain is of the size of its own rounding counts as one without
    gain: with rows that differ in their last digits there is none.

    Parameters
    ----------
    columns, sets, rows
        (3n, 6 + k), (n + k, 4) and (k, 5) of `Program`, for n contacts and k rows.
    """
    count = rows.shape[0]
    contacts = sets.shape[0] - count
    m = columns.shape[1]
    total = scale = 0.0
    for k in range(contacts):
        x = y = z = size = 0.0
        for j in range(count):
            a, s = m - count + j, rows[j, MOVED] / rows[j, HEAVY]
            x += columns[3 * k, a] * s
            y += columns[3 * k + 1, a] * s
            z += columns[3 * k + 2, a] * s
            across = abs(columns[3 * k, a]) + abs(columns[3 * k + 1, a])
            size += abs(s) * (abs(columns[3 * k + 2, a]) + sets[k, MU] * across)
        # max of v·f over ||f_t|| <= mu f_z, low <= f_z <= high: f_z (v_z + mu ||v_t||) at an end of f_z
        gain = z + sets[k, MU] * math.sqrt(x * x + y * y)
        if sets[k, HIGH] == math.inf and gain <= ROUNDING * size:
            gain = min(gain, 0.0)
        reach = sets[k, HIGH] if gain > 0.0 else sets[k, LOW]
        if reach > 0.0:
            total += gain * reach
            scale += abs(gain) * reach
    for j in range(count):
        s = rows[j, MOVED]
        if s != 0.0:
            # max of -s q over low <= q <= high
            end = sets[contacts + j, LOW if s > 0.0 else HIGH] / rows[j, LIGHT]
            total -= s * end
            scale += abs(s * end)
    return total < -1e-9 * scale


@kernel
def gap_of_rows(program: Program, rows: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Return twice the duality gap of the forces at hand, for rows that end at low and high (rows,).

    With m the rows' multipliers and y the wrench's, the forces are f = Π(c + Bᵀ y + Tᵀ m) as they were
    computed, so that of the gap are left ½ ||y + B f - b||² and, row by row, what complementarity lacks:
    m_j (T f - low)_j, or -m_j (high - T f)_j. A row whose multiplier is next to nothing may be left out
    instead, for half of ||T_jᵀ m_j||² (the norms of several add up first).
    """
    columns, _, points, duals, _ = program
    count, m = rows.shape[0], duals.shape[1]
    total = 0.0
    for a in range(m - count):
        rest = duals[DUAL, a] - duals[TARGET, a]
        for i in range(columns.shape[0]):
            rest += columns[i, a] * points[VALUE, i]
        total += rest * rest
    left_out = 0.0
    for j in range(count):
        a, value, size = m - count + j, 0.0, 0.0
        for i in range(columns.shape[0]):
            value += columns[i, a] * points[VALUE, i]
            size += columns[i, a] ** 2
        value /= rows[j, HEAVY]
        multiplier = rows[j, MULTIPLIER]
        norm = abs(multiplier) * math.sqrt(size) / rows[j, HEAVY]
        slack = abs(value - low[j]) if multiplier > 0.0 else abs(high[j] - value)
        lacking = abs(multiplier) * slack if multiplier != 0.0 else 0.0
        # whichever bound is smaller: next to no multiplier on a row far
        # from its limit would count by its slack
        if 2.0 * lacking <= norm * norm:
            total += 2.0 * lacking
        else:
            left_out += norm
    return total + left_out * left_out
