"""Sparse factors of a matrix of small dense blocks, compiled: elimination in an order that is given.

Each block of the diagonal has triangular factors with pivots among its own rows; there are none among
blocks. The matrices of an interior point, I + Yᵀ P S⁻¹ Y, are positive definite but for the shift in S.
Inverses of the diagonal's blocks instead are less work and lose the path: a body may be held a billion times
as hard one way as another.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.elimination import SIZE, Elimination


@inline_kernel
def _factorise_one(block: FloatArray, pivots: IntArray) -> float:
    """Factorise a block (SIZE, SIZE) in place with pivots; return the sign of its determinant, or zero."""
    sign = 1.0
    for k in range(SIZE):
        pivot = k
        for i in range(k + 1, SIZE):
            if abs(block[i, k]) > abs(block[pivot, k]):
                pivot = i
        pivots[k] = pivot
        if pivot != k:
            sign = -sign
            for j in range(SIZE):
                block[k, j], block[pivot, j] = block[pivot, j], block[k, j]
        if block[k, k] == 0.0 or not np.isfinite(block[k, k]):
            return 0.0
        if block[k, k] < 0.0:
            sign = -sign
        share = 1.0 / block[k, k]
        for i in range(k + 1, SIZE):
            x = block[i, k] * share
            block[i, k] = x
            for j in range(k + 1, SIZE):
                block[i, j] -= x * block[k, j]
    return sign


@inline_kernel
def _divide_upper(own: FloatArray, block: FloatArray) -> None:
    """Multiply a block (SIZE, SIZE) in place by the inverse of the upper factor from the right."""
    for j in range(SIZE):
        share = 1.0 / own[j, j]
        for i in range(SIZE):
            x = block[i, j] * share
            block[i, j] = x
            for m in range(j + 1, SIZE):
                block[i, m] -= x * own[j, m]


@inline_kernel
def _divide_lower(own: FloatArray, pivots: IntArray, block: FloatArray) -> None:
    """Exchange the rows of a block (SIZE, SIZE), multiply it in place by the lower factor's inverse."""
    for k in range(SIZE):
        pivot = pivots[k]
        if pivot != k:
            for j in range(SIZE):
                block[k, j], block[pivot, j] = block[pivot, j], block[k, j]
    for k in range(SIZE):
        for i in range(k + 1, SIZE):
            x = own[i, k]
            for j in range(SIZE):
                block[i, j] -= x * block[k, j]


@inline_kernel
def _multiply_row(block: FloatArray, across: FloatArray, width: int, out: FloatArray) -> None:
    """Fill out (SIZE, width) with a block (SIZE, SIZE) times so many columns of (SIZE, ...)."""
    r0, r1, r2, r3, r4, r5 = across[0], across[1], across[2], across[3], across[4], across[5]
    for i in range(SIZE):
        a, b, c, x, y, z = block[i, 0], block[i, 1], block[i, 2], block[i, 3], block[i, 4], block[i, 5]
        row = out[i]
        for j in range(width):
            row[j] = (a * r0[j] + b * r1[j] + c * r2[j]) + (x * r3[j] + y * r4[j] + z * r5[j])


@kernel
def factorise_blocks(elimination: Elimination, blocks: FloatArray, pivots: IntArray) -> float:
    """Factorise blocks (t, SIZE, SIZE) in place; return the sign of the determinant, zero where none is.

    Fill (SIZE * B,) the rows that are exchanged within the diagonal's.
    """
    starts, _, first, targets = elimination
    n, sign = starts.size - 1, 1.0
    # the blocks of a row side by side: loops as long as it take three quarters of the time of blocks' loops
    across = np.empty((SIZE, SIZE * n))
    products = np.empty_like(across)
    for k in range(n):
        own = blocks[k]
        sign *= _factorise_one(own, pivots[SIZE * k : SIZE * k + SIZE])
        if sign == 0.0:
            return 0.0
        low, high = starts[k], starts[k + 1]
        for e in range(low, high):
            _divide_upper(own, blocks[n + 2 * e])
            _divide_lower(own, pivots[SIZE * k : SIZE * k + SIZE], blocks[n + 2 * e + 1])
        for e in range(low, high):
            for i in range(SIZE):
                for j in range(SIZE):
                    across[i, SIZE * (e - low) + j] = blocks[n + 2 * e + 1, i, j]
        at = first[k]
        for d in range(low, high):
            _multiply_row(blocks[n + 2 * d], across, SIZE * (high - low), products)
            for e in range(high - low):
                out = blocks[targets[at]]
                at += 1
                for i in range(SIZE):
                    for j in range(SIZE):
                        out[i, j] -= products[i, SIZE * e + j]
    return sign


@inline_kernel
def _subtract(block: FloatArray, right: FloatArray, start: int, end: int) -> None:
    """Subtract a block (SIZE, SIZE) times the rows from `start` on of (SIZE * B,) from those of `end` on."""
    a, b, c = right[start], right[start + 1], right[start + 2]
    x, y, z = right[start + 3], right[start + 4], right[start + 5]
    for i in range(SIZE):
        left = block[i, 0] * a + block[i, 1] * b + block[i, 2] * c
        right[end + i] -= left + (block[i, 3] * x + block[i, 4] * y + block[i, 5] * z)


@inline_kernel
def solve_blocks(
    starts: IntArray, below: IntArray, blocks: FloatArray, pivots: IntArray, right: FloatArray
) -> None:
    """Solve in place for a right-hand side (SIZE * B,) with the factors of `factorise_blocks`."""
    n = starts.size - 1
    for k in range(n):
        own, at = blocks[k], SIZE * k
        for i in range(SIZE):
            other = at + pivots[at + i]
            right[at + i], right[other] = right[other], right[at + i]
        for i in range(SIZE):
            x = right[at + i]
            for j in range(i):
                x -= own[i, j] * right[at + j]
            right[at + i] = x
        for e in range(starts[k], starts[k + 1]):
            _subtract(blocks[n + 2 * e], right, at, SIZE * below[e])
    for k in range(n - 1, -1, -1):
        own, at = blocks[k], SIZE * k
        for e in range(starts[k], starts[k + 1]):
            _subtract(blocks[n + 2 * e + 1], right, SIZE * below[e], at)
        for i in range(SIZE - 1, -1, -1):
            x = right[at + i]
            for j in range(i + 1, SIZE):
                x -= own[i, j] * right[at + j]
            right[at + i] = x / own[i, i]


@kernel
def fill_blocks(
    values: FloatArray, places: IntArray, weights: FloatArray, count: int, blocks: FloatArray
) -> None:
    """Fill the blocks (t, SIZE, SIZE) of I + Yᵀ P S⁻¹ Y, the first `count` of them the diagonal's.

    Parameters
    ----------
    values
        (3n, w) rows of Y, on the blocks that each contact moves.
    places
        (n, b, b) of the products of these blocks; -1 for none.
    weights
        P S⁻¹ (n, 3, 3).
    """
    blocks[:] = 0.0
    for k in range(count):
        for i in range(SIZE):
            blocks[k, i, i] = 1.0
    own = np.empty((3, SIZE))
    for k in range(len(weights)):
        W = weights[k]
        one, two, three = values[3 * k], values[3 * k + 1], values[3 * k + 2]
        for q in range(places.shape[1]):
            if places[k, q, q] < 0:
                continue
            for j in range(SIZE):
                x, y, z = one[SIZE * q + j], two[SIZE * q + j], three[SIZE * q + j]
                for a in range(3):
                    own[a, j] = W[a, 0] * x + W[a, 1] * y + W[a, 2] * z
            for p in range(places.shape[1]):
                if places[k, p, q] < 0:
                    continue
                out = blocks[places[k, p, q]]
                for i in range(SIZE):
                    x, y, z = one[SIZE * p + i], two[SIZE * p + i], three[SIZE * p + i]
                    for j in range(SIZE):
                        out[i, j] += x * own[0, j] + y * own[1, j] + z * own[2, j]
