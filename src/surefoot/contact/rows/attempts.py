"""One connected part from one start after another: what one start misses, another finds."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.rows.blocks import DIM, FIRST, KIND, SOFT_ROWS
from surefoot.contact.rows.condensation import condense, follow_reached, sort_columns, take_reached
from surefoot.contact.rows.friction_spreading import any_slides, spread_friction
from surefoot.contact.rows.newton import solve_part
from surefoot.contact.rows.sweeps import sweep_part

AT_HAND = -1
"""For the number of sweeps: from the impulses at hand, without any."""
ROW_ATTEMPTS = (
    (1e-3, AT_HAND, 20), (1.0, 100, 20), (1.0, 300, 30), (1.0, 10, 60), (1.0, 0, 60), (0.1, 0, 60),
    (1e-3, 0, 60),
)  # fmt: skip
"""First share of the penalties, sweeps of Gauss-Seidel from no impulses (`AT_HAND`: see there), and Newton
steps at most. A hundred sweeps cost as much as ten Newton steps and lead nearly all to the solution that a
warm start misses: 24 of 28 such steps of walking and tumbling robots, ten sweeps 8. Of 61,799 steps of
tumbling models with contacts (`python -m benchmarks.mujoco_exact --models`) 22 stay unsolved without the
last three starts, 11 without three hundred sweeps, and 6 with all."""


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
            if sweeps > 0:
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
