"""MuJoCo's constraints of an instant as blocks of rows, and what was solved as MuJoCo's own arrays."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, window
from surefoot.contact import (
    CONE_ROWS,
    DRY_ROW,
    HELD_ROW,
    SOFT_ROWS,
    STOP_ROW,
    find_columns,
)

EQUALITY, FRICTION_DOF, FRICTION_TENDON, LIMIT_JOINT, LIMIT_TENDON, FRICTIONLESS, PYRAMIDAL, ELLIPTIC = range(
    8
)
"""MuJoCo's mjtConstraint."""
JACOBIAN, TYPE, ID, POS, MARGIN, DRY_LIMIT, VELOCITY, REFERENCE, SOFTNESS, FORCE, CONTACTS = range(11)
"""Places of the arrays of `addresses.ARENA`."""
STRIDE, DIST, INCLUDED, FRICTION, DIMENSION, GEOMS, EXCLUDE, ROW = range(8)
"""Places of `addresses.contact_places`."""
STEP, SHARE, TOL, REACH, BOUNCE, SLOWEST, LIMIT_REACH, START = range(8)
"""Settings: h [s], share of a violation undone, tolerance, reach of contacts, restitution, least speed of a
bounce, reach of limits, and the place of the velocity that the step starts from (0: the data's own)."""
FIRST_BYTE = 8
"""See `addresses`."""


@inline_kernel
def read_blocks(
    floats: FloatArray, halves: IntArray, at: IntArray, layout: IntArray, count: int, settings: FloatArray,
    soft: FloatArray, qvel: FloatArray, rows: tuple[FloatArray, FloatArray, FloatArray], keys: IntArray,
    blocks: tuple[IntArray, IntArray, FloatArray],
) -> int:  # fmt: skip
    """Fill the blocks of `count` rows; return how many there are.

    Parameters
    ----------
    floats, halves
        All memory; `at` are the places of the arena's arrays there, `layout` those within a contact.
    settings, soft
        See above; (ngeom,) 1 for geoms whose contacts stay soft.
    qvel
        (nv,) velocities.
    rows
        Filled: J (count, nv) the Jacobian, zeros before, with friction rows scaled, b (count,) what closes or
        moves beside it [m/s], and the scale of each row; of soft blocks b leads to MuJoCo's own law.
    keys
        Filled: (count, 3) what each block is of.
    blocks
        Filled: columns (count, nv + 1), table (count, 4) and numbers (count, 6), see
        `surefoot.contact.rows.blocks`.
    """
    J, b, scale = rows
    columns, table, numbers = blocks
    h, i, k = settings[STEP], 0, 0
    source = window(floats, at[JACOBIAN], count, qvel.size)
    while i < count:
        kind, number = halves[at[TYPE] + i], halves[at[ID] + i]
        dim, mu, limit, row_kind = 1, 0.0, 0.0, STOP_ROW
        gap = floats[at[POS] + i] - floats[at[MARGIN] + i]
        keys[k, 0], keys[k, 1], keys[k, 2] = kind, number, 0
        base = 0
        if kind == EQUALITY:
            row_kind = HELD_ROW
        elif kind in (FRICTION_DOF, FRICTION_TENDON):
            row_kind, limit = DRY_ROW, h * floats[at[DRY_LIMIT] + i]
        elif kind >= FRICTIONLESS:
            base = 8 * at[CONTACTS] + layout[STRIDE] * number
            geoms = (base + layout[GEOMS]) // 4
            keys[k, 1], keys[k, 2] = halves[geoms], halves[geoms + 1]
            if kind == ELLIPTIC:
                dim = halves[(base + layout[DIMENSION]) // 4]
                row_kind, mu = CONE_ROWS, floats[(base + layout[FRICTION]) // 8]
            if soft.size and (soft[keys[k, 1]] != 0.0 or soft[keys[k, 2]] != 0.0):
                row_kind = SOFT_ROWS
        find_columns(source, i, dim, columns[k])
        for a in range(dim):
            share = 1.0
            if a > 0:
                # ||(f_j / mu_j)|| <= f_n is a round cone of the rows mu_j / mu_1 J_j
                share = floats[(base + layout[FRICTION]) // 8 + a - 1] / mu
            scale[i + a] = share
            moved = 0.0
            for c in range(1, columns[k, 0] + 1):
                j = columns[k, c]
                moved += source[i + a, j] * qvel[j]
                J[i + a, j] = share * source[i + a, j]
            if row_kind == SOFT_ROWS:
                b[i + a] = -share * (moved + h * floats[at[REFERENCE] + i + a])
            else:
                # what a surface's own motion adds
                b[i + a] = share * (floats[at[VELOCITY] + i + a] - moved)
        if row_kind in (STOP_ROW, CONE_ROWS):
            speed = floats[at[VELOCITY] + i]
            if settings[BOUNCE] > 0.0 and speed < -settings[SLOWEST] and gap + h * speed <= 0.0:
                b[i] += settings[BOUNCE] * speed
            else:
                b[i] += max(gap, 0.0) / h
        table[k, 0], table[k, 1], table[k, 2] = row_kind, dim, i
        numbers[k, 0], numbers[k, 1] = mu, limit
        i, k = i + dim, k + 1
    return k


@inline_kernel
def restore_margins(
    floats: FloatArray, halves: IntArray, at: IntArray, layout: IntArray, count: int, settings: FloatArray,
    soft: FloatArray,
) -> None:  # fmt: skip
    """Take the reach out of the margins of `count` rows (count,) again: users see those of their model."""
    for i in range(count):
        kind, number = halves[at[TYPE] + i], halves[at[ID] + i]
        if kind in (LIMIT_JOINT, LIMIT_TENDON):
            floats[at[MARGIN] + i] -= settings[LIMIT_REACH]
        elif kind >= FRICTIONLESS:
            base = 8 * at[CONTACTS] + layout[STRIDE] * number
            geoms = (base + layout[GEOMS]) // 4
            if soft.size and (soft[halves[geoms]] != 0.0 or soft[halves[geoms + 1]] != 0.0):
                continue
            if halves[(base + layout[ROW]) // 4] == i:
                floats[at[MARGIN] + i] -= settings[REACH]
                floats[(base + layout[INCLUDED]) // 8] -= settings[REACH]


@inline_kernel
def find_impulses(
    keys: IntArray, table: IntArray, blocks: int, old_keys: IntArray, old: FloatArray, old_first: IntArray,
    old_blocks: int, x: FloatArray,
) -> None:  # fmt: skip
    """Fill x (m,) with the last step's impulses of blocks of the same kind, object and order; else zero."""
    last = 0
    for k in range(blocks):
        at, dim = table[k, 2], table[k, 1]
        for a in range(dim):
            x[at + a] = 0.0
        # contacts keep their order mostly: the search goes on from the last one found
        for turn in range(old_blocks):
            m = (last + turn) % old_blocks
            same = (
                keys[k, 0] == old_keys[m, 0] and keys[k, 1] == old_keys[m, 1] and keys[k, 2] == old_keys[m, 2]
            )
            if same and old_first[m, 1] == dim:
                for a in range(dim):
                    x[at + a] = old[old_first[m, 0] + a]
                last = m + 1
                break


@inline_kernel
def violation_rows(
    floats: FloatArray, at: IntArray, settings: FloatArray, table: IntArray, blocks: int, u: FloatArray,
    push_table: IntArray, push_b: FloatArray, picked: IntArray,
) -> tuple[int, float]:  # fmt: skip
    """Fill the normal rows (n,) of the position's own problem; return their number and the worst violation.

    Each is a block of one row: a violation's share is undone, what is open may close but not more.
    """
    count, worst, h = 0, 0.0, settings[STEP]
    for k in range(blocks):
        kind, i = table[k, 0], table[k, 2]
        if kind in (DRY_ROW, SOFT_ROWS):
            continue
        gap = floats[at[POS] + i] - floats[at[MARGIN] + i]
        held = kind == HELD_ROW
        after = gap if held else gap + h * max(u[i], 0.0)
        bad = abs(gap) if held else max(-after, 0.0)
        worst = max(worst, bad)
        push_table[count, 0] = HELD_ROW if held else STOP_ROW
        push_table[count, 1], push_table[count, 2] = 1, count
        push_b[count] = (settings[SHARE] * after if held or after < 0.0 else after) / h
        picked[count] = i
        count += 1
    return count, worst


@inline_kernel
def dense_inertia(
    mass: FloatArray, rows: IntArray, starts: IntArray, columns: IntArray, damping: FloatArray, h: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill M + h D (nv, nv) from the tree's rows."""
    n = rows.size
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
    for i in range(n):
        for a in range(starts[i], starts[i] + rows[i]):
            out[i, columns[a]] = out[columns[a], i] = mass[a]
        if damping.size:
            out[i, i] += h * damping[i]
