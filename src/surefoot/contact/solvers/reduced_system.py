"""The matrix of an interior point's step, I + Yᵀ P S⁻¹ Y: dense, or sparse where the bodies are known.

Which it is `reduced_structure` finds. Known are the bodies where the problem has a sparse factor.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.block_factors import factorise_blocks, fill_blocks, solve_blocks
from surefoot.contact.solvers.cone_pairs import weigh_rows
from surefoot.contact.solvers.elimination import SIZE
from surefoot.contact.solvers.reduced_structure import Structure


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
    # columns of no block are those of the first one, times zero
    first = SIZE * np.maximum(np.where(moved < 0, moved[:, :1], moved), 0)
    columns = np.ascontiguousarray((first[:, :, None] + np.arange(SIZE)).reshape(n, SIZE * width))
    values = np.zeros((3 * n, SIZE * width))
    _fill_rows(factor.indptr, place[factor.indices], factor.data, moved, values)
    return Rows(values, np.empty((0, 0)), columns, SIZE * (structure.elimination.starts.size - 1))


@kernel
def _fill_rows(
    starts: IntArray, places: IntArray, entries: FloatArray, moved: IntArray, out: FloatArray
) -> None:
    """Add the entries (nnz,) of compressed rows (3n) to out (3n, w), on the blocks (n, b) that are moved.

    Rows begin at `starts` (3n + 1,), and entries have places (nnz,) among the unknowns of all blocks.
    """
    for k in range(len(out)):
        for e in range(starts[k], starts[k + 1]):
            block, slot = places[e] // SIZE, 0
            while moved[k // 3, slot] != block:
                slot += 1
            out[k, SIZE * slot + places[e] % SIZE] += entries[e]  # one may be stored in parts
