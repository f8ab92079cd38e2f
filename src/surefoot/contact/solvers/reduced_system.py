"""The matrix of an interior point's step, I + Yᵀ P S⁻¹ Y: dense, or a band where the bodies are known.

The rows of a contact move the few bodies that meet there: in the order of Cuthill and McKee, which numbers
bodies that touch near each other, the matrix is a band, whose factors take a wall or a pit of balls a tenth
of the time. Known are the bodies where the problem has a sparse factor.

Source: E. Cuthill, J. McKee, "Reducing the bandwidth of sparse symmetric matrices", 1969.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.cone_pairs import weigh_rows

BANDED = 0.2
"""A band is taken where its factors and its assembly take less than this share of a dense matrix's work."""


class Rows(NamedTuple):
    """The rows of Y.

    Attributes
    ----------
    values, across
        (3n, r) all of them, and transposed; of a band (3n, w) those columns that a contact moves, and empty.
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
    """LAPACK's factors, transposed, with their pivots (r,).

    Of a dense matrix (r, r); of one with so many diagonals on either side as `band` says (r, 3 band + 1).
    """

    lu: FloatArray
    pivots: IntArray
    band: int


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
    if factors.band > 0:
        _solve_band(factors.lu, factors.pivots, factors.band, right)
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


@inline_kernel
def _solve_band(columns: FloatArray, pivots: IntArray, band: int, right: FloatArray) -> None:
    """Solve in place with factors of `dgbtrf`: row k has column k, its diagonal at 2 band."""
    r, middle = right.size, 2 * band
    for k in range(r):
        other = pivots[k]
        right[k], right[other] = right[other], right[k]
        x = right[k]
        for i in range(1, min(band, r - 1 - k) + 1):
            right[k + i] -= columns[k, middle + i] * x
    for k in range(r - 1, -1, -1):
        x = right[k] / columns[k, middle]
        right[k] = x
        least = min(middle, k)
        for i in range(least):
            right[k - least + i] -= columns[k, middle - least + i] * x


@kernel
def _fill_band(rows: Rows, weights: FloatArray, band: int, out: FloatArray) -> None:
    """Fill out (r, 3 band + 1) with the columns of I + Yᵀ P S⁻¹ Y, weights P S⁻¹ (n, 3, 3)."""
    out[:] = 0.0
    out[:, 2 * band] = 1.0
    values, columns = rows.values, rows.columns
    w = columns.shape[1]
    for k in range(len(weights)):
        for d in range(w):
            j = columns[k, d]
            p, q, s = values[3 * k, d], values[3 * k + 1, d], values[3 * k + 2, d]
            if p == 0.0 and q == 0.0 and s == 0.0:
                continue
            a = weights[k, 0, 0] * p + weights[k, 0, 1] * q + weights[k, 0, 2] * s
            b = weights[k, 1, 0] * p + weights[k, 1, 1] * q + weights[k, 1, 2] * s
            c = weights[k, 2, 0] * p + weights[k, 2, 1] * q + weights[k, 2, 2] * s
            for e in range(w):
                product = values[3 * k, e] * a + values[3 * k + 1, e] * b + values[3 * k + 2, e] * c
                out[j, 2 * band + columns[k, e] - j] += product


class Structure(NamedTuple):
    """What the matrix of a factor is: its band, the order of its columns, and the work of its factors.

    Attributes
    ----------
    band
        Diagonals on either side; zero for a dense matrix.
    order
        (r,) of the columns; empty for a dense matrix.
    moves
        Which columns a contact moves, (n, r) in compressed rows; None for a dense matrix.
    work
        About so many multiplications take the matrix and its factors.
    """

    band: int
    order: IntArray
    moves: Any
    work: float


def find_structure(factor: Any) -> Structure:
    """Return what the matrix of Y (3n, r) is: a band where Y is sparse and that takes much less work."""
    m, r = factor.shape
    dense = Structure(0, np.empty(0, dtype=np.int64), None, float(m) * r * r)
    if isinstance(factor, np.ndarray):
        return dense
    contact = np.repeat(np.arange(m) // 3, np.diff(factor.indptr))
    moves: Any = sp.csr_matrix((np.ones(factor.nnz), (contact, factor.indices)), shape=(m // 3, r))
    pattern: Any = (moves.T @ moves).tocsr()
    order = sp.csgraph.reverse_cuthill_mckee(pattern, symmetric_mode=True).astype(np.int64)
    place = np.empty(r, dtype=np.int64)
    place[order] = np.arange(r)
    row = np.repeat(np.arange(r), np.diff(pattern.indptr))
    band = int(np.abs(place[row] - place[pattern.indices]).max(initial=1))
    width = int(np.diff(moves.indptr).max(initial=1))
    work = float(r) * band * band + float(m) * width * width
    if work >= BANDED * dense.work:
        return dense
    placed: Any = sp.csr_matrix((moves.data, place[moves.indices], moves.indptr), shape=moves.shape)
    placed.sort_indices()
    return Structure(band, order, placed, work)


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
        self.band, self._factor = structure.band, factor
        if structure.moves is not None:
            self._own = _narrow(factor[:, structure.order], structure.moves)
            self.rows = self._own._replace(values=scale.reshape(-1, 1) * self._own.values)
            return
        values = factor if isinstance(factor, np.ndarray) else factor.toarray()
        values = np.ascontiguousarray(scale.reshape(-1, 1) * values)
        columns = np.empty((0, 0), dtype=np.int64)
        self.rows = Rows(values, np.ascontiguousarray(values.T), columns, values.shape[1])
        self._weighed, self._diagonal = np.empty_like(values), np.diag_indices(values.shape[1])

    def multiply_square(self, forces: FloatArray) -> FloatArray:
        """Return Y Yᵀ times forces (n, 3) as (n, 3), of the rows as they were before they were scaled."""
        if self.band:
            return square_rows(self._own, forces)
        return np.asarray(self._factor @ (self._factor.T @ forces.ravel())).reshape(-1, 3)

    def factorise(self, weights: FloatArray) -> Factors | None:
        """Return the factors for weights P S⁻¹ (n, 3, 3); None where LAPACK has none."""
        if self.band:
            band = np.empty((self.rows.size, 3 * self.band + 1))
            _fill_band(self.rows, weights, self.band, band)
            lu, pivots, failed = scipy.linalg.lapack.dgbtrf(band.T, self.band, self.band, overwrite_ab=1)
        else:
            weigh_rows(weights, self.rows.values, self._weighed)
            matrix = self._weighed.T @ self.rows.values  # transposed, as LAPACK has it
            matrix[self._diagonal] += 1.0
            lu, pivots, failed = scipy.linalg.lapack.dgetrf(matrix.T, overwrite_a=1)
        return None if failed else Factors(lu.T, pivots, self.band)


def _narrow(factor: Any, moves: Any) -> Rows:
    """Return the rows of a sparse factor (3n, r) on the columns that its contacts move."""
    n, r = moves.shape
    width = int(np.diff(moves.indptr).max(initial=1))
    contact = np.repeat(np.arange(n), np.diff(moves.indptr))
    slot = np.arange(moves.nnz) - moves.indptr[contact]
    columns, values = np.zeros((n, width), dtype=np.int64), np.zeros((3 * n, width))
    # filled up with columns of its own, so that all of a contact's products are within the band
    last = np.maximum(moves.indptr[1:] - 1, 0)
    columns[:] = moves.indices[last][:, None]
    columns[contact, slot] = moves.indices
    row = np.repeat(np.arange(3 * n), np.diff(factor.indptr))
    place = np.searchsorted(contact * r + moves.indices, row // 3 * r + factor.indices)
    values[row, slot[place]] = factor.data
    return Rows(values, np.empty((0, 0)), columns, r)


def orientation(factors: Factors) -> float:
    """Return the sign of a matrix's determinant.

    Along a path that has no branches the gap falls where it is positive, and rises where it is not.
    """
    own = factors.lu[:, 2 * factors.band] if factors.band else np.diagonal(factors.lu)
    swapped = np.count_nonzero(factors.pivots != np.arange(factors.pivots.size))
    return 1.0 if (np.count_nonzero(own < 0.0) + swapped) % 2 == 0 else -1.0
