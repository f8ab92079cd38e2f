"""Columns that no row reaches, condensed out of a connected part: arms of a robot that stands on its feet.

Where J has no entries in the columns F, the dynamics there are M_FR w_R + M_FF w_F = 0 for the change w of
the velocities, and the columns R that rows reach have the inertia M_RR - M_RF M_FF⁻¹ M_FR: Guyan's static
condensation, and, of a tree, Featherstone's articulated inertia. All that is iterated has the size of R then;
a G1 on one foot has 12 columns of 35.

Sources: R. J. Guyan, "Reduction of stiffness and mass matrices", AIAA Journal 3(2), 1965; R. Featherstone,
"Rigid Body Dynamics Algorithms", Springer 2008, ch. 7.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.base.numerics.lu_factors import eliminate_last


@inline_kernel
def sort_columns(columns: IntArray, place: IntArray, order: IntArray) -> int:
    """Fill the order of columns (n,), reached ones first, and their places in it; return their number."""
    n = order.size
    for j in range(n):
        place[j] = 0
    for k in range(columns.shape[0]):
        for c in range(1, columns[k, 0] + 1):
            place[columns[k, c]] = 1
    reached = 0
    for j in range(n):
        reached += place[j]
    first, last = 0, reached
    for j in range(n):
        if place[j] == 1:
            place[j], order[first] = first, j
            first += 1
        else:
            place[j], order[last] = last, j
            last += 1
    return reached


@inline_kernel
def condense(
    M: FloatArray, v: FloatArray, order: IntArray, reached: int, whole: FloatArray, own: FloatArray
) -> bool:
    """Fill the inertia (r, r) of the reached columns, and what `follow_reached` needs (n, n); False: not so.

    That is where a pivot is small beside its column, which no mechanism's inertia has, and where one of the
    velocities (n,) is no number: what nobody looks at must not pass for solved.
    """
    n, total = order.size, 0.0
    for i in range(n):
        total += v[i]
        for j in range(n):
            whole[i, j] = M[order[i], order[j]]
    if not (abs(total) < np.inf and eliminate_last(whole, reached)):
        return False
    for i in range(reached):
        for j in range(reached):
            own[i, j] = whole[i, j]
    return True


@inline_kernel
def take_reached(
    J: FloatArray, v: FloatArray, columns: IntArray, place: IntArray, order: IntArray, own_J: FloatArray,
    own_v: FloatArray, own_columns: IntArray,
) -> None:  # fmt: skip
    """Fill rows (m, r), velocities (r,) and the blocks' columns (k, r + 1) of the reached columns alone."""
    for j in range(own_v.size):
        own_v[j] = v[order[j]]
    for i in range(own_J.shape[0]):
        for j in range(own_v.size):
            own_J[i, j] = J[i, order[j]]
    for k in range(columns.shape[0]):
        own_columns[k, 0] = columns[k, 0]
        for c in range(1, columns[k, 0] + 1):
            own_columns[k, c] = place[columns[k, c]]


@inline_kernel
def follow_reached(whole: FloatArray, order: IntArray, own_v: FloatArray, v: FloatArray) -> None:
    """Replace all velocities v (n,) by those with the reached ones (r,) that were found."""
    n, reached = v.size, own_v.size
    change = np.empty(n)
    for i in range(reached):
        change[i] = own_v[i] - v[order[i]]
    for i in range(reached, n):
        total = 0.0
        for j in range(i):
            total -= whole[i, j] * change[j]
        change[i] = total / whole[i, i]
    for i in range(n):
        v[order[i]] += change[i]
