"""Which blocks the elimination of a sparse symmetric pattern fills, in an order that fills few.

Unknowns that move together, such as the six of a body, are one block, up to `SIZE` of them: products of small
dense blocks cost a fraction of what entries one by one do. The order is least degree, from SuperLU.

Source: T. A. Davis, "Direct methods for sparse linear systems", 2006, chapters 4 and 7.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.base.arrays import BoolArray, IntArray
from surefoot.base.kernels import kernel

SIZE = 6
"""Unknowns of a block."""
ALIKE = 0.5
"""Share of the contacts that either moves which two neighbours have in common, to be in one block."""
LIKE_ALL: dict[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True},
}  # fmt: skip
"""How SuperLU orders a symmetric pattern whose diagonal dominates."""


class Elimination(NamedTuple):
    """What is filled, blocks numbered in the order in which they are eliminated.

    Attributes
    ----------
    starts, below
        (B + 1,) where each block column begins in (nb,) the rows of its blocks below the diagonal, ascending.
    first, targets
        (B + 1,) where each column begins in (p,) the places of the blocks that its elimination changes: for
        each pair of blocks below its diagonal, row by row.

    Blocks are kept in one array: the diagonal's B, then for each of `below` that block and its mirror image.
    """

    starts: IntArray
    below: IntArray
    first: IntArray
    targets: IntArray


NOTHING = Elimination(*(np.zeros(0, dtype=np.int64) for _ in range(4)))
"""For a dense matrix."""


@kernel
def group_columns(starts: IntArray, contacts: IntArray, size: int, alike: float) -> IntArray:
    """Return where each column (r,) is, `size` times its block and its place there; -1 for none.

    Blocks are neighbours that move mostly the same contacts.

    Parameters
    ----------
    starts, contacts
        (r + 1,) where each column begins in (nnz,) the contacts that it moves, ascending.
    size
        Columns of a block at most.
    alike
        See `ALIKE`.
    """
    r = starts.size - 1
    where = np.full(r, -1)
    count, members, last = 0, 0, -1
    for j in range(r):
        own = starts[j + 1] - starts[j]
        if own == 0:
            continue
        joined = False
        if last >= 0 and members < size:
            a, b, both = starts[last], starts[j], 0
            while a < starts[last + 1] and b < starts[j + 1]:
                if contacts[a] == contacts[b]:
                    a, b, both = a + 1, b + 1, both + 1
                elif contacts[a] < contacts[b]:
                    a += 1
                else:
                    b += 1
            joined = both >= alike * (own + starts[last + 1] - starts[last] - both)
        if joined:
            members += 1
        else:
            count, members = count + 1, 1
        where[j], last = size * (count - 1) + members - 1, j
    return where


def least_degree(meet: BoolArray) -> IntArray:
    """Return the blocks in an order in which their elimination fills few others.

    Parameters
    ----------
    meet
        (B, B) which blocks are there, symmetric, its diagonal full.
    """
    n = len(meet)
    row, column = np.nonzero(meet)
    starts = np.append(0, np.cumsum(np.count_nonzero(meet, axis=1)))
    values = np.where(row == column, float(n), -1.0)
    matrix: Any = sp.csc_matrix((values, column.astype(np.int32), starts.astype(np.int32)), shape=(n, n))
    return np.argsort(scipy.sparse.linalg.splu(matrix, **LIKE_ALL).perm_c, kind="stable").astype(np.int64)


@kernel
def _fill(meet: BoolArray) -> BoolArray:
    """Return (B, B) which blocks below the diagonal are filled where these are there, columns as rows."""
    n = len(meet)
    filled = np.zeros((n, n), dtype=np.bool_)
    for k in range(n):
        for i in range(k + 1, n):
            filled[k, i] = meet[k, i]
    for k in range(n):
        parent = n
        for i in range(k + 1, n):
            if filled[k, i]:
                parent = i
                break
        for i in range(parent + 1, n):
            filled[parent, i] |= filled[k, i]
    return filled


@kernel
def find_places(starts: IntArray, below: IntArray) -> IntArray:
    """Return (B, B) where an elimination's blocks are, by row and column; -1 for those that stay zero.

    Its columns begin at `starts` (B + 1,) in `below` (nb,), see `Elimination`.
    """
    n = starts.size - 1
    place = np.full((n, n), -1)
    for k in range(n):
        place[k, k] = k
        for e in range(starts[k], starts[k + 1]):
            place[below[e], k], place[k, below[e]] = n + 2 * e, n + 2 * e + 1
    return place


@kernel
def _targets(starts: IntArray, below: IntArray, first: IntArray) -> IntArray:
    """Return the places of the blocks that each column's elimination changes."""
    n = starts.size - 1
    place, targets = find_places(starts, below), np.empty(first[n], dtype=np.int64)
    for k in range(n):
        at = first[k]
        for d in range(starts[k], starts[k + 1]):
            for e in range(starts[k], starts[k + 1]):
                targets[at] = place[below[d], below[e]]
                at += 1
    return targets


def find_elimination(meet: BoolArray, most: float) -> Elimination | None:
    """Return what the elimination of blocks (B, B), symmetric, fills in the order that they have.

    None where it takes more products of blocks than `most`.
    """
    filled = _fill(meet)
    counts = np.count_nonzero(filled, axis=1)
    starts = np.append(0, np.cumsum(counts)).astype(np.int64)
    first = np.append(0, np.cumsum(counts * counts)).astype(np.int64)
    if first[-1] > most:
        return None
    below = np.nonzero(filled)[1].astype(np.int64)
    return Elimination(starts, below, first, _targets(starts, below, first))
