"""The constraint stage of a step, compiled: MuJoCo's rows in, exact impulses out, MuJoCo's arrays filled."""

from __future__ import annotations

import numba
import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import INTEGER, MATRIX, VECTOR, inline_kernel, kernel, window
from surefoot.base.numerics.lu_factors import apply_lu, factor_lu
from surefoot.base.numerics.tree_factor import factor_tree, solve_tree
from surefoot.contact import SOFT_ROWS, count_parts, fill_columns, fill_velocities, solve_rows
from surefoot.worlds.mujoco.stepper.row_weights import fill_weights
from surefoot.worlds.mujoco.stepper.rows import (
    CONTACTS,
    DIMENSION,
    ELLIPTIC,
    EQUALITY,
    FIRST_BYTE,
    FORCE,
    ID,
    PYRAMIDAL,
    SHARE,
    SOFTNESS,
    START,
    STEP,
    STRIDE,
    TOL,
    TYPE,
    dense_inertia,
    find_impulses,
    read_blocks,
    restore_margins,
    violation_rows,
)

QVEL, QFRC_SMOOTH, QACC_SMOOTH, QFRC_CONSTRAINT, QACC, MASS, ROWS, STARTS, COLUMNS, TREES = range(10)
"""Places of arrays: `addresses.OF_DATA`, filled by the stage, and those of the model, which do not move."""
STRUCT, NV, NC, NTREE = range(10, 14)
"""After them: mjData itself, and sizes."""
WORDS, HALVES, TABLE = numba.int64[::1], numba.int32[::1], numba.int64[:, ::1]
STAGE_TYPES = (
    VECTOR, WORDS, HALVES, WORDS, WORDS, WORDS, INTEGER, VECTOR, VECTOR, VECTOR, MATRIX,
    numba.types.Tuple((TABLE, TABLE, VECTOR)), VECTOR, VECTOR,
)  # fmt: skip
ERROR, SPEED, STEPS, BLOCKS, UNSOLVED, VIOLATION, PUSHED, LAST = range(8)
"""What the stage tells: velocity error over the speed, the speed [m/s], Newton steps, blocks, connected parts
that are not solved, the largest violation of a position [m, rad], and whether there is a push."""
FOREIGN = -2
"""Answer to rows that another model has made."""
SMALL = 1e-9
"""Violation that is left alone [m, rad]."""


@inline_kernel
def _add_solution(told: FloatArray, steps: int, error: float, speed: float, tol: float) -> None:
    """Add what a part's solution was."""
    told[STEPS] += steps
    told[ERROR], told[SPEED] = max(told[ERROR], error), max(told[SPEED], speed)
    told[UNSOLVED] += 0.0 if error <= tol else 1.0


@inline_kernel
def _solve_parts(
    M: FloatArray, free: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, part_of_tree: IntArray, tree_of: IntArray, parts: int, tol: float, x: FloatArray,
    told: FloatArray,
) -> None:  # fmt: skip
    """Solve every connected part: x (m,) impulses and free (nv,) velocities are replaced."""
    nv, count = free.size, table.shape[0]
    if parts == 1 and part_of_tree.min() == 0 and table[:, 3].min() == 0:  # all that moves: nothing to pick
        used, error, speed = solve_rows(M, free, J, b, columns, table, numbers, tol, x)
        _add_solution(told, used, error, speed, tol)
        return
    dofs, members = np.empty(nv, np.int64), np.empty(count, np.int64)
    for part in range(parts):
        n = few = rows = 0
        for j in range(nv):
            if part_of_tree[tree_of[j]] == part:
                dofs[n] = j
                n += 1
        for k in range(count):
            if table[k, 3] == part:
                members[few] = k
                few += 1
                rows += table[k, 1]
        own_M, own_J, v = np.empty((n, n)), np.empty((rows, n)), np.empty(n)
        own_table, own_numbers = np.empty((few, 4), np.int64), np.empty((few, 6))
        own_b, own_x, source = np.empty(rows), np.empty(rows), np.empty(rows, np.int64)
        for i in range(n):
            v[i] = free[dofs[i]]
            for j in range(n):
                own_M[i, j] = M[dofs[i], dofs[j]]
        at = 0
        for c in range(few):
            k = members[c]
            for a in range(4):
                own_table[c, a] = table[k, a]
            for a in range(6):
                own_numbers[c, a] = numbers[k, a]
            own_table[c, 2] = at
            for i in range(table[k, 2], table[k, 2] + table[k, 1]):
                own_b[at], own_x[at], source[at] = b[i], x[i], i
                for j in range(n):
                    own_J[at, j] = J[i, dofs[j]]
                at += 1
        own_columns = np.empty((few, n + 1), np.int64)
        fill_columns(own_J, own_table, own_columns)
        used, error, speed = solve_rows(
            own_M, v, own_J, own_b, own_columns, own_table, own_numbers, tol, own_x
        )
        _add_solution(told, used, error, speed, tol)
        for i in range(rows):
            x[source[i]] = own_x[i]
        for i in range(n):
            free[dofs[i]] = v[i]


@inline_kernel
def _push(
    floats: FloatArray, at: IntArray, settings: FloatArray, M: FloatArray, J: FloatArray, table: IntArray,
    blocks: int, u: FloatArray, numbers: FloatArray, part_of_tree: IntArray, tree_of: IntArray, parts: int,
    told: FloatArray, push: FloatArray,
) -> None:  # fmt: skip
    """Fill the velocity (nv,) that undoes the share of the violations; 0 for none."""
    m, nv = u.size, push.size
    for j in range(nv):
        push[j] = 0.0
    own, b, picked = np.empty((m, 4), np.int64), np.empty(m), np.empty(m, np.int64)
    count, worst = violation_rows(floats, at, settings, table, blocks, u, own, b, picked)
    told[VIOLATION], told[PUSHED] = worst, 0.0
    if not worst > SMALL or settings[SHARE] == 0.0:
        return
    rows, own_numbers = np.empty((count, nv)), np.zeros((count, 6))
    c = 0
    for k in range(blocks):
        if c < count and picked[c] == table[k, 2]:
            own[c, 3] = table[k, 3]
            own_numbers[c, 2], own_numbers[c, 3] = numbers[k, 2], numbers[k, 3]
            for j in range(nv):
                rows[c, j] = J[picked[c], j]
            c += 1
    x, unused, columns = np.zeros(count), np.zeros(6), np.empty((count, nv + 1), np.int64)
    fill_columns(rows, own[:count], columns)
    _solve_parts(
        M, push, rows, b[:count], columns, own[:count], own_numbers, part_of_tree, tree_of, parts,
        settings[TOL], x, unused,
    )  # fmt: skip
    for j in range(nv):
        if push[j] != 0.0:
            told[PUSHED] = 1.0


@inline_kernel
def find_places(words: IntArray, fixed: IntArray, arena: IntArray) -> IntArray:
    """Return where the arena's arrays begin now (11,), in entries of their kinds; fill the data's in `fixed`.

    All are looked up anew in every step: a data that was made again, copied into or grown has others.
    """
    at = np.empty(CONTACTS + 1, np.int64)
    for a in range(at.size):
        size = 4 if a in (TYPE, ID) else 8
        at[a] = (words[fixed[STRUCT] + arena[a]] - FIRST_BYTE) // size
    for a in range(arena.size - at.size):
        fixed[a] = (words[fixed[STRUCT] + arena[at.size + a]] - FIRST_BYTE) // 8
    return at


@inline_kernel
def _hers(floats: FloatArray, halves: IntArray, at: IntArray, layout: IntArray, count: int) -> bool:
    """Return whether `count` rows are as the stepper's model makes them: no pyramids, contacts whole."""
    i = 0
    while i < count:
        kind, dim = halves[at[TYPE] + i], 1
        if kind < EQUALITY or kind > ELLIPTIC or kind == PYRAMIDAL:
            return False
        if kind == ELLIPTIC:
            base = 8 * at[CONTACTS] + layout[STRIDE] * halves[at[ID] + i]
            dim = halves[(base + layout[DIMENSION]) // 4]
            if dim < 3 or i + dim > count:
                return False
        i += dim
    return True


@inline_kernel
def _remember(
    memory: tuple[IntArray, IntArray, FloatArray], keys: IntArray, table: IntArray, x: FloatArray
) -> None:
    """Keep the impulses for the next step, with what they are of."""
    for k in range(table.shape[0]):
        memory[1][k, 0], memory[1][k, 1] = table[k, 2], table[k, 1]
        for a in range(3):
            memory[0][k, a] = keys[k, a]
    for i in range(x.size):
        memory[2][i] = x[i]


@inline_kernel
def _take_softness(floats: FloatArray, place: int, table: IntArray, scale: FloatArray, x: FloatArray) -> None:
    """Fill the places of soft blocks in x (m,) with their softness."""
    for k in range(table.shape[0]):
        if table[k, 0] == SOFT_ROWS:
            for i in range(table[k, 2], table[k, 2] + table[k, 1]):
                x[i] = floats[place + i] * scale[i] * scale[i]


@kernel
def exact_stage(
    floats: FloatArray, words: IntArray, halves: IntArray, fixed: IntArray, arena: IntArray,
    layout: IntArray, count: int, settings: FloatArray, soft: FloatArray, damping: FloatArray,
    dense: FloatArray, memory: tuple[IntArray, IntArray, FloatArray], told: FloatArray, push: FloatArray,
) -> int:  # fmt: skip
    """Fill MuJoCo's constraint forces, accelerations and the push; return the connected parts not solved.

    -1 is an inertia without factors, `FOREIGN` rows that the stepper's model has not made.

    Parameters
    ----------
    floats, words, halves
        All memory, see `addresses`.
    fixed, arena, layout
        Places of arrays that stay, words of those that move, and places within a contact.
    count
        Number of rows.
    settings, soft
        See `rows`.
    damping
        (nv,) what Euler's method takes implicitly [N s/m, N m s/rad], or none.
    dense
        (nv, nv) inertia of the implicit integrators, or none.
    memory
        Keys, places and impulses of the last step's blocks; `told` keeps their number.
    told
        (8,) what the stage tells, see `ERROR`; the last is the number of blocks in the memory.
    push
        (nv,) velocity of the positions alone [m/s, rad/s].
    """
    nv, h = int(fixed[NV]), settings[STEP]
    at = find_places(words, fixed, arena)
    if not _hers(floats, halves, at, layout, count):
        return FOREIGN
    qvel = window(floats, fixed[QVEL], 1, nv)[0]
    rows, starts, tree_of = np.empty(nv, np.int64), np.empty(nv, np.int64), np.empty(nv, np.int64)
    for i in range(nv):
        rows[i], starts[i] = halves[fixed[ROWS] + i], halves[fixed[STARTS] + i]
        tree_of[i] = halves[fixed[TREES] + i]
    size = int(fixed[NC])
    columns, factors = np.empty(size, np.int64), np.empty(size)
    mass = window(floats, fixed[MASS], 1, size)[0]
    for a in range(size):
        columns[a], factors[a] = halves[fixed[COLUMNS] + a], mass[a]
    J, vectors, reached = np.zeros((count, nv)), np.empty((4, count)), np.empty((count, nv + 1), np.int64)
    b, scale, x, u = vectors[0], vectors[1], vectors[2], vectors[3]
    keys, table = np.empty((count, 3), np.int64), np.empty((count, 4), np.int64)
    numbers = np.zeros((count, 6))
    restore_margins(floats, halves, at, layout, count, settings, soft)
    blocks = read_blocks(
        floats, halves, at, layout, count, settings, soft, qvel, (J, b, scale), keys,
        (reached, table, numbers),
    )  # fmt: skip
    reached, table, numbers = reached[:blocks], table[:blocks], numbers[:blocks]
    find_impulses(keys, table, blocks, memory[0], memory[2], memory[1], int(told[LAST]), x)
    _take_softness(floats, at[SOFTNESS], table, scale, x)
    if not factor_tree(factors, rows, starts, columns):
        return -1
    fill_weights(J, reached, table, numbers, factors, rows, starts, columns)
    for a in range(6):
        told[a] = 0.0
    told[BLOCKS] = blocks
    trees = np.empty(int(fixed[NTREE]), np.int64)
    parts = count_parts(table, trees, reached, tree_of)
    M, v = np.empty((nv, nv)), np.empty(nv)
    start = window(floats, fixed[QVEL] if settings[START] == 0.0 else int(settings[START]), 1, nv)[0]
    _free_motion(floats, fixed, mass, rows, starts, columns, damping, dense, h, start, M, v)
    _solve_parts(M, v, J, b, reached, table, numbers, trees, tree_of, parts, settings[TOL], x, told)
    if parts == 0:
        for i in range(count):
            x[i] = 0.0
    fill_velocities(J, np.zeros(count), reached, table, v, u)
    _push(floats, at, settings, M, J, table, blocks, u, numbers, trees, tree_of, parts, told, push)
    _write_back(floats, fixed, at, x, J, scale, h, rows, starts, columns, factors)
    _remember(memory, keys, table, x)
    told[LAST] = blocks
    return int(told[UNSOLVED])


@inline_kernel
def _free_motion(
    floats: FloatArray, fixed: IntArray, mass: FloatArray, rows: IntArray, starts: IntArray,
    columns: IntArray, damping: FloatArray, dense: FloatArray, h: float, qvel: FloatArray, M: FloatArray,
    v: FloatArray,
) -> None:  # fmt: skip
    """Fill the inertia of the integrator, and the velocities without impulses."""
    n, damped = v.size, False
    for i in range(damping.size):
        damped = damped or damping[i] != 0.0
    if dense.shape[0] > 0:
        for i in range(n):
            for j in range(n):
                M[i, j] = dense[i, j]
    else:
        dense_inertia(mass, rows, starts, columns, damping, h, M)
    if dense.shape[0] == 0 and not damped:
        for i in range(n):
            v[i] = qvel[i] + h * floats[fixed[QACC_SMOOTH] + i]
        return
    for i in range(n):
        v[i] = h * floats[fixed[QFRC_SMOOTH] + i]
    if dense.shape[0] > 0:
        order, whole = np.empty((3, n), np.int64), M.copy()
        if factor_lu(whole, order):
            apply_lu(whole, order, v)
    else:
        factors = mass.copy()
        for i in range(n):
            factors[starts[i] + rows[i] - 1] += h * damping[i]
        factor_tree(factors, rows, starts, columns)
        solve_tree(factors, rows, starts, columns, v)
    for i in range(n):
        v[i] += qvel[i]


@inline_kernel
def _write_back(
    floats: FloatArray, fixed: IntArray, at: IntArray, x: FloatArray, J: FloatArray, scale: FloatArray,
    h: float, rows: IntArray, starts: IntArray, columns: IntArray, factors: FloatArray,
) -> None:  # fmt: skip
    """Fill efc_force, qfrc_constraint and qacc = qacc_smooth + M⁻¹ qfrc_constraint."""
    n = rows.size
    force = np.zeros(n)
    for i in range(x.size):
        floats[at[FORCE] + i] = scale[i] * x[i] / h
        if x[i] != 0.0:
            for j in range(n):
                force[j] += J[i, j] * x[i]
    for j in range(n):
        force[j] /= h
        floats[fixed[QFRC_CONSTRAINT] + j] = force[j]
    solve_tree(factors, rows, starts, columns, force)
    for j in range(n):
        floats[fixed[QACC] + j] = floats[fixed[QACC_SMOOTH] + j] + force[j]
