"""What a block of rows may carry, as functions of its augmented impulse: kinds, projections, slopes, errors.

A block has `dim` rows of the Jacobian. Friction rows come behind the normal's and are scaled so that the cone
is round: ||λ_t|| <= mu λ_n for 2, 3 or 5 of them (sliding, spin, rolling).

| kind | rows | law |
| --- | --- | --- |
| HELD_ROW | 1 | any impulse, no velocity: a joint, an equality |
| DRY_ROW | 1 | |λ| <= limit, against the velocity: dry friction |
| STOP_ROW | 1 | 0 <= λ ⟂ u >= 0: a limit, a contact without friction |
| CONE_ROWS | 3, 4, 6 | Signorini's and Coulomb's laws with the most dissipation |
| SOFT_ROWS | 1, 3, 4, 6 | λ = P(-u / R), R a softness per row: no law, a pad that gives way |
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel

HELD_ROW, DRY_ROW, STOP_ROW, CONE_ROWS, SOFT_ROWS = range(5)
WIDEST = 6
"""Rows of a block at most."""
OPEN, STICK, SLIDE, LOW, HIGH = range(5)
"""Modes of a block: what its linearisation takes it for."""
KIND, DIM, FIRST, PART = range(4)
"""Columns of the blocks' table of whole numbers: kind, number of rows, first row, connected part."""
MU, LIMIT, WEIGHT, STIFF, STIFF_T, SCALE = range(6)
"""Columns of their table of numbers: friction [-], limit of dry friction [N s], velocity per impulse (the
trace of the block of G) [1/kg], penalties of the first row and of the others [kg], speed that errors are
measured over [m/s]."""


@inline_kernel
def project(
    kind: int, dim: int, mu: float, limit: float, stiff: float, stiff_t: float, x: FloatArray, u: FloatArray,
    at: int, p: FloatArray,
) -> int:  # fmt: skip
    """Fill the impulse p of a block, rows from `at` on, by Alart and Curnier's maps; return its mode.

    p = P(λ - ρ u) with λ in x: of a cone the normal part first, then the tangents onto the disc of radius
    mu p_n. A soft block has its own softnesses in x and no λ, see `soft_impulse`.
    """
    if kind == SOFT_ROWS:
        return soft_impulse(dim, mu, x, u, at, p)
    point = x[at] - stiff * u[at]
    if kind == HELD_ROW:
        p[at] = point
        return STICK
    if kind == DRY_ROW:
        p[at] = min(max(point, -limit), limit)
        return LOW if point < -limit else (HIGH if point > limit else STICK)
    if not point > 0.0:
        for a in range(dim):
            p[at + a] = 0.0
        return OPEN
    p[at] = point
    if dim == 1:
        return STICK
    square = 0.0
    for a in range(1, dim):
        p[at + a] = x[at + a] - stiff_t * u[at + a]
        square += p[at + a] * p[at + a]
    length, radius = math.sqrt(square), mu * point
    if length <= radius:
        return STICK
    for a in range(1, dim):
        p[at + a] *= radius / length
    return SLIDE


@inline_kernel
def soft_impulse(dim: int, mu: float, R: FloatArray, u: FloatArray, at: int, p: FloatArray) -> int:
    """Fill p (m,) with the impulse of a soft block: the nearest to -u / R in the metric R, within the cone.

    Rows are scaled: R is one number for all friction rows (MuJoCo's R_j mu_j² are all the same).
    """
    normal = -u[at] / R[at]
    if dim == 1:
        p[at] = max(normal, 0.0)
        return STICK if normal > 0.0 else OPEN
    square = 0.0
    for a in range(1, dim):
        p[at + a] = -u[at + a] / R[at + 1]
        square += p[at + a] * p[at + a]
    length = math.sqrt(square)
    if length <= mu * normal:
        p[at] = normal
        return STICK
    # the ray (1, mu e) nearest to the point in the metric (R_n, R_t)
    height = (R[at] * normal + R[at + 1] * mu * length) / (R[at] + mu * mu * R[at + 1])
    if height <= 0.0:
        for a in range(dim):
            p[at + a] = 0.0
        return OPEN
    p[at] = height
    for a in range(1, dim):
        p[at + a] *= mu * height / length
    return SLIDE


@inline_kernel
def slope(
    kind: int, dim: int, mode: int, mu: float, stiff: float, stiff_t: float, x: FloatArray, u: FloatArray,
    at: int, D: FloatArray,
) -> None:  # fmt: skip
    """Fill D (dim, dim) = -∂p/∂u of `project`, for the mode that it returned."""
    for a in range(dim):
        for b in range(dim):
            D[a, b] = 0.0
    if mode in (OPEN, LOW, HIGH):
        return
    if kind == SOFT_ROWS:
        _soft_slope(dim, mode, mu, x, u, at, D)
        return
    D[0, 0] = stiff
    if mode == STICK:
        for a in range(1, dim):
            D[a, a] = stiff_t
        return
    # sliding: p_t = mu p_n e, e the direction of λ_t - ρ_t u_t
    square = 0.0
    for a in range(1, dim):
        point = x[at + a] - stiff_t * u[at + a]
        square += point * point
    length = math.sqrt(square)
    turn = stiff_t * mu * (x[at] - stiff * u[at]) / length
    for a in range(1, dim):
        e = (x[at + a] - stiff_t * u[at + a]) / length
        D[a, 0] = mu * e * stiff
        for b in range(1, dim):
            f = (x[at + b] - stiff_t * u[at + b]) / length
            D[a, b] = turn * ((1.0 if a == b else 0.0) - e * f)


@inline_kernel
def _soft_slope(dim: int, mode: int, mu: float, R: FloatArray, u: FloatArray, at: int, D: FloatArray) -> None:
    """Fill D = -∂p/∂u of `soft_impulse`."""
    D[0, 0] = 1.0 / R[at]
    if mode == STICK:
        for a in range(1, dim):
            D[a, a] = 1.0 / R[at + 1]
        return
    square = 0.0
    for a in range(1, dim):
        square += u[at + a] * u[at + a]
    speed = math.sqrt(square)
    whole = R[at] + mu * mu * R[at + 1]
    height = (mu * speed - u[at]) / whole
    D[0, 0] = 1.0 / whole
    for a in range(1, dim):
        e = -u[at + a] / speed
        D[0, a] = D[a, 0] = mu * e / whole
        for b in range(1, dim):
            f = -u[at + b] / speed
            same = 1.0 if a == b else 0.0
            D[a, b] = mu * mu * e * f / whole + mu * height / speed * (same - e * f)


@inline_kernel
def block_error(
    kind: int, dim: int, mu: float, limit: float, w: float, x: FloatArray, u: FloatArray, at: int
) -> float:
    """Return the velocity error of a block, w ||λ - P_K(λ - (u + Γ(u)) / w)||, of x, u (m,) [m/s].

    The natural map of De Saxcé's form, not of the one that the solver linearises; evaluated in velocities,
    so that large impulses do not hide small ones; at least the speed of approach.
    """
    if kind == HELD_ROW:
        return float(abs(u[at]))
    own, v = w * x[at], u[at]
    if kind == DRY_ROW:
        bound = w * limit
        point = min(max(own - v, -bound), bound)
        return float(max(abs(own - point), abs(own) - bound))
    if kind == SOFT_ROWS:
        return 0.0
    if dim == 1:
        return float(max(abs(v) if own > v else abs(own), -min(v, own)))
    speed = size = 0.0
    for a in range(1, dim):
        speed += u[at + a] * u[at + a]
        size += (w * x[at + a] - u[at + a]) ** 2
    normal, length = own - v - mu * math.sqrt(speed), math.sqrt(size)
    # the nearest point of the cone
    height, share = normal, 1.0
    if length > mu * normal:
        height = (normal + mu * length) / (1.0 + mu * mu)
        if height <= 0.0:
            height, share = 0.0, 0.0
        else:
            share = mu * height / length
    gap = (own - height) ** 2
    for a in range(1, dim):
        gap += (w * x[at + a] - share * (w * x[at + a] - u[at + a])) ** 2
    return float(max(math.sqrt(gap), -v))


@inline_kernel
def find_columns(J: FloatArray, first: int, dim: int, found: IntArray) -> None:
    """Fill the number of columns that a block's rows reach, and then which they are: found (n + 1,)."""
    few, last = 0, first + dim - 1
    for j in range(J.shape[1]):
        used = J[first, j] != 0.0 or J[last, j] != 0.0
        for i in range(first + 1, last):
            used = used or J[i, j] != 0.0
        if used:
            few += 1
            found[few] = j
    found[0] = few


@inline_kernel
def fill_columns(J: FloatArray, table: IntArray, columns: IntArray) -> None:
    """Fill the columns (k, n + 1) that each block of a table reaches, see `find_columns`."""
    for k in range(table.shape[0]):
        find_columns(J, table[k, FIRST], table[k, DIM], columns[k])


@inline_kernel
def count_parts(table: IntArray, trees: IntArray, columns: IntArray, tree_of: IntArray) -> int:
    """Fill the connected part of every block and of every tree (trees (t,)); return their number.

    Blocks that move the same tree are joined, by the columns (k, n + 1) that they reach (`find_columns`); a
    tree that no block moves has part -1.
    """
    for t in range(trees.size):
        trees[t] = t
    # union of the trees that a block moves; its root in the table
    for k in range(table.shape[0]):
        root = -1
        for c in range(1, columns[k, 0] + 1):
            t = tree_of[columns[k, c]]
            while trees[t] != t:
                t = trees[t]
            if root < 0:
                root = t
            elif t != root:
                trees[max(t, root)] = min(t, root)
                root = min(t, root)
        table[k, PART] = root
    for k in range(table.shape[0]):
        root = table[k, PART]
        while root >= 0 and trees[root] != root:
            root = trees[root]
        table[k, PART] = root
    return _number_parts(table, trees)


@inline_kernel
def _number_parts(table: IntArray, trees: IntArray) -> int:
    """Replace the roots of parts by consecutive numbers, -1 for trees without a block."""
    for t in range(trees.size):
        root = t
        while trees[root] != root:
            root = trees[root]
        trees[t] = root
    count = 0
    for t in range(trees.size):
        if trees[t] != t:
            continue
        used = False
        for k in range(table.shape[0]):
            if table[k, PART] == t:
                used = True
                table[k, PART] = -2 - count
        number = -2 - count if used else -1
        for s in range(t, trees.size):
            if s != t and trees[s] == t:
                trees[s] = number
        trees[t] = number
        count += 1 if used else 0
    for t in range(trees.size):
        if trees[t] < -1:
            trees[t] = -2 - trees[t]
    for k in range(table.shape[0]):
        table[k, PART] = -2 - table[k, PART] if table[k, PART] < -1 else -1
    return count
