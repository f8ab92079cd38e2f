"""Which blocks the matrix of an interior point's step has: I + Yᵀ P S⁻¹ Y, Y the factor of G = Y Yᵀ.

The rows of a contact move the few bodies that meet there: the matrix has a block where two bodies touch, and
its factors fill few others (`elimination`). A pit of 100 balls at rest takes a seventh of the time of a band
in the order of Cuthill and McKee, let alone of a dense matrix.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.contact.solvers.elimination import (
    ALIKE,
    NOTHING,
    SIZE,
    Elimination,
    find_elimination,
    find_places,
    group_columns,
    least_degree,
)

PRODUCT = 800.0
"""Multiplications that LAPACK does while one product of blocks is taken."""
WORTH = 0.2
"""Sparse factors are taken where they take less than this share of a dense matrix's work."""
MOST_BLOCKS = 2000
"""Blocks up to which they are looked for: what is filled is kept in full."""


class Structure(NamedTuple):
    """What the matrix of a factor is.

    Attributes
    ----------
    elimination
        Of its blocks; `NOTHING` for a dense matrix.
    place
        (r,) of the factor's columns among the unknowns of all blocks; -1 for those that move no contact.
    moved, products
        (n, b) blocks that each contact moves, -1 where it moves fewer, and (n, b, b) the places of their
        products.
    work
        About so many multiplications of LAPACK take as long as the matrix and its factors.
    """

    elimination: Elimination
    place: IntArray
    moved: IntArray
    products: IntArray
    work: float

    @property
    def sparse(self) -> bool:
        """Whether the matrix is kept as blocks."""
        return self.elimination.starts.size > 0


def find_structure(factor: Any) -> Structure:
    """Return what the matrix of Y (3n, r) is: sparse where Y is, and where that takes much less work."""
    m, r = factor.shape
    none = np.empty(0, dtype=np.int64)
    dense = Structure(NOTHING, none, none.reshape(0, 0), none.reshape(0, 0, 0), float(m) * r * r)
    if isinstance(factor, np.ndarray):
        return dense
    starts = factor.indptr[::3].astype(np.int64)
    by_column: Any = sp.csr_matrix((factor.data, factor.indices, starts), shape=(m // 3, r)).tocsc()
    by_column.sum_duplicates()
    where = group_columns(by_column.indptr, by_column.indices, SIZE, ALIKE)
    count = int(where.max(initial=-1)) // SIZE + 1
    if not 0 < count <= MOST_BLOCKS:
        return dense
    moved = _list_blocks(starts, where[factor.indices] // SIZE)
    meet = _find_meeting(moved, count)
    order = least_degree(meet)
    elimination = find_elimination(meet[order][:, order], WORTH * dense.work / PRODUCT)
    if elimination is None:
        return dense
    # numbered as they are eliminated
    number = np.empty(count, dtype=np.int64)
    number[order] = np.arange(count)
    moved = np.where(moved >= 0, number[moved], -1)
    one, two = np.broadcast_arrays(moved[:, :, None], moved[:, None, :])
    both = (one >= 0) & (two >= 0)
    products = np.where(both, find_places(elimination.starts, elimination.below)[one, two], -1)
    place = np.where(where < 0, -1, SIZE * number[where // SIZE] + where % SIZE)
    work = PRODUCT * (elimination.targets.size + 0.5 * np.count_nonzero(both))
    return Structure(elimination, place, moved, products, work)


@kernel
def _list_blocks(starts: IntArray, blocks: IntArray) -> IntArray:
    """Return the blocks that each contact moves (n, widest), filled up with -1.

    Each contact's entries begin at `starts` (n + 1,) among the blocks (nnz,) of all; some come twice.
    """
    n, last = starts.size - 1, np.full(blocks.max() + 1, -1)
    out, widest = np.full((n, np.diff(starts).max()), -1), 0
    for k in range(n):
        count = 0
        for e in range(starts[k], starts[k + 1]):
            if last[blocks[e]] != k:
                last[blocks[e]] = k
                out[k, count] = blocks[e]
                count += 1
        widest = max(widest, count)
    return out[:, :widest].copy()


@kernel
def _find_meeting(moved: IntArray, count: int) -> BoolArray:
    """Return which of so many blocks (B, B) any contact moves together, of what each moves (n, widest)."""
    meet = np.zeros((count, count), dtype=np.bool_)
    for k in range(len(moved)):
        for one in moved[k]:
            for two in moved[k]:
                if one >= 0 and two >= 0:
                    meet[one, two] = True
    return meet
