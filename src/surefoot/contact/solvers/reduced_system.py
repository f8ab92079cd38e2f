"""The matrix of an interior point's step, I + Yᵀ P S⁻¹ Y: dense, or sparse where the bodies are known.

The rows of a contact move the few bodies that meet there: the matrix has a block where two bodies touch, and
its factors fill few others (`elimination`). A pit of 100 balls at rest takes a fifth of the time of a band,
let alone of a dense matrix. Known are the bodies where the problem has a sparse factor.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.block_factors import factorise_blocks, fill_blocks, solve_blocks
from surefoot.contact.solvers.cone_pairs import weigh_rows
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


class Rows(NamedTuple):
    """The rows of Y.

    Attributes
    ----------
    values, across
        (3n, r) all of them, and transposed; of a sparse matrix (3n, w) the columns that a contact moves, and
        empty.
    columns
        (n, w) which these are, filled up where there are fewer; (0, 0) where all are kept.
    size
        r.
    """

    values: FloatArray
    across: FloatArray
    columns: IntArray
    size: int


class Factors(NamedTuple):
    """The factors of a dense matrix or of a sparse one; the other's parts are empty.

    Attributes
    ----------
    lu
        LAPACK's, transposed (r, r).
    blocks, starts, below
        Of `factorise_blocks`, and where they are: see `Elimination`.
    pivots
        (r,) of either.
    sign
        That of the determinant; zero where there are no factors.
    """

    lu: FloatArray
    blocks: FloatArray
    starts: IntArray
    below: IntArray
    pivots: IntArray
    sign: float


NO_LU, NO_BLOCKS = np.empty((0, 0)), np.empty((0, SIZE, SIZE))


@inline_kernel
def gather_rows(rows: Rows, forces: FloatArray, out: FloatArray) -> None:
    """Fill out (r,) with the transposed rows times forces (n, 3)."""
    out[:] = 0.0
    columns = rows.columns
    for k in range(len(forces)):
        x, y, z = forces[k, 0], forces[k, 1], forces[k, 2]
        one, two, three = rows.values[3 * k], rows.values[3 * k + 1], rows.values[3 * k + 2]
        if columns.size == 0:
            for j in range(out.size):
                out[j] += one[j] * x + two[j] * y + three[j] * z
        else:
            for c in range(columns.shape[1]):
                out[columns[k, c]] += one[c] * x + two[c] * y + three[c] * z


@inline_kernel
def apply_rows(rows: Rows, v: FloatArray, out: FloatArray) -> None:
    """Fill out (3n,) with the rows times v (r,)."""
    out[:] = 0.0
    columns = rows.columns
    if columns.size == 0:
        for j in range(v.size):  # column by column: sums of products would go one by one
            x = v[j]
            for i in range(out.size):
                out[i] += rows.across[j, i] * x
    else:
        for k in range(len(columns)):
            one, two, three = rows.values[3 * k], rows.values[3 * k + 1], rows.values[3 * k + 2]
            x = y = z = 0.0
            for c in range(columns.shape[1]):
                moved = v[columns[k, c]]
                x += one[c] * moved
                y += two[c] * moved
                z += three[c] * moved
            out[3 * k], out[3 * k + 1], out[3 * k + 2] = x, y, z


@kernel
def square_rows(rows: Rows, forces: FloatArray) -> FloatArray:
    """Return the rows times their transpose times forces (n, 3), as (n, 3)."""
    v, out = np.empty(rows.size), np.empty(forces.size)
    gather_rows(rows, forces, v)
    apply_rows(rows, v, out)
    return out.reshape(-1, 3)


@inline_kernel
def solve_factors(factors: Factors, right: FloatArray) -> None:
    """Solve in place for a right-hand side (r,)."""
    if factors.starts.size > 0:
        solve_blocks(factors.starts, factors.below, factors.blocks, factors.pivots, right)
        return
    columns, pivots, r = factors.lu, factors.pivots, right.size
    for k in range(r):
        other = pivots[k]
        right[k], right[other] = right[other], right[k]
    for k in range(r):
        x = right[k]
        for i in range(k + 1, r):
            right[i] -= columns[k, i] * x
    for k in range(r - 1, -1, -1):
        x = right[k] / columns[k, k]
        right[k] = x
        for i in range(k):
            right[i] -= columns[k, i] * x


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
    order = least_degree((met.T @ met).tocsc())
    number = np.empty(count, dtype=np.int64)
    number[order] = np.arange(count)
    met = sp.csr_matrix((met.data, number[met.indices], met.indptr), shape=met.shape)
    met.sum_duplicates()
    elimination = find_elimination((met.T @ met).tocsr(), WORTH * dense.work / PRODUCT)
    if elimination is None:
        return dense
    widths = np.diff(met.indptr)
    moved = np.full((m // 3, int(widths.max())), -1)
    slot = np.arange(met.nnz) - np.repeat(met.indptr[:-1], widths)
    moved[np.repeat(np.arange(m // 3), widths), slot] = met.indices
    one, two = np.broadcast_arrays(moved[:, :, None], moved[:, None, :])
    both = (one >= 0) & (two >= 0)
    products = np.where(both, find_places(elimination, np.maximum(one, 0), np.maximum(two, 0)), -1)
    place = np.where(where < 0, -1, SIZE * number[group] + where % SIZE)
    work = PRODUCT * (elimination.targets.size + 0.5 * np.count_nonzero(both))
    return Structure(elimination, place, moved, products, work)


class ReducedSystem:
    """The matrix of one problem: its rows, in an order that suits, and its factors for any weights.

    Parameters
    ----------
    factor
        Y (3n, r), dense, or sparse where the bodies are known.
    scale
        (n, 3) by which its rows are multiplied.
    structure
        Of the factor.
    """

    def __init__(self, factor: Any, scale: FloatArray, structure: Structure) -> None:
        self._factor, self._structure = factor, structure
        if structure.sparse:
            self._own = _narrow(factor, structure)
            self.rows = self._own._replace(values=scale.reshape(-1, 1) * self._own.values)
            below = structure.elimination.below.size
            self._shape = structure.elimination.starts.size - 1 + 2 * below, SIZE, SIZE
            return
        values = factor if isinstance(factor, np.ndarray) else factor.toarray()
        values = np.ascontiguousarray(scale.reshape(-1, 1) * values)
        columns = np.empty((0, 0), dtype=np.int64)
        self.rows = Rows(values, np.ascontiguousarray(values.T), columns, values.shape[1])
        self._weighed, self._diagonal = np.empty_like(values), np.diag_indices(values.shape[1])

    def multiply_square(self, forces: FloatArray) -> FloatArray:
        """Return Y Yᵀ times forces (n, 3) as (n, 3), of the rows as they were before they were scaled."""
        if self._structure.sparse:
            return square_rows(self._own, forces)
        return np.asarray(self._factor @ (self._factor.T @ forces.ravel())).reshape(-1, 3)

    def factorise(self, weights: FloatArray) -> Factors | None:
        """Return the factors for weights P S⁻¹ (n, 3, 3); None where there are none."""
        parts = self._structure.elimination
        if self._structure.sparse:
            blocks = np.empty(self._shape)
            fill_blocks(self.rows.values, self._structure.products, weights, parts.starts.size - 1, blocks)
            pivots = np.empty(self.rows.size, dtype=np.int64)
            sign = factorise_blocks(parts, blocks, pivots)
            return None if sign == 0.0 else Factors(NO_LU, blocks, parts.starts, parts.below, pivots, sign)
        weigh_rows(weights, self.rows.values, self._weighed)
        matrix = self._weighed.T @ self.rows.values  # transposed, as LAPACK has it
        matrix[self._diagonal] += 1.0
        lu, exchanged, failed = scipy.linalg.lapack.dgetrf(matrix.T, overwrite_a=1)
        if failed:
            return None
        pivots = exchanged.astype(np.int64)
        swapped = np.count_nonzero(pivots != np.arange(pivots.size))
        sign = 1.0 if (np.count_nonzero(np.diagonal(lu) < 0.0) + swapped) % 2 == 0 else -1.0
        return Factors(lu.T, NO_BLOCKS, parts.starts, parts.below, pivots, sign)


def _narrow(factor: Any, structure: Structure) -> Rows:
    """Return the rows of a sparse factor (3n, r) on the blocks that its contacts move."""
    moved, place = structure.moved, structure.place
    n, width = moved.shape
    first = SIZE * np.maximum(
        np.maximum(moved, moved[:, :1]), 0
    )  # those of no block are the first one's, times zero
    columns = np.ascontiguousarray((first[:, :, None] + np.arange(SIZE)).reshape(n, SIZE * width))
    values = np.zeros((3 * n, SIZE * width))
    row = np.repeat(np.arange(3 * n), np.diff(factor.indptr))
    at = place[factor.indices]
    slot = np.argmax(moved[row // 3] == (at // SIZE)[:, None], axis=1)
    np.add.at(values, (row, SIZE * slot + at % SIZE), factor.data)  # an entry may be stored in parts
    return Rows(values, np.empty((0, 0)), columns, SIZE * (structure.elimination.starts.size - 1))
