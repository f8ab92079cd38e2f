"""How much rows weigh: the diagonal of J M⁻¹ Jᵀ, over the trees that they move, and the penalties of it."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.contact import ROW_PENALTY

LIGHTEST = 1e-9
"""Share of the largest weight that every row's counts at least [-]: a row that the mechanism hardly moves
must not be given a penalty without bounds."""


@inline_kernel
def _weigh(
    J: FloatArray, first: int, dim: int, reached: IntArray, factors: FloatArray, rows: IntArray,
    starts: IntArray, columns: IntArray, inverses: FloatArray, y: FloatArray, sizes: FloatArray,
) -> None:  # fmt: skip
    """Fill J M⁻¹ Jᵀ of each of a block's rows, over the trees between its first and last column.

    inverses (n,) are those of the factors' diagonal, y (n, 3) is room; three rows go down the trees
    together, as `half_solve_tree` does.
    """
    for a in range(6):
        sizes[a] = 0.0
    few = reached[0]
    if few == 0:
        return
    low, high = columns[starts[reached[1]]], reached[few]  # from the root of the first one's tree
    for start in range(0, dim, 3):
        for j in range(low, high + 1):
            for a in range(3):
                y[j, a] = J[first + start + a, j] if start + a < dim else 0.0
        for j in range(high, low - 1, -1):
            if y[j, 0] == 0.0 and y[j, 1] == 0.0 and y[j, 2] == 0.0:
                continue
            last = starts[j] + rows[j] - 1
            for c in range(starts[j], last):
                for a in range(3):
                    y[columns[c], a] -= factors[c] * y[j, a]
            for a in range(3):
                sizes[start + a] += y[j, a] * y[j, a] * inverses[j]


@inline_kernel
def fill_weights(
    J: FloatArray, reached: IntArray, table: IntArray, numbers: FloatArray, factors: FloatArray,
    rows: IntArray, starts: IntArray, columns: IntArray,
) -> None:  # fmt: skip
    """Fill weight and penalties in the numbers (k, 6) of every block, from the diagonal of J M⁻¹ Jᵀ.

    J (m, nv), reached (k, nv + 1), table (k, 4): see `surefoot.contact.rows.blocks`; factors of M and where
    they are: see `factor_tree`.
    """
    y, sizes, top = np.empty((rows.size, 3)), np.empty(6), 0.0
    inverses = np.empty(rows.size)
    for j in range(rows.size):
        inverses[j] = 1.0 / factors[starts[j] + rows[j] - 1]
    for k in range(table.shape[0]):
        _weigh(J, table[k, 2], table[k, 1], reached[k], factors, rows, starts, columns, inverses, y, sizes)
        total, others = sizes[0], 0.0
        for a in range(1, table[k, 1]):
            total += sizes[a]
            others = max(others, sizes[a])
        numbers[k, 2], numbers[k, 3], numbers[k, 4] = total, sizes[0], others
        top = max(top, total)
    for k in range(table.shape[0]):
        numbers[k, 3] = ROW_PENALTY / max(numbers[k, 3], LIGHTEST * top)
        numbers[k, 4] = ROW_PENALTY / max(numbers[k, 4], LIGHTEST * top)
