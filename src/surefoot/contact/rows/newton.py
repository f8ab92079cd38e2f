"""Newton's method in the velocities of one connected part: proximal, so that redundant rows do no harm.

For impulses λ of the blocks (`blocks`) and velocities v after the step,

    M (v - v_free) = Jᵀ p(λ, v),    p_k = P_k(λ_k - ρ_k (J_k v + b_k))

is solved for v by Newton's method, then λ becomes p, until λ stays: the proximal method of multipliers on
Alart and Curnier's equations. The matrix M + Jᵀ (-∂p/∂u) J has the size of the part, whatever number of rows,
and a finite ρ lets rows that say the same twice share their load. Penalties begin soft, so that who sticks
and
who slides sorts itself out, and grow while the error falls; where it grows instead, the best impulses are
taken up again, more softly.

Sources: P. Alart, A. Curnier, "A mixed formulation for frictional contact problems prone to Newton like
solution methods", CMAME 92, 1991; R. T. Rockafellar, "Augmented Lagrangians and applications of the proximal
point algorithm in convex programming", Math. Oper. Res. 1(2), 1976.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.lu_factors import apply_lu, factor_lu
from surefoot.contact.rows.blocks import (
    DIM,
    DRY_ROW,
    FIRST,
    HELD_ROW,
    KIND,
    LIMIT,
    MU,
    SLIDE,
    SOFT_ROWS,
    STIFF,
    STIFF_T,
    WEIGHT,
    WIDEST,
    block_error,
    project,
    slope,
)

MOST = 60
"""Newton steps of one attempt: heaps of boxes that need more need another start (tuned on the scenes of
tests/contact/rows)."""
PATIENCE, FULL, SEARCHES, FLAT = 12, 2, 12, 0.1
"""Newton steps for one λ where who sticks and who slides does not settle, and those of them that are whole at
any rate; evaluations along a later one, and the share of the first slope at which they end."""
ROW_PENALTY, TOP, SOFTEST = 1e3, 1e2, 1e-3
"""Penalty of a row times its inertia's inverse [-], and the largest and least shares of it that are used
[-]."""
UP, DOWN, GRACE = 10.0, 100.0, 3
"""Factors of the share after a round that was better, and after the rounds without a better error that are
let go on."""
ROW_ATTEMPTS = ((1e-3, True), (1.0, False), (0.1, False), (1e-3, False))
"""First share, and whether from the impulses at hand; else from none: what one start misses, another
finds."""


@inline_kernel
def _velocities(
    J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray, v: FloatArray, u: FloatArray
) -> None:
    """Fill u = J v + b, row by row over the columns that a block moves; see `find_columns`."""
    for k in range(table.shape[0]):
        few = columns[k, 0]
        for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
            total = b[i]
            for c in range(1, few + 1):
                total += J[i, columns[k, c]] * v[columns[k, c]]
            u[i] = total


@inline_kernel
def _find_columns(J: FloatArray, table: IntArray, columns: IntArray) -> None:
    """Fill the number of columns that each block's rows reach, and which they are: (n, 1 + dofs)."""
    for k in range(table.shape[0]):
        few = 0
        for j in range(J.shape[1]):
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                if J[i, j] != 0.0:
                    few += 1
                    columns[k, few] = j
                    break
        columns[k, 0] = few


@inline_kernel
def _residual(
    M: FloatArray, free: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, v: FloatArray,
    p: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill the dynamics' residual M (v - v_free) - Jᵀ p."""
    n = v.size
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += M[i, j] * (v[j] - free[j])
        out[i] = total
    for k in range(table.shape[0]):
        for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
            if p[i] != 0.0:
                for c in range(1, columns[k, 0] + 1):
                    out[columns[k, c]] -= J[i, columns[k, c]] * p[i]


@inline_kernel
def _add_block(
    J: FloatArray, columns: IntArray, k: int, first: int, dim: int, D: FloatArray, H: FloatArray,
    moved: FloatArray,
) -> None:  # fmt: skip
    """Add J_kᵀ D J_k to H, over the columns that the block moves."""
    few = columns[k, 0]
    for a in range(dim):
        for c in range(1, few + 1):
            total = 0.0
            for b in range(dim):
                total += D[a, b] * J[first + b, columns[k, c]]
            moved[a, c] = total
    for a in range(dim):
        for d in range(1, few + 1):
            value = J[first + a, columns[k, d]]
            if value != 0.0:
                row = columns[k, d]
                for c in range(1, few + 1):
                    H[row, columns[k, c]] += value * moved[a, c]


@inline_kernel
def _evaluate(
    table: IntArray, numbers: FloatArray, share: float, x: FloatArray, u: FloatArray, p: FloatArray,
    modes: IntArray,
) -> bool:  # fmt: skip
    """Fill impulses and modes of all blocks; return whether the modes are those that stood there."""
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
def worst_error(table: IntArray, numbers: FloatArray, x: FloatArray, u: FloatArray) -> float:
    """Return the largest velocity error of the blocks [m/s]; infinite for what is no number."""
    worst = total = 0.0
    for k in range(table.shape[0]):
        error = block_error(
            table[k, KIND], table[k, DIM], numbers[k, MU], numbers[k, LIMIT], numbers[k, WEIGHT], x, u,
            table[k, FIRST],
        )  # fmt: skip
        worst, total = max(worst, error), total + error
    return worst if total >= 0.0 else np.inf


@inline_kernel
def free_speed(table: IntArray, k: int, b: FloatArray, u: FloatArray) -> float:
    """Return how fast a block's rows move that its impulses have to stop [m/s]; 0 for what does not close."""
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
def _assemble(
    M: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, numbers: FloatArray, share: float,
    x: FloatArray, u: FloatArray, modes: IntArray, H: FloatArray, moved: FloatArray,
) -> bool:  # fmt: skip
    """Fill H = M - Jᵀ ∂p/∂u J; return whether it is the same for all velocities of these modes."""
    D = np.empty((WIDEST, WIDEST))
    n, steady = M.shape[0], True
    for i in range(n):
        for j in range(n):
            H[i, j] = M[i, j]
    for k in range(table.shape[0]):
        slope(
            table[k, KIND], table[k, DIM], modes[k], numbers[k, MU], share * numbers[k, STIFF],
            share * numbers[k, STIFF_T], x, u, table[k, FIRST], D,
        )  # fmt: skip
        steady = steady and modes[k] != SLIDE
        _add_block(J, columns, k, table[k, FIRST], table[k, DIM], D, H, moved)
    return steady


@inline_kernel
def _take(table: IntArray, source: FloatArray, x: FloatArray) -> None:
    """Copy the impulses of all blocks but soft ones, whose place in x holds their softness."""
    for k in range(table.shape[0]):
        if table[k, KIND] != SOFT_ROWS:
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                x[i] = source[i]


@inline_kernel
def _from_impulses(
    J: FloatArray, columns: IntArray, table: IntArray, x: FloatArray, factors: FloatArray, order: IntArray,
    free: FloatArray, work: FloatArray, v: FloatArray,
) -> None:  # fmt: skip
    """Fill v = v_free + M⁻¹ Jᵀ λ."""
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


@kernel
def _shorten(
    M: FloatArray, free: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, share: float, x: FloatArray, v: FloatArray, step: FloatArray, room: FloatArray,
    down: float, u: FloatArray, p: FloatArray, modes: IntArray,
) -> None:  # fmt: skip
    """Go back along a step that was taken to where the residual has no part along it, by regula falsi.

    Where the rows' laws are those of a convex function (all but friction's tie to the normal force) that is
    its
    least value on the way, and Newton's method with it finds the solution from anywhere.
    """
    low, high, at_low, length = 0.0, 1.0, -down, 1.0
    at_high = _along(M, free, J, columns, table, v, p, step, room)
    if not at_high > 0.0:
        return
    for _ in range(SEARCHES):
        trial = low + (high - low) * max(0.05, min(0.95, -at_low / (at_high - at_low)))
        for i in range(v.size):
            v[i] += (length - trial) * step[i]
        length = trial
        _velocities(J, b, columns, table, v, u)
        _evaluate(table, numbers, share, x, u, p, modes)
        value = _along(M, free, J, columns, table, v, p, step, room)
        if abs(value) <= FLAT * down:
            return
        if value > 0.0:
            high, at_high, at_low = trial, value, 0.5 * at_low
        else:
            low, at_low, at_high = trial, value, 0.5 * at_high


@inline_kernel
def _along(
    M: FloatArray, free: FloatArray, J: FloatArray, columns: IntArray, table: IntArray, v: FloatArray,
    p: FloatArray, step: FloatArray, room: FloatArray,
) -> float:  # fmt: skip
    """Return the residual's part along a step backwards: negative where the step should go on."""
    _residual(M, free, J, columns, table, v, p, room)
    total = 0.0
    for i in range(v.size):
        total -= room[i] * step[i]
    return total


@inline_kernel
def _settle(
    M: FloatArray, free: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, share: float, x: FloatArray, known: bool, H: FloatArray, order: IntArray,
    v: FloatArray, work: tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, IntArray],
) -> tuple[int, bool, bool]:  # fmt: skip
    """Take Newton steps for the impulses x until the modes stay; return their number, if so, and if H holds.

    The work holds u, p (m,) of v, the step and room (n,), room (6, n + 1), and the modes.
    """
    u, p, step, before, moved, modes = work
    for turn in range(PATIENCE):
        _residual(M, free, J, columns, table, v, p, step)
        if not known:
            known = _assemble(M, J, columns, table, numbers, share, x, u, modes, H, moved)
            if not factor_lu(H, order):
                return 0, False, False
        for i in range(v.size):
            before[i] = step[i]
        apply_lu(H, order, step)
        down = 0.0
        for i in range(v.size):
            v[i] -= step[i]
            down += step[i] * before[i]
        _velocities(J, b, columns, table, v, u)
        same = _evaluate(table, numbers, share, x, u, p, modes)
        if not same and turn >= FULL and down > 0.0:
            _shorten(M, free, J, b, columns, table, numbers, share, x, v, step, before, down, u, p, modes)
        known = known and same
        if same:
            return turn + 1, True, known
    return PATIENCE, False, False


@kernel
def solve_part(
    M: FloatArray, v: FloatArray, J: FloatArray, b: FloatArray, table: IntArray, numbers: FloatArray,
    share: float, tol: float, forces: FloatArray,
) -> tuple[int, float, float]:  # fmt: skip
    """Solve one connected part; return the Newton steps, the velocity error over the scale, and that [m/s].

    Parameters
    ----------
    M
        (n, n) inertia, symmetric or not [kg].
    v
        (n,) velocities without impulses; those with the best that were found [m/s, rad/s].
    J, b
        (m, n) Jacobian, friction rows scaled, and (m,) what is added to its velocities [m/s].
    table, numbers
        (k, 4) and (k, 6) of the blocks, see `blocks`.
    share
        Of the penalties that is used first [-].
    tol
        Velocity error over the scale to reach [-].
    forces
        (m,) impulses to start from (of soft blocks: their softness R); the best that were found [N s].
    """
    n, m, count = v.size, b.size, table.shape[0]
    H, factors = np.empty((n, n)), M.copy()
    order, first_order = np.empty(n, np.int64), np.empty(n, np.int64)
    columns, modes = np.empty((count, n + 1), np.int64), np.full(count, -1, np.int64)
    vectors, room = np.empty((5, m)), np.empty((4, n))
    x, u, p, best, u_still = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4]
    free, step, still = room[0], room[1], room[2]
    work = (u, p, step, room[3], np.empty((WIDEST, n + 1)), modes)
    _find_columns(J, table, columns)
    if not factor_lu(factors, first_order):
        return 0, np.inf, 0.0
    for i in range(n):
        free[i] = v[i]
    _velocities(J, b, columns, table, free, u)
    scale = total = 0.0
    for k in range(count):
        scale = max(scale, free_speed(table, k, b, u))
    for i in range(m):
        total += u[i]
    if not abs(total) < np.inf:
        return 0, np.inf, 0.0
    if scale == 0.0:  # nothing has to be stopped
        for k in range(count):
            for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                forces[i] = 0.0
        return 0, 0.0, 0.0
    for i in range(m):
        x[i] = best[i] = forces[i]
    # where the impulses at hand lead
    _from_impulses(J, columns, table, x, factors, first_order, free, step, v)
    _velocities(J, b, columns, table, v, u)
    _evaluate(table, numbers, share, x, u, p, modes)
    least, done, worse, known = np.inf, 0, 0, False
    while done < MOST:
        used, settled, known = _settle(
            M, free, J, b, columns, table, numbers, share, x, known, H, order, v, work
        )
        if used == 0:
            break
        done += used
        # judged by the velocities that these impulses make, to rounding
        _residual(M, free, J, columns, table, v, p, step)
        apply_lu(factors, first_order, step)
        for i in range(n):
            still[i] = v[i] - step[i]
        _velocities(J, b, columns, table, still, u_still)
        error = worst_error(table, numbers, p, u_still)
        worse += 1
        if error < least:
            least, worse = error, 0
            for i in range(m):
                best[i] = p[i]
            if least <= tol * scale:
                break
        back = worse > GRACE
        _take(table, best if back else p, x)
        before = share
        if worse == 0 and settled:
            share = min(share * UP, TOP)
        elif back or not settled:
            share = max(share / DOWN, SOFTEST)
        if back:
            worse = 0
            _from_impulses(J, columns, table, x, factors, first_order, free, step, v)
            _velocities(J, b, columns, table, v, u)
        known = _evaluate(table, numbers, share, x, u, p, modes) and known and share == before
    for i in range(m):
        forces[i] = best[i]
    _from_best(J, columns, table, best, factors, first_order, free, step, v)
    return done, least / scale, scale


@inline_kernel
def _from_best(
    J: FloatArray, columns: IntArray, table: IntArray, best: FloatArray, factors: FloatArray, order: IntArray,
    free: FloatArray, work: FloatArray, v: FloatArray,
) -> None:  # fmt: skip
    """Fill v = v_free + M⁻¹ Jᵀ λ for the impulses of all blocks, soft ones too."""
    for i in range(v.size):
        work[i] = 0.0
    for k in range(table.shape[0]):
        for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
            for c in range(1, columns[k, 0] + 1):
                work[columns[k, c]] += J[i, columns[k, c]] * best[i]
    apply_lu(factors, order, work)
    for i in range(v.size):
        v[i] = free[i] + work[i]
