"""Delassus operators as matrices of 3x3 blocks: checks, block structure and products."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.sets.contact import MOST_FRICTION

MOST_DENSE = 128
"""Contacts up to which a dense G is taken as it lies in memory, changes in place included: by scales and the
compiled call. Of more its blocks are: a look at all of G takes ten times as long as one at them."""


@dataclass(frozen=True)
class Blocks:
    """A symmetric block matrix in compressed rows.

    Attributes
    ----------
    starts
        (n + 1,); the blocks of row k are starts[k] to starts[k + 1].
    columns
        (m,) block columns, rising in each row; the diagonal block is always there.
    values
        (m, 3, 3).
    """

    starts: IntArray
    columns: IntArray
    values: FloatArray

    @property
    def density(self) -> float:
        """Share of the blocks that are stored."""
        n = self.starts.size - 1
        return self.columns.size / (n * n) if n else 1.0


@inline_kernel
def block_determinant(G: FloatArray, i: int, add: float) -> float:
    """Return the determinant of the symmetric 3x3 block of G (m, m) at row i, with `add` on its diagonal."""
    a, b, c = G[i, i] + add, G[i + 1, i + 1] + add, G[i + 2, i + 2] + add
    x, y, z = G[i + 1, i], G[i + 2, i], G[i + 2, i + 1]
    return float(a * (b * c - z * z) - x * (x * c - z * y) + y * (x * z - b * y))


@kernel
def checked_mirror(G: FloatArray, slack: float) -> tuple[float, float, int, int]:
    """Replace G (m, m) by its symmetric part; return max |G| (infinite if not finite), max |G - Gᵀ|, where.

    Where a diagonal entry, a pair's minor or a 3x3 diagonal block shows an eigenvalue of G below
    -slack · max |G|, a negative number and the entry take the place of the last three (row = column for a
    diagonal entry; row 3k, column 3k + 3 for block k). Such signs are sufficient for an indefinite G, not
    necessary. An asymmetry above slack · max |G| goes first.
    """
    scale = gap = 0.0
    row = column = 0
    total = 0.0
    for i in range(G.shape[0]):
        for j in range(i + 1):
            a, b = G[i, j], G[j, i]
            total += a + b  # NaN and infinity survive a sum
            scale = max(scale, abs(a), abs(b))
            if abs(a - b) > gap:
                gap, row, column = abs(a - b), i, j
            G[i, j] = G[j, i] = 0.5 * (a + b)
    if not abs(total) < np.inf:
        return np.inf, gap, row, column
    # G + slack max |G| I is what has to be semidefinite: eigenvalues down to -slack max |G| are rounding
    add = slack * scale
    if gap > add:
        return scale, gap, row, column
    for i in range(G.shape[0]):
        own = G[i, i] + add
        # a semidefinite matrix has no negative diagonal entry,
        if own < 0.0:
            return scale, -1.0, i, i
        for j in range(i):
            # no negative 2x2 minor
            if G[i, j] * G[i, j] > own * (G[j, j] + add):
                return scale, -1.0, i, j
    for i in range(0, G.shape[0] - 2, 3):
        # and no 3x3 diagonal block of negative determinant
        # a determinant's own rounding is some eps times the cube of the trace
        if block_determinant(G, i, add) < -1e-14 * (G[i, i] + G[i + 1, i + 1] + G[i + 2, i + 2]) ** 3:
            return scale, -1.0, i, i + 3
    return scale, gap, row, column


@kernel
def checked_mirror_sparse(
    starts: IntArray, columns: IntArray, values: FloatArray, mirror: FloatArray, slack: float
) -> tuple[float, float, int, int]:
    """Do as `checked_mirror` of finite compressed rows: `starts` (m + 1,), `columns` (k,), `values` (k,).

    `mirror` (k,) are the entries of the transpose, whose places are the same.
    """
    m = starts.size - 1
    scale = gap = 0.0
    row = column = 0
    own = np.zeros(m)
    for i in range(m):
        for at in range(starts[i], starts[i + 1]):
            a, b, j = values[at], mirror[at], columns[at]
            scale = max(scale, abs(a))
            if j < i and abs(a - b) > gap:
                gap, row, column = abs(a - b), i, j
            values[at] = 0.5 * (a + b)
            if i == j:
                own[i] = values[at]
    add = slack * scale
    if gap > add:
        return scale, gap, row, column
    block = np.zeros((3, 3))
    for i in range(m):
        if own[i] + add < 0.0:
            return scale, -1.0, i, i
        if i % 3 == 0:
            block[:] = 0.0
        for at in range(starts[i], starts[i + 1]):
            j = columns[at]
            if j < i and values[at] * values[at] > (own[i] + add) * (own[j] + add):
                return scale, -1.0, i, j
            if j // 3 == i // 3:
                block[i % 3, j % 3] = values[at] / scale if scale > 0.0 else 0.0
        if i % 3 == 2 and block_determinant(block, 0, slack) < -1e-14 * np.trace(block) ** 3:
            return scale, -1.0, i - 2, i + 1
    return scale, gap, row, column


@inline_kernel
def checked_copy(G: FloatArray, slack: float, out: FloatArray) -> tuple[bool, bool]:
    """Fill out with the symmetric part of G, (m, m) both; return whether it is finite, and `checked_mirror`.

    The largest entry of a semidefinite matrix is on its diagonal, so tests against that one are stricter;
    what they doubt (and what is not a number: it passes none) goes through `checked_mirror` itself.
    """
    top = 0.0
    for i in range(G.shape[0]):
        out[i, i] = G[i, i]
        top = max(top, G[i, i])
    add = slack * top
    bad = not top < np.inf
    for i in range(G.shape[0]):
        own = G[i, i] + add
        bad |= not own >= 0.0
        for j in range(i):
            a, b = G[i, j], G[j, i]
            half = 0.5 * (a + b)
            out[i, j] = out[j, i] = half
            # "not <=" and not ">": a NaN fails every test, and goes where it is named
            bad |= not abs(a - b) <= add
            bad |= not half * half <= own * (out[j, j] + add)
    for i in range(0, G.shape[0] - 2, 3):
        trace = out[i, i] + out[i + 1, i + 1] + out[i + 2, i + 2]
        bad |= not block_determinant(out, i, add) >= -1e-14 * trace * trace * trace
    if not bad:
        return True, True
    for i in range(G.shape[0]):
        for j in range(G.shape[0]):
            out[i, j] = G[i, j]
    # `out` holds the symmetric part by now, which hides an asymmetry: afresh from G
    scale, gap, _, _ = checked_mirror(out, slack)
    return scale < np.inf, 0.0 <= gap <= slack * scale


@kernel
def vectors_fit(vectors: FloatArray) -> bool:
    """Tell whether the vectors of a problem, (2, 3n), are finite and in range."""
    n = vectors.shape[1] // 3
    for i in range(vectors.shape[1]):
        if not abs(vectors[0, i]) < np.inf:
            return False
    for k in range(n):
        mu, low, high = vectors[1, k], vectors[1, n + k], vectors[1, 2 * n + k]
        if not (0.0 <= mu <= MOST_FRICTION and 0.0 <= low <= high and low < np.inf):
            return False
    return True


@kernel
def count_blocks(G: FloatArray, met: IntArray) -> None:
    """Fill (n,) with how many blocks of each row of a dense matrix (3n, 3n) are not zero."""
    n = met.size
    for i in range(n):
        count = 0
        for j in range(n):
            found = False
            for a in range(9):
                if G[3 * i + a // 3, 3 * j + a % 3] != 0.0:
                    found = True
                    break
            count += found
        met[i] = count


@kernel
def dense_blocks(G: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the fields of `Blocks` for a dense symmetric matrix (3n, 3n)."""
    n = G.shape[0] // 3
    present = np.zeros((n, n), dtype=np.bool_)
    for i in range(3 * n):
        for j in range(3 * n):
            if G[i, j] != 0.0:
                present[i // 3, j // 3] = True
    # the diagonal block is always kept, zero or not: sweeps look for it
    count = n
    for i in range(n):
        for j in range(n):
            if present[i, j] and i != j:
                count += 1
    starts = np.zeros(n + 1, dtype=np.int64)
    columns = np.empty(count, dtype=np.int64)
    values = np.empty((count, 3, 3))
    at = 0
    for i in range(n):
        for j in range(n):
            if present[i, j] or i == j:
                columns[at] = j
                for a in range(3):
                    for b in range(3):
                        values[at, a, b] = G[3 * i + a, 3 * j + b]
                at += 1
        starts[i + 1] = at
    return starts, columns, values


@kernel
def block_product(starts: IntArray, columns: IntArray, values: FloatArray, x: FloatArray) -> FloatArray:
    """Return the product of a block matrix and a (3n,) vector, in the unit of both."""
    out = np.zeros(x.size)
    for k in range(starts.size - 1):
        a = b = c = 0.0
        for at in range(starts[k], starts[k + 1]):
            j = 3 * columns[at]
            p, q, r = x[j], x[j + 1], x[j + 2]
            a += values[at, 0, 0] * p + values[at, 0, 1] * q + values[at, 0, 2] * r
            b += values[at, 1, 0] * p + values[at, 1, 1] * q + values[at, 1, 2] * r
            c += values[at, 2, 0] * p + values[at, 2, 1] * q + values[at, 2, 2] * r
        out[3 * k], out[3 * k + 1], out[3 * k + 2] = a, b, c
    return out
