"""One connected part from one start after another: what one start misses, another finds."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.rows.blocks import CONE_ROWS, DIM, FIRST, KIND, SOFT_ROWS, STIFF, STOP_ROW
from surefoot.contact.rows.condensation import condense, follow_reached, sort_columns, take_reached
from surefoot.contact.rows.friction_spreading import any_slides, spread_friction
from surefoot.contact.rows.linearised import fill_velocities
from surefoot.contact.rows.newton import ROW_PENALTY, solve_part
from surefoot.contact.rows.sweeps import sweep_part

AT_HAND, PRESSED = -1, -2
"""For the number of sweeps: from the impulses at hand, without any; and from contacts that all press."""
ROW_ATTEMPTS = (
    (1e-3, AT_HAND, 20), (0.1, 100, 30), (1.0, 1000, 60), (1e-3, 10, 60), (1.0, PRESSED, 60),
    (1e-3, PRESSED, 60),
)  # fmt: skip
"""First share of the penalties, sweeps of Gauss-Seidel from no impulses (or see `AT_HAND`, `PRESSED`), and
Newton steps at most. A hundred sweeps cost as much as ten Newton steps and lead nearly all to the solution
that a warm start misses. Of 248,000 steps of tumbling models with contacts, seeds 0 to 3
(`python -m benchmarks.mujoco_exact --models`), 4 stay unsolved, 11 without the pressed starts."""


@inline_kernel
def _press(
    v: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray, numbers: FloatArray,
    x: FloatArray, trial: FloatArray,
) -> None:  # fmt: skip
    """Fill normal impulses of contacts and limits in trial (m,): all the largest at hand, or that one needs.

    What catches, as a foot does that sliding would drive into the ground, is found from there: from no
    impulses it opens first.
    """
    most, u = 0.0, np.empty(b.size)
    fill_velocities(J, b, columns, table, v, u)
    for k in range(table.shape[0]):
        if table[k, KIND] in (STOP_ROW, CONE_ROWS):
            at = table[k, FIRST]
            most = max(most, abs(x[at]), abs(u[at]) * numbers[k, STIFF] / ROW_PENALTY)
    for k in range(table.shape[0]):
        if table[k, KIND] in (STOP_ROW, CONE_ROWS):
            trial[table[k, FIRST]] = most


@inline_kernel
def _attempt(
    M: FloatArray, v: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, tol: float, x: FloatArray,
) -> tuple[int, float, float]:  # fmt: skip
    """Solve from one start after another, see `solve_rows`; v and x are replaced by the best."""
    least, speed, steps = np.inf, 0.0, 0
    start, free = x.copy(), v.copy()
    for i in range(x.size):
        x[i] = 0.0
    for share, sweeps, most in ROW_ATTEMPTS:
        trial, moved = start.copy(), free.copy()
        if sweeps == AT_HAND:
            if any_slides(table, numbers, trial):
                spread_friction(M, J, columns, table, numbers, trial)
        else:
            for k in range(table.shape[0]):
                if table[k, KIND] != SOFT_ROWS:
                    for i in range(table[k, FIRST], table[k, FIRST] + table[k, DIM]):
                        trial[i] = 0.0
            if sweeps == PRESSED:
                _press(free, J, b, columns, table, numbers, start, trial)
            elif sweeps > 0:
                sweep_part(M, free, J, b, table, numbers, sweeps, trial)
        used, error, speed = solve_part(M, moved, J, b, columns, table, numbers, share, tol, most, trial)
        steps += used
        if error < least:
            least = error
            for i in range(x.size):
                x[i] = trial[i]
            for i in range(v.size):
                v[i] = moved[i]
        if least <= tol:
            break
    return steps, least, speed


@kernel
def solve_rows(
    M: FloatArray, v: FloatArray, J: FloatArray, b: FloatArray, columns: IntArray, table: IntArray,
    numbers: FloatArray, tol: float, x: FloatArray,
) -> tuple[int, float, float]:  # fmt: skip
    """Solve one connected part; return the Newton steps, the velocity error over the scale, and that [m/s].

    Parameters and what is replaced: see `solve_part`. Columns that no row reaches are condensed out.
    """
    n = v.size
    places = np.empty((2, n), np.int64)
    place, order = places[0], places[1]
    reached = sort_columns(columns, place, order)
    own_M, own_v, own_J, own_columns, whole, condensed = M, v, J, columns, M, False
    if reached < n:
        whole, smaller = np.empty((n, n)), np.empty((reached, reached))
        condensed = condense(M, v, order, reached, whole, smaller)
        if condensed:
            own_M, own_v, own_J = smaller, np.empty(reached), np.empty((J.shape[0], reached))
            own_columns = np.empty((columns.shape[0], reached + 1), np.int64)
            take_reached(J, v, columns, place, order, own_J, own_v, own_columns)
    told = _attempt(own_M, own_v, own_J, b, own_columns, table, numbers, tol, x)
    if condensed:
        follow_reached(whole, order, own_v, v)
    return told
