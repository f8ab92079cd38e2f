"""Gauss-Seidel over the blocks of one connected part: a start for Newton's method where its own miss.

Block after block is solved exactly, the others held: a contact that catches (sliding, its friction would
drive it into the ground; sticking, it holds) is found at once, which Newton's steps between sliding and open
are not led to. What sweeps reach slowly, the right digits, Newton's method has at once from there.

Source: M. Jean, "The non-smooth contact dynamics method", CMAME 177, 1999.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.lu_factors import apply_lu, factor_lu
from surefoot.contact.rows.blocks import CONE_ROWS, DIM, DRY_ROW, FIRST, HELD_ROW, KIND, LIMIT, MU, SOFT_ROWS
from surefoot.contact.solvers.one_contact import WIDTH, block_of, prepare, solve_one

TURNS = 8
"""Projections in which a contact with spin or rolling friction is solved, the others held."""


@inline_kernel
def _solve_row(kind: int, limit: float, w: float, u: float, x: float) -> float:
    """Return the impulse of a block of one row, which has the velocity u with the impulse x."""
    point = x - u / w if w > 0.0 else x
    if kind == HELD_ROW:
        return point
    return min(max(point, -limit), limit) if kind == DRY_ROW else max(point, 0.0)


@inline_kernel
def _project_wide(
    G: FloatArray, dim: int, mu: float, x: FloatArray, u: FloatArray, out: FloatArray
) -> None:  # fmt: skip
    """Fill the impulse (dim,) of a contact of any number of rows, by projections of Alart and Curnier's.

    G (dim, dim) is its own block; x, u (dim,) impulse and velocity as they are.
    """
    trace = first = 0.0
    for a in range(dim):
        out[a], trace = x[a], trace + G[a, a]
        first = max(first, G[a, a])
    if not trace > 0.0:
        return
    for _ in range(TURNS):
        square = 0.0
        for a in range(dim):
            speed = u[a]
            for c in range(dim):
                speed += G[a, c] * (out[c] - x[c])
            out[a] -= speed / (G[0, 0] if a == 0 and G[0, 0] > 0.0 else trace)
            square += out[a] * out[a] if a else 0.0
        out[0] = max(out[0], 0.0)
        length = math.sqrt(square)
        if length > mu * out[0]:
            for a in range(1, dim):
                out[a] *= mu * out[0] / length


@inline_kernel
def _solve_cone(local: FloatArray, k: int, mu: float, x: FloatArray, u: FloatArray, out: FloatArray) -> None:
    """Fill the impulse (3,) of a point contact, exactly; rows normal first."""
    W = block_of(local, k)
    q0 = u[1] - (W[0] * x[1] + W[1] * x[2] + W[2] * x[0])
    q1 = u[2] - (W[1] * x[1] + W[3] * x[2] + W[4] * x[0])
    q2 = u[0] - (W[2] * x[1] + W[4] * x[2] + W[5] * x[0])
    out[1], out[2], out[0], local[k, 12], local[k, 13] = solve_one(
        W, q0, q1, q2, mu, 0.0, math.inf, False, x[1], x[2], local[k, 12], local[k, 13]
    )


@inline_kernel
def _fill_local(J: FloatArray, Y: FloatArray, table: IntArray, own: FloatArray, local: FloatArray) -> None:
    """Fill the block of G = J M⁻¹ Jᵀ of each block, and what `solve_one` needs of point contacts."""
    for k in range(table.shape[0]):
        at, dim = table[k, FIRST], table[k, DIM]
        for a in range(dim):
            for c in range(dim):
                total = 0.0
                for j in range(J.shape[1]):
                    total += 0.5 * (J[at + a, j] * Y[at + c, j] + J[at + c, j] * Y[at + a, j])
                own[k, a, c] = total
        if table[k, KIND] == CONE_ROWS and dim == 3:
            G = own[k]
            prepare(G[1, 1], G[1, 2], G[1, 0], G[2, 2], G[2, 0], G[0, 0], local, k)


@kernel
def sweep_part(
    M: FloatArray, free: FloatArray, J: FloatArray, b: FloatArray, table: IntArray, numbers: FloatArray,
    sweeps: int, x: FloatArray,
) -> None:  # fmt: skip
    """Run so many times over all blocks from impulses x (m,), which are replaced; see `solve_part`.

    Soft blocks are left out.
    """
    n, m, count = free.size, b.size, table.shape[0]
    factors, order = M.copy(), np.empty((3, n), np.int64)
    if not factor_lu(factors, order):
        return
    Y, v = J.copy(), free.copy()
    own, local = np.zeros((count, 6, 6)), np.zeros((count, WIDTH))
    for i in range(m):
        apply_lu(factors, order, Y[i])
    _fill_local(J, Y, table, own, local)
    for k in range(count):
        for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
            if table[k, KIND] != SOFT_ROWS:
                for j in range(n):
                    v[j] += Y[i, j] * x[i]
    u, fresh = np.zeros(6), np.zeros(6)
    for _ in range(sweeps):
        for k in range(count):
            kind, dim, at = table[k, KIND], table[k, DIM], table[k, FIRST]
            if kind == SOFT_ROWS:
                continue
            for a in range(dim):
                u[a] = b[at + a]
                for j in range(n):
                    u[a] += J[at + a, j] * v[j]
            if dim == 1:
                fresh[0] = _solve_row(kind, numbers[k, LIMIT], own[k, 0, 0], u[0], x[at])
            elif dim == 3:
                _solve_cone(local, k, numbers[k, MU], x[at : at + 3], u, fresh)
            else:
                _project_wide(own[k], dim, numbers[k, MU], x[at : at + dim], u, fresh)
            for a in range(dim):
                change = fresh[a] - x[at + a]
                x[at + a] = fresh[a]
                for j in range(n):
                    v[j] += Y[at + a, j] * change
