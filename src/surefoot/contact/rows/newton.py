"""Newton's method in the velocities of one connected part: proximal, so that redundant rows do no harm.

For impulses λ of the blocks (`blocks`) and velocities v after the step,

    M (v - v_free) = Jᵀ p(λ, v),    p_k = P_k(λ_k - ρ_k (J_k v + b_k))

is solved for v by Newton's method, then λ becomes p, until λ stays: the proximal method of multipliers on
Alart and Curnier's equations. The matrix M + Jᵀ (-∂p/∂u) J has the size of the part, whatever number of rows,
and a finite ρ lets rows that say the same twice share their load. Penalties begin soft, so that who sticks
and who slides sorts itself out, but firm where that can be foretold, and grow while the error falls; where
it grows instead, the best impulses are taken up again, more softly.

Sources: P. Alart, A. Curnier, "A mixed formulation for frictional contact problems prone to Newton like
solution methods", CMAME 92, 1991; R. T. Rockafellar, "Augmented Lagrangians and applications of the proximal
point algorithm in convex programming", Math. Oper. Res. 1(2), 1976.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.lu_factors import apply_lu, factor_lu
from surefoot.contact.rows.blocks import WIDEST
from surefoot.contact.rows.linearised import (
    assemble_matrix,
    evaluate_blocks,
    fill_motion,
    fill_residual,
    fill_velocities,
    follow_modes,
    free_speed,
    take_impulses,
    worst_error,
)
from surefoot.contact.rows.load_transfer import extend_transfer

PATIENCE, FULL, SEARCHES, FLAT = 12, 2, 12, 0.1
"""Newton steps for one λ where who sticks and who slides does not settle, and those of them that are whole at
any rate; evaluations along a later one, and the share of the first slope at which they end."""
ROW_PENALTY, TOP, SOFTEST = 1e3, 1e2, 1e-3
"""Penalty of a row times its inertia's inverse [-], and the largest and least shares of it that are used
[-]."""
FIRM = 0.1
"""Share to begin with where it and a softer first one tell the same of all blocks, who sticks and who slides,
or where one Newton step confirms what the softer one tells: where little changes from step to step."""
UP, DOWN, GRACE = 10.0, 100.0, 3
"""Factors of the share after a round that was better (twice where that tells the same modes), and after the
rounds without a better error that are let go on."""

EVEN = 0.3
"""Change of the error below which a round has but passed load between redundant rows [-]."""

System = tuple[FloatArray, FloatArray, FloatArray, FloatArray, IntArray, IntArray, FloatArray]
"""M (n, n), v_free (n,), J (m, n), b (m,), the columns that each block moves, and the blocks' tables."""
Point = tuple[FloatArray, FloatArray, FloatArray, IntArray]
"""Velocities v (n,), those of the rows u (m,), impulses p (m,) and modes of the blocks."""


@inline_kernel
def _look(system: System, share: float, x: FloatArray, point: Point) -> bool:
    """Fill u, p and the modes of a point's v for impulses x (m,); return whether the modes stayed."""
    _, _, J, b, columns, table, numbers = system
    v, u, p, modes = point
    fill_velocities(J, b, columns, table, v, u)
    return evaluate_blocks(table, numbers, share, x, u, p, modes)


@kernel
def _shorten(
    system: System, share: float, x: FloatArray, point: Point, step: FloatArray, room: FloatArray, down: float
) -> None:
    """Go back along a step that was taken to where the residual has no part along it, by regula falsi.

    Where the rows' laws are those of a convex function (all but friction's tie to the normal force) that is
    its least value on the way, and Newton's method with it finds the solution from anywhere.
    """
    v, low, high, at_low, length = point[0], 0.0, 1.0, -down, 1.0
    at_high = _along(system, point, step, room)
    if not at_high > 0.0:
        return
    for _ in range(SEARCHES):
        trial = low + (high - low) * max(0.05, min(0.95, -at_low / (at_high - at_low)))
        for i in range(v.size):
            v[i] += (length - trial) * step[i]
        length = trial
        _look(system, share, x, point)
        value = _along(system, point, step, room)
        if abs(value) <= FLAT * down:
            return
        if value > 0.0:
            high, at_high, at_low = trial, value, 0.5 * at_low
        else:
            low, at_low, at_high = trial, value, 0.5 * at_high


@inline_kernel
def _along(system: System, point: Point, step: FloatArray, room: FloatArray) -> float:
    """Return the residual's part along a step backwards: negative where the step should go on."""
    M, free, J, _, columns, table, _ = system
    v, _, p, _ = point
    fill_residual(M, free, J, columns, table, v, p, room)
    total = 0.0
    for i in range(v.size):
        total -= room[i] * step[i]
    return total


@inline_kernel
def _settle(
    system: System, share: float, x: FloatArray, point: Point, known: bool, H: FloatArray, order: IntArray,
    step: FloatArray, before: FloatArray, patience: int,
) -> tuple[int, bool, bool]:  # fmt: skip
    """Take Newton steps for impulses x until the modes stay; return their number, if so, and if H holds."""
    M, free, J, _, columns, table, numbers = system
    v, u, p, modes = point
    products = np.empty((2 * WIDEST + 1, v.size))
    for turn in range(patience):
        fill_residual(M, free, J, columns, table, v, p, step)
        if not known:
            known = assemble_matrix(M, J, columns, table, numbers, share, x, u, modes, H, products)
            if not factor_lu(H, order):
                return 0, False, False
        for i in range(v.size):
            before[i] = step[i]
        apply_lu(H, order, step)
        down = 0.0
        for i in range(v.size):
            v[i] -= step[i]
            down += step[i] * before[i]
        same = _look(system, share, x, point)
        if not same and turn >= FULL and down > 0.0:
            _shorten(system, share, x, point, step, before, down)
        known = known and same
        if same:
            return turn + 1, True, known
    return patience, False, False


@inline_kernel
def _judge(
    system: System, point: Point, factors: FloatArray, order: IntArray, step: FloatArray, still: FloatArray,
    u: FloatArray,
) -> float:  # fmt: skip
    """Return the velocity error of a point's impulses with the velocities that they make, to rounding."""
    M, free, J, b, columns, table, numbers = system
    v, _, p, _ = point
    fill_residual(M, free, J, columns, table, v, p, step)
    apply_lu(factors, order, step)
    for i in range(v.size):
        still[i] = v[i] - step[i]
    fill_velocities(J, b, columns, table, still, u)
    return worst_error(table, numbers, p, u)


@inline_kernel
def _scale(system: System, u: FloatArray) -> float:
    """Return the speed that errors are measured over, infinite for what is no number; fills free u (m,)."""
    _, free, J, b, columns, table, _ = system
    fill_velocities(J, b, columns, table, free, u)
    scale = total = 0.0
    for k in range(table.shape[0]):
        scale = max(scale, free_speed(table, k, u))
    for i in range(u.size):
        total += u[i]
    return scale if abs(total) < np.inf else np.inf


@inline_kernel
def _begin(system: System, share: float, x: FloatArray, point: Point) -> tuple[float, bool]:
    """Return the share of the penalties to begin with, and whether its modes are but a guess.

    `FIRM` where it tells the modes of a softer one; where it does not, those of the softer one are tried with
    it: what sticks carries what it takes. One Newton step confirms them, or it is begun softly.
    """
    _, _, _, _, _, table, numbers = system
    _, u, p, modes = point
    if share >= FIRM or evaluate_blocks(table, numbers, FIRM, x, u, p, modes):
        return max(share, FIRM), False
    evaluate_blocks(table, numbers, share, x, u, p, modes)
    follow_modes(table, numbers, FIRM, x, u, p, modes)
    return FIRM, True


@inline_kernel
def _firmer(system: System, share: float, x: FloatArray, point: Point) -> float:
    """Return the share after a round that was better: two steps of it at once where the modes stay so."""
    _, _, _, _, _, table, numbers = system
    _, u, p, modes = point
    firm = min(share * UP * UP, TOP)
    return firm if evaluate_blocks(table, numbers, firm, x, u, p, modes) else min(share * UP, TOP)


@inline_kernel
def _improve(
    system: System, first: float, bound: float, most: int, point: Point, x: FloatArray, best: FloatArray,
    factors: FloatArray, order: IntArray, rooms: FloatArray, u: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Find impulses from x (m,) with an error up to a bound; return Newton steps and the best's error.

    The last of the rooms (4, n) has the velocities that the best make.
    """
    _, free, J, _, columns, table, numbers = system
    n, step = free.size, rooms[0]
    H, own_order = np.empty((n, n)), np.empty((3, n), np.int64)
    fill_motion(J, columns, table, x, factors, order, free, step, rooms[3])
    for i in range(n):
        point[0][i] = rooms[3, i]
    _look(system, first, x, point)
    share, guessed = _begin(system, first, x, point)
    least, done, worse, known = np.inf, 0, 0, False
    while done < most:
        patience = 1 if guessed else PATIENCE
        used, settled, known = _settle(system, share, x, point, known, H, own_order, step, rooms[1], patience)
        if used == 0:
            break
        done += used
        if guessed and not settled:
            guessed, known, share = False, False, first
            fill_motion(J, columns, table, x, factors, order, free, step, point[0])
            _look(system, share, x, point)
            continue
        guessed, worse = False, worse + 1
        error = _judge(system, point, factors, order, step, rooms[2], u)
        flat = settled and (1.0 - EVEN) * least < error < (1.0 + EVEN) * least
        if error < least:
            least = error
            for i in range(best.size):
                best[i] = point[2][i]
            for i in range(n):
                rooms[3, i] = rooms[2, i]
            if least <= bound:
                break
            worse = 0
        if flat:
            worse = 0
            extend_transfer(table, numbers, x, point[2])
        back, before = worse > GRACE, share
        take_impulses(table, best if back else point[2], x)
        if worse == 0 and settled and not flat:
            share = _firmer(system, share, x, point)
        elif back or flat or not settled:
            share = max(share / DOWN, SOFTEST)
        if back:
            worse = 0
            fill_motion(J, columns, table, x, factors, order, free, step, point[0])
        known = _look(system, share, x, point) and known and share == before
    return done, least


@kernel
def solve_part(
    M: FloatArray, v: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, share: float, tol: float, most: int, forces: FloatArray,
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
    columns, table, numbers
        (k, n + 1), (k, 4) and (k, 6) of the blocks, see `blocks`.
    share
        Of the penalties that is used first [-].
    tol
        Velocity error over the scale to reach [-].
    most
        Newton steps at most.
    forces
        (m,) impulses to start from (of soft blocks: their softness R); the best that were found [N s].
    """
    n, m, count = v.size, b.size, table.shape[0]
    factors, order, free = M.copy(), np.empty((3, n), np.int64), v.copy()
    modes = np.full(count, -1, np.int64)
    vectors, rooms = np.empty((4, m)), np.empty((4, n))
    x, u, p, best = vectors[0], vectors[1], vectors[2], vectors[3]
    if not factor_lu(factors, order):
        return 0, np.inf, 0.0
    system = (M, free, J, b, columns, table, numbers)
    scale = _scale(system, u)
    if not scale < np.inf:
        return 0, np.inf, 0.0
    if scale == 0.0:  # nothing has to be stopped
        for i in range(m):
            forces[i] = 0.0
        return 0, 0.0, 0.0
    for i in range(m):
        x[i] = best[i] = forces[i]
    point = (v, u, p, modes)
    done, least = _improve(
        system, share, tol * scale, most, point, x, best, factors, order, rooms, np.empty(m)
    )
    for i in range(m):
        forces[i] = best[i]
    for i in range(n):
        v[i] = rooms[3, i]
    return done, least / scale, scale
