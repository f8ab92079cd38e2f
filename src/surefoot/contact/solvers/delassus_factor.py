"""A factor Y of G = Y Yᵀ: the problem's own where the bodies are known, else Cholesky's, sparse if it can be.

Walls and stacks are long: in the order of Cuthill and McKee contacts meet only contacts of near numbers. G is
semidefinite, so that its factor needs pivots: the largest of all scatters them, and fills the factor; the
largest of the next few rows is nearly as good, and leaves it sparse. Rows whose pivot is zero to rounding
depend on others; what is left has as many columns as G has rank.

Source: N. Higham, "Analysis of the Cholesky decomposition of a semi-definite matrix", 1990.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.redundancy import likely_rank
from surefoot.contact.solvers.reduced_structure import Structure, find_structure

SPARSE_FROM = 240
"""Rows from which a sparse factor is looked for where the bodies are not known."""
MOST_ROWS = 2000
"""Rows up to which a factor is looked for: their matrix is kept in full."""
WINDOW = 12
"""Rows among which the next pivot is chosen."""
NOTHING, DROPPED = 1e-10, 1e-11
"""Pivots and entries of the factor that count as zero, where a contact's block has a trace of one."""
ROUNDING = 1e-10
"""By how much Y Yᵀ may miss G then."""


@kernel
def _factorise(R: FloatArray, window: int, nothing: float, dropped: float, pivots: IntArray) -> int:
    """Put a column of the factor of a semidefinite R (m, m) in each pivot's row; return how many.

    A pivot is the largest of the next rows; what is at most `nothing` counts as zero, and entries of at most
    `dropped` are.
    """
    m, count, start = len(R), 0, 0
    used, near = np.zeros(m, dtype=np.bool_), np.empty(m, dtype=np.int64)
    while True:
        while start < m and (used[start] or R[start, start] <= nothing):
            start += 1
        if start == m:
            return count
        pivot = start
        for k in range(start, min(start + window, m)):
            if not used[k] and R[k, k] > R[pivot, pivot]:
                pivot = k
        root, meets = np.sqrt(R[pivot, pivot]), 0
        for k in range(m):
            entry = R[pivot, k] / root
            if used[k] or abs(entry) <= dropped:
                R[pivot, k] = 0.0
                continue
            R[pivot, k] = entry
            if k != pivot:
                near[meets] = k
                meets += 1
        used[pivot] = True
        pivots[count] = pivot
        count += 1
        for a in range(meets):
            x = R[pivot, near[a]]
            for b in range(meets):
                R[near[a], near[b]] -= x * R[pivot, near[b]]


def sparse_factor(problem: ContactProblem, rows: BoolArray) -> Any:
    """Return a sparse Y (rows, r) with G = Y Yᵀ; None for too many rows, or where it is not near enough.

    Parameters
    ----------
    problem
        With three rows a contact.
    rows
        (m,) which of G's rows count, all three of a contact or none.
    """
    chosen = np.flatnonzero(rows)
    m = len(chosen)
    if m > MOST_ROWS:
        return None
    b, contacts = problem.blocks, chosen[::3] // 3
    number: Any = sp.csr_matrix((np.arange(b.columns.size), b.columns, b.starts))
    number = number[contacts][:, contacts]
    order = sp.csgraph.reverse_cuthill_mckee(number, symmetric_mode=True)
    number = number[order][:, order]
    # light bodies and heavy ones count alike: the blocks of all contacts are made as large as one
    row, blocks = np.repeat(np.arange(len(contacts)), np.diff(number.indptr)), b.values[number.data]
    trace = np.trace(blocks[row == number.indices], axis1=1, axis2=2)
    size = np.sqrt(np.where(trace > 0.0, trace, 1.0))
    G: Any = sp.bsr_matrix(
        (blocks / (size[row] * size[number.indices])[:, None, None], number.indices, number.indptr)
    )
    R, pivots = G.toarray(), np.empty(m, dtype=np.int64)
    count = _factorise(R, WINDOW, NOTHING, DROPPED, pivots)
    columns = R[pivots[:count]]
    column, row = np.nonzero(columns)
    Y: Any = sp.csr_matrix((columns[column, row], (row, column)), shape=(m, count))
    probe = np.random.default_rng(0).uniform(-1.0, 1.0, size=(m, 2))
    far = float(np.abs(Y @ (Y.T @ probe) - G @ probe).max(initial=0.0))
    if not far <= ROUNDING * np.sqrt(m):
        return None
    Y.data *= np.repeat(np.repeat(size, 3), np.diff(Y.indptr))
    return Y[(3 * np.argsort(order)[:, None] + np.arange(3)).ravel()]


def likely_work(problem: ContactProblem) -> float:
    """Return the multiplications of a step's matrix where it is dense, as far as `likely_rank` knows."""
    return float(problem.g.size * likely_rank(problem) ** 2)


def find_factor(
    problem: ContactProblem, rows: BoolArray, most: float = math.inf
) -> tuple[Any, Structure] | None:
    """Return Y (rows, r) with G = Y Yᵀ and its structure: the problem's own, a sparse or a pivoted dense one.

    None where its matrix takes more multiplications than wanted, as far as `likely_rank` knows of a dense
    one.
    """
    factor = None if problem.factor is None else problem.factor[rows]
    known = factor is not None
    if not known and problem.g.size >= SPARSE_FROM:
        factor = sparse_factor(problem, rows)
    structure = None if factor is None else find_structure(factor)
    # of what is not sparse the pivots of a dense one leave less rounding
    if structure is None or not (known or structure.sparse):
        if likely_work(problem) > most:
            return None
        G = problem.G if rows.all() else problem.G[np.ix_(rows, rows)]
        lower, order, rank, _ = scipy.linalg.lapack.dpstrf(G, lower=1)
        factor = np.empty((len(G), rank))
        factor[order - 1] = np.tril(lower[:, :rank])
        structure = find_structure(factor)
    return None if structure.work > most else (factor, structure)
