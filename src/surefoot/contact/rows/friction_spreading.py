"""Friction of contacts that share a body, spread in proportion to their normal forces.

The corners of a sole are more than it takes to hold it, so that what each carries is not determined. Impulses
of the step before drift until one corner is at its cone's border while the others stick, and Newton's method
has to find out who slides where nobody does. The same load on the body, with friction in proportion to the
normal forces, is inside all cones: the least ||x_t||² / x_n, found by one proximal step.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.lu_factors import apply_lu, factor_lu
from surefoot.contact.rows.blocks import CONE_ROWS, DIM, FIRST, KIND, MU, STIFF_T, WIDEST
from surefoot.contact.rows.linearised import add_block

STIFFNESS = 10.0
"""Share of the penalties that the loads are spread with [-]: what is lost of the load is 1e-4 of it."""
BORDER = 0.999
"""Share of the friction that is available, from which on an impulse is at its cone's border [-]."""


@inline_kernel
def _together(columns: IntArray, table: IntArray, k: int, other: int) -> bool:
    """Return whether two blocks are cones of the same size that move the same columns."""
    same = table[other, KIND] == CONE_ROWS and table[other, DIM] == table[k, DIM]
    for c in range(columns[k, 0] + 1):
        same = same and columns[k, c] == columns[other, c]
    return bool(same)


@inline_kernel
def _slides(table: IntArray, numbers: FloatArray, x: FloatArray, k: int) -> bool:
    """Return whether a contact's impulse is at its cone's border."""
    at, square = table[k, FIRST], 0.0
    for a in range(at + 1, at + table[k, DIM]):
        square += x[a] * x[a]
    return bool(x[at] > 0.0 and square >= (BORDER * numbers[k, MU] * x[at]) ** 2)


@inline_kernel
def _weigh(
    table: IntArray, numbers: FloatArray, x: FloatArray, begin: int, end: int, weights: FloatArray
) -> bool:
    """Fill the shares of the mean normal impulse that contacts carry; False if all slide or none does."""
    total, inside, border = 0.0, False, False
    for k in range(begin, end):
        total += x[table[k, FIRST]]
        if x[table[k, FIRST]] > 0.0:
            slides = _slides(table, numbers, x, k)
            inside, border = inside or not slides, border or slides
    if not (inside and border):
        return False
    for k in range(begin, end):
        weights[k] = x[table[k, FIRST]] / total * (end - begin)
    return True


@inline_kernel
def any_slides(table: IntArray, numbers: FloatArray, x: FloatArray) -> bool:
    """Return whether one of the impulses x (m,) is at its cone's border: else there is nothing to spread."""
    found = False
    for k in range(table.shape[0]):
        found = found or (table[k, KIND] == CONE_ROWS and _slides(table, numbers, x, k))
    return found


@inline_kernel
def _find_uneven(
    columns: IntArray, table: IntArray, numbers: FloatArray, x: FloatArray, weights: FloatArray
) -> bool:
    """Fill the weights (k,) of contacts whose friction is to be spread, 0 for others; return if any is."""
    count, k, found = table.shape[0], 0, False
    while k < count:
        end = k + 1
        weights[k] = 0.0
        if table[k, KIND] == CONE_ROWS:
            while end < count and _together(columns, table, k, end):
                weights[end] = 0.0
                end += 1
            if end > k + 1:
                found = _weigh(table, numbers, x, k, end, weights) or found
        k = end
    return found


@kernel
def spread_friction(
    M: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, numbers: FloatArray, x: FloatArray
) -> None:
    """Spread the friction of impulses x (m,) where some contacts of a body stick and others slide.

    Parameters: see `solve_part`. Which contacts share a body is told by their columns, one after the other.
    """
    n, count = M.shape[0], table.shape[0]
    weights = np.empty(count)
    if not _find_uneven(columns, table, numbers, x, weights):
        return
    H, order, y = M.copy(), np.empty((3, n), np.int64), np.zeros(n)
    D, rooms = np.zeros((WIDEST, WIDEST)), np.empty((2 * WIDEST + 1, n))
    for k in range(count):
        if weights[k] > 0.0:
            at = table[k, FIRST]
            for a in range(1, table[k, DIM]):
                D[a, a] = STIFFNESS * numbers[k, STIFF_T] * weights[k]
                for c in range(1, columns[k, 0] + 1):
                    y[columns[k, c]] += J[at + a, columns[k, c]] * x[at + a]
            add_block(J, columns, k, at, table[k, DIM], D, True, H, rooms)
    if not factor_lu(H, order):
        return
    apply_lu(H, order, y)
    for k in range(count):
        if weights[k] > 0.0:
            for i in range(table[k, FIRST] + 1, table[k, FIRST] + table[k, DIM]):
                motion = 0.0
                for c in range(1, columns[k, 0] + 1):
                    motion += J[i, columns[k, c]] * y[columns[k, c]]
                x[i] = STIFFNESS * numbers[k, STIFF_T] * weights[k] * motion
