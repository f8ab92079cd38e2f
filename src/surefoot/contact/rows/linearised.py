"""One connected part's rows linearised: velocities, impulses, the dynamics' residual and Newton's matrix."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.base.numerics.lu_factors import apply_lu
from surefoot.contact.rows.blocks import (
    DIM,
    DRY_ROW,
    FIRST,
    HELD_ROW,
    HIGH,
    KIND,
    LIMIT,
    LOW,
    MU,
    OPEN,
    SLIDE,
    SOFT_ROWS,
    STICK,
    STIFF,
    STIFF_T,
    WEIGHT,
    WIDEST,
    block_error,
    project,
    slope,
)


@inline_kernel
def fill_velocities(
    J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray, v: FloatArray, u: FloatArray
) -> None:
    """Fill u = J v + b, over the columns that a block moves; see `find_columns`.

    Three rows at once: one sum would wait for each addition.
    """
    for k in range(table.shape[0]):
        few, i, end = columns[k, 0], table[k, FIRST], table[k, FIRST] + table[k, DIM]
        while i + 2 < end:
            first, second, third = b[i], b[i + 1], b[i + 2]
            for c in range(1, few + 1):
                j = columns[k, c]
                first += J[i, j] * v[j]
                second += J[i + 1, j] * v[j]
                third += J[i + 2, j] * v[j]
            u[i], u[i + 1], u[i + 2] = first, second, third
            i += 3
        while i < end:
            total = b[i]
            for c in range(1, few + 1):
                total += J[i, columns[k, c]] * v[columns[k, c]]
            u[i] = total
            i += 1


@inline_kernel
def fill_residual(
    M: FloatArray, free: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, v: FloatArray,
    p: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill the dynamics' residual (n,) M (v - v_free) - Jᵀ p."""
    n = v.size
    for i in range(n):
        out[i] = 0.0
    for j in range(n):  # column by column: sums along rows would wait for each addition
        change = v[j] - free[j]
        if change != 0.0:
            for i in range(n):
                out[i] += M[i, j] * change
    for k in range(table.shape[0]):
        for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
            if p[i] != 0.0:
                for c in range(1, columns[k, 0] + 1):
                    out[columns[k, c]] -= J[i, columns[k, c]] * p[i]


@inline_kernel
def add_block(
    J: FloatArray, columns: IntArray, k: int, first: int, dim: int, D: FloatArray, stuck: bool, H: FloatArray,
    rooms: FloatArray,
) -> None:  # fmt: skip
    """Add J_kᵀ D J_k to H (n, n), over the columns that the block moves; of one that is stuck D is diagonal.

    The rows are gathered first, and a row of the product is added at once: H's own columns are apart.
    """
    few = columns[k, 0]
    own, moved, line = rooms[:WIDEST], rooms[WIDEST : 2 * WIDEST], rooms[2 * WIDEST]
    for a in range(dim):
        for c in range(few):
            own[a, c] = J[first + a, columns[k, c + 1]]
    for a in range(dim):
        for c in range(few):
            moved[a, c] = D[a, a] * own[a, c]
        if not stuck:
            for b in range(dim):
                if b != a and D[a, b] != 0.0:
                    for c in range(few):
                        moved[a, c] += D[a, b] * own[b, c]
    for d in range(few):
        if dim == 3:  # nearly all blocks: one loop for three
            for c in range(few):
                line[c] = own[0, d] * moved[0, c] + own[1, d] * moved[1, c] + own[2, d] * moved[2, c]
        else:
            for c in range(few):
                line[c] = own[0, d] * moved[0, c]
            for a in range(1, dim):
                for c in range(few):
                    line[c] += own[a, d] * moved[a, c]
        row = columns[k, d + 1]
        for c in range(few):
            H[row, columns[k, c + 1]] += line[c]


@inline_kernel
def evaluate_blocks(
    table: IntArray, numbers: FloatArray, share: float, x: FloatArray, u: FloatArray, p: FloatArray,
    modes: IntArray,
) -> bool:  # fmt: skip
    """Fill impulses p (m,) and modes (k,) of all blocks; return whether the modes are as they were."""
    same = True
    for k in range(table.shape[0]):
        mode = project(
            table[k, KIND], table[k, DIM], numbers[k, MU], numbers[k, LIMIT], share * numbers[k, STIFF],
            share * numbers[k, STIFF_T], x, u, table[k, FIRST], p,
        )  # fmt: skip
        same = same and mode == modes[k]
        modes[k] = mode
    return same


@inline_kernel
def follow_modes(
    table: IntArray, numbers: FloatArray, share: float, x: FloatArray, u: FloatArray, p: FloatArray,
    modes: IntArray,
) -> None:  # fmt: skip
    """Fill impulses p (m,) as if the blocks kept their modes: what sticks carries whatever it takes."""
    for k in range(table.shape[0]):
        at, end = table[k, FIRST], table[k, FIRST] + table[k, DIM]
        if modes[k] == STICK and table[k, KIND] != SOFT_ROWS:
            p[at] = x[at] - share * numbers[k, STIFF] * u[at]
            for i in range(at + 1, end):
                p[i] = x[i] - share * numbers[k, STIFF_T] * u[i]
        elif modes[k] == OPEN:
            for i in range(at, end):
                p[i] = 0.0


@inline_kernel
def worst_error(table: IntArray, numbers: FloatArray, x: FloatArray, u: FloatArray) -> float:
    """Return the largest velocity error of the blocks for x, u (m,) [m/s]; infinite for what is no number."""
    worst = total = 0.0
    for k in range(table.shape[0]):
        error = block_error(
            table[k, KIND], table[k, DIM], numbers[k, MU], numbers[k, LIMIT], numbers[k, WEIGHT], x, u,
            table[k, FIRST],
        )  # fmt: skip
        worst, total = max(worst, error), total + error
    return worst if total >= 0.0 else np.inf


@inline_kernel
def free_speed(table: IntArray, k: int, u: FloatArray) -> float:
    """Return how fast a block's rows of u (m,) move that it has to stop [m/s]; 0 for what does not close."""
    at, kind = table[k, FIRST], table[k, KIND]
    if kind in (HELD_ROW, DRY_ROW):
        return float(abs(u[at]))
    if not u[at] < 0.0 and kind != SOFT_ROWS:
        return 0.0
    square = 0.0
    for i in range(at, at + table[k, DIM]):
        square += u[i] * u[i]
    return math.sqrt(square)


@inline_kernel
def assemble_matrix(
    M: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, numbers: FloatArray, share: float,
    x: FloatArray, u: FloatArray, modes: IntArray, H: FloatArray, rooms: FloatArray,
) -> bool:  # fmt: skip
    """Fill H = M - Jᵀ ∂p/∂u J (n, n); return whether it is the same for all velocities of these modes."""
    D = np.empty((WIDEST, WIDEST))
    n, steady = M.shape[0], True
    for i in range(n):
        for j in range(n):
            H[i, j] = M[i, j]
    for k in range(table.shape[0]):
        if modes[k] in (OPEN, LOW, HIGH):
            continue
        slope(
            table[k, KIND], table[k, DIM], modes[k], numbers[k, MU], share * numbers[k, STIFF],
            share * numbers[k, STIFF_T], x, u, table[k, FIRST], D,
        )  # fmt: skip
        steady = steady and modes[k] != SLIDE
        stuck = modes[k] == STICK and table[k, KIND] != SOFT_ROWS
        add_block(J, columns, k, table[k, FIRST], table[k, DIM], D, stuck, H, rooms)
    return steady


@inline_kernel
def take_impulses(table: IntArray, source: FloatArray, x: FloatArray) -> None:
    """Copy the impulses (m,) of all blocks but soft ones, whose place in x holds their softness."""
    for k in range(table.shape[0]):
        if table[k, KIND] != SOFT_ROWS:
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                x[i] = source[i]


@inline_kernel
def fill_motion(
    J: FloatArray, columns: IntArray, table: IntArray, x: FloatArray, factors: FloatArray, order: IntArray,
    free: FloatArray, work: FloatArray, v: FloatArray,
) -> None:  # fmt: skip
    """Fill v = v_free + M⁻¹ Jᵀ λ (n,), of all blocks but soft ones, whose place in x (m,) has no impulses."""
    for i in range(v.size):
        work[i] = 0.0
    for k in range(table.shape[0]):
        if table[k, KIND] != SOFT_ROWS:
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                for c in range(1, columns[k, 0] + 1):
                    work[columns[k, c]] += J[i, columns[k, c]] * x[i]
    apply_lu(factors, order, work)
    for i in range(v.size):
        v[i] = free[i] + work[i]
