"""Which blocks the matrix of an interior point's step has: I + Yᵀ P S⁻¹ Y, Y the factor of G = Y Yᵀ.

The rows of a contact move the few bodies that meet there: the matrix has a block where two bodies touch, and
its factors fill few others (`elimination`). A pit of 100 balls at rest takes a seventh of the time of a band
in the order of Cuthill and McKee, let alone of a dense matrix.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import IntArray
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
    contact = np.repeat(np.arange(m) // 3, np.diff(factor.indptr))
    moves: Any = sp.csr_matrix((np.ones(factor.nnz), (contact, factor.indices)), shape=(m // 3, r))
    by_column = moves.tocsc()
    by_column.sort_indices()
    where = group_columns(by_column.indptr, by_column.indices, SIZE, ALIKE)
    count = int(where.max(initial=-1)) // SIZE + 1
    if not 0 < count <= MOST_BLOCKS:
        return dense
    # which blocks a contact moves, numbered as they are eliminated
    group = where // SIZE
    met: Any = sp.csr_matrix((np.ones(moves.nnz), group[moves.indices], moves.indptr), shape=(m // 3, count))
    number = np.empty(count, dtype=np.int64)
    number[least_degree((met.T @ met).tocsc())] = np.arange(count)
    met = sp.csr_matrix((met.data, number[met.indices], met.indptr), shape=met.shape)
    met.sum_duplicates()
    elimination = find_elimination((met.T @ met).tocsr(), WORTH * dense.work / PRODUCT)
    if elimination is None:
        return dense
    moved = _list_rows(met)
    one, two = np.broadcast_arrays(moved[:, :, None], moved[:, None, :])
    both = (one >= 0) & (two >= 0)
    products = np.where(both, find_places(elimination, np.maximum(one, 0), np.maximum(two, 0)), -1)
    place = np.where(where < 0, -1, SIZE * number[group] + where % SIZE)
    work = PRODUCT * (elimination.targets.size + 0.5 * np.count_nonzero(both))
    return Structure(elimination, place, moved, products, work)


def _list_rows(matrix: Any) -> IntArray:
    """Return the columns of each row's entries (n, widest), compressed rows, filled up with -1."""
    widths = np.diff(matrix.indptr)
    out = np.full((matrix.shape[0], int(widths.max())), -1)
    slot = np.arange(matrix.nnz) - np.repeat(matrix.indptr[:-1], widths)
    out[np.repeat(np.arange(len(out)), widths), slot] = matrix.indices
    return out
