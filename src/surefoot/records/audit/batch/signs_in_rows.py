"""Signs that break no law, told by the compiled pass of `proof_of_rows` as the audit's own checks tell them.

Contacts that leave the ground faster than declared (`restitution.throw`), and force spikes. What lies so near
to a limit that sums in another order might decide otherwise is left to the audit.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.records.audit.batch.row_limits import (
    GAP,
    LANDING,
    MARGIN,
    MU,
    RECOIL,
    RETURNS,
    SHARE,
    SLACK,
    SPIKE,
    THRESHOLD,
    WEIGHT,
    F,
    V,
)

SIGN_THROW, SIGN_SPIKE = range(2)
"""Signs, in the order of `SIGNS`."""
SIGNS = ("throw", "spike")
"""Their names in the audit."""
(OUT_WORST, OUT_LIMIT, OUT_ROW, OUT_CONTACT) = range(4)
"""What is told of a sign where it is most beyond its limit: value and limit, its row, and which contact."""


def start_signs(rows: int) -> tuple[FloatArray, BoolArray]:
    """Return what is told of each sign before any row, (signs, 4), and in which rows it is (signs, rows)."""
    signs = np.zeros((len(SIGNS), 4))
    signs[:, OUT_WORST] = -math.inf
    return signs, np.zeros((len(SIGNS), rows), dtype=bool)


@inline_kernel
def _note(out: FloatArray, rows: BoolArray, value: float, limit: float, t: int, k: int) -> None:
    """Note that a contact is beyond its limit in a row; the first of equals is kept, as `argmax` does."""
    rows[t] = True
    more, most = value - limit, out[OUT_WORST] - out[OUT_LIMIT]
    if more > most or (more == most and t < out[OUT_ROW]):
        out[OUT_WORST], out[OUT_LIMIT], out[OUT_ROW], out[OUT_CONTACT] = value, limit, t, k


@inline_kernel
def find_throws(
    table: FloatArray, at: IntArray, dt: FloatArray, k: int, c: int, margin: float, means: bool,
    limits: FloatArray, out: FloatArray, rows: BoolArray,
) -> bool:  # fmt: skip
    """Note where contact `c` leaves so fast, with so much work, that `restitution.throw` tells it.

    `table` is (T, contacts, fields), `dt` (T,) [s], `margin` the gap from which it pushes [m]; `out` (4,) and
    `rows` (T,) are written. Velocities are those before a row's force, or means. Return whether all is
    told: False where a row is too near to a limit.
    """
    n, deepest, work, taken, unsure = len(dt), 0.0, 0.0, 0.0, 0.0
    for t in range(n):
        row, later = table[t, c], table[min(t + 1, n - 1), c]
        normal, gap = row[at[F] + 2], row[at[GAP]]
        if not (normal > limits[THRESHOLD] or gap < margin):
            deepest = work = taken = unsure = 0.0
            continue
        deepest = max(deepest, margin - gap, margin - later[at[GAP]])
        if not normal > limits[THRESHOLD]:
            continue
        begin, end = row[at[V] + 2], row[at[V] + 2] if means else later[at[V] + 2]
        if means:  # a row of means may end unloaded, and be pulled up
            end = min(end, table[max(t - 1, 0), c, at[V] + 2])
        half = 0.5 * normal * dt[t]
        taken -= half * (min(begin, 0.0) + min(end, 0.0))
        slide = math.hypot(row[at[V]], row[at[V] + 1])
        if not means:
            slide = max(slide, math.hypot(later[at[V]], later[at[V] + 1]))
        slowest = limits[RECOIL] * max(deepest, 0.0) + max(row[at[MU]], 0.0) * slide + limits[SLACK]
        if not end > MARGIN * slowest:
            continue
        given = half * (max(begin, 0.0) + max(end, 0.0))
        limit = max(limits[RETURNS], limits[SHARE] * taken)
        if not MARGIN * end > slowest:  # as fast as that, or not
            unsure += given
            if work + unsure > MARGIN * limit:
                return False
            continue
        work += given
        if work + unsure > MARGIN * limit:
            if not MARGIN * work > limit:
                return False
            _note(out, rows, work, limit, t, k)
    return True


@inline_kernel
def find_spikes(
    table: FloatArray, used: IntArray, at: IntArray, n: int, limits: FloatArray, out: FloatArray,
    rows: BoolArray,
) -> None:  # fmt: skip
    """Note the rows whose force is beyond any landing's, see the sign `spike`.

    `table` is (T, contacts, fields), of which `used` (k,) are looked at; `out` (4,) and `rows` (T,)
    are written.
    """
    for t in range(2, n - 2):
        for k in range(len(used)):
            c = used[k]
            size = _size(table, at, t, c)
            if not size > limits[SPIKE]:
                continue
            left = min(_size(table, at, t - 2, c), _size(table, at, t - 1, c))
            right = min(_size(table, at, t + 2, c), _size(table, at, t + 1, c))
            value = (size - max(left, right)) / limits[WEIGHT]
            if not value > limits[SPIKE] / limits[WEIGHT]:
                continue
            landing = (
                limits[LANDING] * _fastest_down(table, used, at, t) * math.hypot(1.0, table[t, c, at[MU]])
            )
            bound = limits[SPIKE] / limits[WEIGHT] + landing
            if value > bound:
                _note(out, rows, value, bound, t, k)


@inline_kernel
def _fastest_down(table: FloatArray, used: IntArray, at: IntArray, t: int) -> float:
    """Return the highest speed towards the ground of all contacts in two rows before and after [m/s]."""
    out = 0.0
    for s in range(t - 2, t + 3):
        for k in range(len(used)):
            out = max(out, -table[s, used[k], at[V] + 2])
    return out


@inline_kernel
def _size(table: FloatArray, at: IntArray, t: int, c: int) -> float:
    return math.sqrt(table[t, c, at[F]] ** 2 + table[t, c, at[F] + 1] ** 2 + table[t, c, at[F] + 2] ** 2)
