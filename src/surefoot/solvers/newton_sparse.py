"""The Newton step of `newton` for many contacts: a sparse reduced matrix, factorised by SuperLU or LAPACK."""

from __future__ import annotations

import time

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.blocks import Blocks, block_product
from surefoot.contact.problem import ContactProblem
from surefoot.kernels import kernel
from surefoot.solvers.natural_map import natural_gap, relative_gap
from surefoot.solvers.newton import (
    PATIENCE,
    PROXIMAL,
    PROXIMAL_FAR,
    classify,
    spread,
)

DENSE_ABOVE = 0.12
"""Share of non-zeros of the reduced matrix above which it is factorised as a dense one."""


@kernel
def _reduced_entries(
    starts: IntArray, neighbours: IntArray, values: FloatArray, rows: FloatArray, columns: FloatArray,
    weight: FloatArray, count: IntArray, first: IntArray,
) -> tuple[IntArray, IntArray, FloatArray]:  # fmt: skip
    """Return the reduced matrix in compressed rows."""
    n = count.size
    total = 0
    for k in range(n):
        for at in range(starts[k], starts[k + 1]):
            total += count[k] * count[neighbours[at]]
    begin = np.zeros(first[n] + 1, dtype=np.int64)
    where = np.empty(total, dtype=np.int64)
    entries = np.empty(total)
    at_entry = 0
    for k in range(n):
        for c in range(count[k]):
            for at in range(starts[k], starts[k + 1]):
                j = neighbours[at]
                if count[j] == 0:
                    continue
                B = values[at]
                p = rows[k, c, 0] * B[0, 0] + rows[k, c, 1] * B[1, 0] + rows[k, c, 2] * B[2, 0]
                q = rows[k, c, 0] * B[0, 1] + rows[k, c, 1] * B[1, 1] + rows[k, c, 2] * B[2, 1]
                r = rows[k, c, 0] * B[0, 2] + rows[k, c, 1] * B[1, 2] + rows[k, c, 2] * B[2, 2]
                for d in range(count[j]):
                    value = p * columns[j, d, 0] + q * columns[j, d, 1] + r * columns[j, d, 2]
                    if j == k and d == c:
                        value += weight[k, c]
                    where[at_entry] = first[j] + d
                    entries[at_entry] = value
                    at_entry += 1
            begin[first[k] + c + 1] = at_entry
    return begin, where, entries


@kernel
def _right_hand_side(
    moved: FloatArray, rows: FloatArray, target: FloatArray, count: IntArray, first: IntArray
) -> FloatArray:
    b = np.empty(first[count.size])
    for k in range(count.size):
        for c in range(count[k]):
            total = target[k, c]
            for a in range(3):
                total -= rows[k, c, a] * moved[3 * k + a]
            b[first[k] + c] = total
    return b


def _solve(begin: IntArray, where: IntArray, entries: FloatArray, b: FloatArray) -> FloatArray | None:
    """Solve the reduced system; None if it is singular."""
    m = b.size
    if m == 0:
        return b
    A = sp.csr_matrix((entries, where, begin), shape=(m, m))
    try:
        if m < 150 or entries.size > DENSE_ABOVE * m * m:
            lu, pivots, info = scipy.linalg.lapack.dgetrf(A.toarray(order="F"), overwrite_a=True)
            if info != 0:
                return None
            x: FloatArray = scipy.linalg.lapack.dgetrs(lu, pivots, b)[0]
        else:
            x = scipy.sparse.linalg.splu(A.tocsc()).solve(b)
    except RuntimeError:  # SuperLU's word for a singular matrix
        return None
    return x if np.isfinite(x).all() else None


def newton_sparse(
    problem: ContactProblem,
    blocks: Blocks,
    local: FloatArray,
    tol: float,
    limit: int,
    share: float,
    end: float,
    forces: FloatArray,
) -> tuple[int, float]:
    """Take Newton steps from flat forces, updated in place and never worse; return steps and relative gap."""
    n = problem.contacts
    matrix = blocks.starts, blocks.columns, blocks.values
    convex = problem.law == "convex"
    scale = 1.0 / problem.norm if problem.norm > 0.0 else 1.0
    laws = problem.mu, problem.normal_min, problem.normal_max
    free = scale * float(np.linalg.norm(problem.g))
    rows, columns = np.empty((n, 3, 3)), np.empty((n, 3, 3))
    weight, jump, target = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    step, count = np.empty(3 * n), np.empty(n, dtype=np.int64)

    def measure(f: FloatArray) -> tuple[FloatArray, float]:
        velocities = block_product(*matrix, f) + problem.g
        gap, size = natural_gap(f, velocities, *laws, scale, convex)
        return velocities, float(relative_gap(gap, size, free))

    current = forces.copy()
    velocities, relative = measure(current)
    best, done, since = relative, 0, 0
    while done < limit and best > tol and since < PATIENCE and time.perf_counter() < end:
        done += 1
        since += 1
        classify(
            current, velocities, local, *laws, convex, rows, columns, weight, jump, target,
            max(PROXIMAL, min(PROXIMAL_FAR, share * relative)), count,
        )  # fmt: skip
        first = np.concatenate([[0], np.cumsum(count)])
        moved = velocities + block_product(*matrix, jump.ravel())
        reduced = _reduced_entries(*matrix, rows, columns, weight, count, first)
        unknowns = _solve(*reduced, _right_hand_side(moved, rows, target, count, first))
        if unknowns is None:
            break
        spread(columns, jump, count, unknowns, step)
        current = current + step
        velocities, relative = measure(current)
        if relative < best:
            since = 0 if relative < 0.9 * best else since
            best = relative
            forces[:] = current
    return done, best
