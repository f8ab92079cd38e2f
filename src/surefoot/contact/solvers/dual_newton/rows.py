"""Linear rows low <= T f <= high (joint torque limits) beside the cones, kept by multipliers.

Every row becomes an unknown q in its interval and a heavily weighted target T f - q = 0, whose multiplier is
carried from one Newton solve to the next until the rows hold: the proximal method of multipliers [1]_. If no
force fits, the multipliers grow along a direction that proves it, and the forces tend to those with the least
squared violation [2]_.

References
----------
.. [1] R. T. Rockafellar, "Augmented Lagrangians and applications of the proximal point algorithm in
   convex programming", Mathematics of Operations Research 1(2), 1976.
.. [2] A. Chiche, J. C. Gilbert, "How the augmented Lagrangian algorithm can deal with an infeasible
   convex quadratic optimization problem", Journal of Convex Analysis 23(2), 2016.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.solvers.dual_newton import distribution_memory as base
from surefoot.contact.solvers.dual_newton.dense import (
    CENTRE,
    DUAL,
    HIGH,
    LINK,
    LOW,
    MU,
    TARGET,
    VALUE,
    minimise,
)
from surefoot.contact.solvers.dual_newton.row_proofs import (
    HEAVY,
    LAST,
    LIGHT,
    MOVED,
    MULTIPLIER,
    ROUNDING,
    Program,
    gap_of_rows,
    proves_empty,
)
from surefoot.contact.solvers.dual_newton.wrench_distribution import RELATIVE, distribute_wrench

RowsWork = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
TURNS, STUBBORN, RAISE, ALMOST_KEPT = 30, 3, 10.0, 1e-6
LEAST = 1.0 - 1e-6  # share of the last violation from which an empty set's least violation is reached
HEAVINESS, LIGHTNESS = 100.0, 1e-3  # weights of T f - q and of q, against those of the wrench and of f
INSET = 1e-9  # the rows are kept this much inside their limits, so that they hold in spite of rounding
WIDEST_INSET = 1e-5  # ... or, where rounding is worse than that, up to this much
LEAST_ITERATIONS = 1000.0  # that the rows may take, over all turns: many points that share a joint took 330
TRIES = 3


@kernel
def _stiffen(program: Program, rows: FloatArray, factor: float) -> None:
    """Multiply the roots of the rows' weights by `factor`."""
    columns, sets, _, duals, _ = program
    count, m = rows.shape[0], duals.shape[1]
    contacts = sets.shape[0] - count
    for j in range(count):
        a = m - count + j
        # the row's term is root (T f - q); y times the root is the multiplier, and must stay what it is
        rows[j, HEAVY] *= factor
        sets[contacts + j, LINK] *= factor
        duals[DUAL, a] /= factor
        for i in range(columns.shape[0]):
            columns[i, a] *= factor


@kernel
def _update(program: Program, rows: FloatArray) -> tuple[float, float]:
    """Move the multipliers; return the largest violation and the largest pull of a moved q."""
    columns, sets, points, duals, _ = program
    count, m = rows.shape[0], duals.shape[1]
    contacts = sets.shape[0] - count
    violation = shift = 0.0
    for j in range(count):
        a, i_q = m - count + j, 3 * contacts + j
        value = 0.0
        for i in range(3 * contacts):
            value += columns[i, a] * points[VALUE, i]
        value /= rows[j, HEAVY]
        low, high = sets[contacts + j, LOW] / rows[j, LIGHT], sets[contacts + j, HIGH] / rows[j, LIGHT]
        violation = max(violation, low - value, value - high)
        q = points[VALUE, i_q] / rows[j, LIGHT]
        shift = max(shift, abs(q - rows[j, LAST]) * rows[j, LIGHT])
        multiplier = duals[DUAL, a] * rows[j, HEAVY]  # y of `dense` is the multiplier over the row's root
        rows[j, MOVED] = multiplier - rows[j, MULTIPLIER]
        rows[j, MULTIPLIER], rows[j, LAST] = multiplier, q
    # what is left of rows that have no part in the direction: rounding, which an endless force would multiply
    least = ROUNDING * np.abs(rows[:, MOVED]).max()
    for j in range(count):
        if abs(rows[j, MOVED]) <= least:
            rows[j, MOVED] = 0.0
    return violation, shift


@kernel
def _keep_rows(
    program: Program, rows: FloatArray, tol: float, row_tol: float, limit: float
) -> tuple[float, float, int, bool, bool]:
    """Solve the program with the intervals as limits on T f; `rows` is (rows, 5), see the top of this file.

    Returns
    -------
    tuple
        ||F||², largest violation of a row, iterations, whether the multipliers have settled and whether
        no force fits.
    """
    columns, sets, points, duals, _ = program
    count, m = rows.shape[0], duals.shape[1]
    contacts = sets.shape[0] - count
    iterations = still = raised = 0
    error = violation = last = np.inf
    empty = False
    for _ in range(TURNS):
        for j in range(count):
            # the row's target is its multiplier over the root, and q is drawn to where it was: Rockafellar's
            # proximal method of multipliers, one turn a solve
            duals[TARGET, m - count + j] = rows[j, MULTIPLIER] / rows[j, HEAVY]
            points[CENTRE, 3 * contacts + j] = rows[j, LIGHT] * rows[j, LAST]
        error, floor, used = minimise(*program, True, tol, limit)
        iterations += used
        violation, shift = _update(program, rows)
        # a multiplier that stands still leaves q where it was: the proximal term 1/2 ||q - q_last||² is spent
        if violation <= row_tol and shift**2 <= max(tol, floor):
            return error, violation, iterations, True, False
        still = still + 1 if violation > max(row_tol, (LEAST if empty else 0.95) * last) else 0
        # multipliers that grow along a separating direction: no force fits,
        # and what is left is the least violation
        empty = empty or (violation > row_tol and proves_empty(columns, sets, rows))
        if iterations >= limit or (empty and still >= STUBBORN):
            break
        if still >= STUBBORN and raised < 4:  # feasible, it seems, but with multipliers far away
            _stiffen(program, rows, math.sqrt(RAISE))
            raised += 1
            still = 0
        last = violation
    for _ in range(raised):
        _stiffen(program, rows, 1.0 / math.sqrt(RAISE))
    return error, violation, iterations, False, empty


@kernel
def row_violation(jacobian: FloatArray, forces: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Return by how much the worst row of low <= Jᵀ f <= high is broken, negative if all hold.

    J is (3n, rows), the forces (n, 3) [N], the limits (rows,): joint torques [N·m], say.
    """
    worst = -math.inf
    for j in range(jacobian.shape[1]):
        value = 0.0
        for k in range(forces.shape[0]):
            for i in range(3):
                value += jacobian[3 * k + i, j] * forces[k, i]
        worst = max(worst, low[j] - value, value - high[j])
    return worst


def rows_work(contacts: int, count: int) -> RowsWork:
    """Return the work space of `distribute_with_rows`: columns, sets, points, duals, H and rows."""
    size, m = 3 * contacts, 6 + count
    return (
        np.zeros((size, m)), np.zeros((contacts + count, 4)), np.zeros((5, size + count)),
        np.zeros((5, m)), np.zeros((m, m)), np.zeros((count, 5)),
    )  # fmt: skip


@kernel
def _load_rows(
    wrench: FloatArray, jacobian: FloatArray, low: FloatArray, high: FloatArray, work: FloatArray,
    program: Program, rows: FloatArray, margin: float,
) -> None:  # fmt: skip
    """Copy a loaded wrench program from `work` and add the rows to it, `margin` inside their limits."""
    columns, sets, points, duals, _ = program
    count, contacts = rows.shape[0], columns.shape[0] // 3
    wide = steep = 0.0
    for k in range(contacts):
        on = 1.0 if work[k, base.HIGH] > 0.0 else 0.0
        sets[k, MU], sets[k, LOW], sets[k, HIGH] = work[k, base.MU], work[k, base.LOW], work[k, base.HIGH]
        for i in range(3):
            unit = on * work[k, base.NORMAL if i == 2 else base.TANGENT]
            points[CENTRE, 3 * k + i] = work[k, base.CENTRE + i]
            for a in range(6):
                columns[3 * k + i, a] = on * work[k, base.BLOCK + 6 * i + a]
                wide += columns[3 * k + i, a] ** 2
            for j in range(count):
                columns[3 * k + i, 6 + j] = unit * jacobian[3 * k + i, j]
                steep += columns[3 * k + i, 6 + j] ** 2
    steep = steep / count if steep > 0.0 else 1.0
    # T f - q weighs HEAVINESS times what the wrench does, and q - q_last hardly anything
    heavy, light = math.sqrt(HEAVINESS * max(wide, 1.0) / steep), math.sqrt(LIGHTNESS / steep)
    for j in range(count):
        rows[j, HEAVY], rows[j, LIGHT] = heavy, light
        # a little inside the limits, so that the answer keeps them in spite of its tolerance
        inset = min(margin, 0.25 * (high[j] - low[j]))
        sets[contacts + j, LOW] = light * (low[j] + inset)
        sets[contacts + j, HIGH] = light * (high[j] - inset)
        # the slack q of a row is a variable in an interval, like a contact in its cone
        sets[contacts + j, LINK] = heavy / light
        rows[j, LAST] = min(max(rows[j, LAST], low[j] + inset), high[j] - inset)
        duals[DUAL, 6 + j] = rows[j, MULTIPLIER] / heavy
        for i in range(3 * contacts):
            columns[i, 6 + j] *= heavy
    for a in range(6):
        duals[TARGET, a] = wrench[a] * work[contacts, base.ROOT + a]


@kernel
def _aim_at_forces(program: Program, rows: FloatArray) -> None:
    """Ask for the forces that keep the rows and are nearest, whatever the wrench: a far easier program."""
    columns, _, points, duals, _ = program
    steep = 0.0
    for i in range(columns.shape[0]):
        # nearest to the forces at hand, and no wrench
        points[CENTRE, i] = points[VALUE, i]
        for a in range(6):
            columns[i, a] = 0.0
        for j in range(rows.shape[0]):
            steep += (columns[i, 6 + j] / rows[j, HEAVY]) ** 2
    duals[TARGET, :6] = 0.0
    duals[DUAL, :] = 0.0
    rows[:, MULTIPLIER] = 0.0
    heavy = math.sqrt(HEAVINESS * rows.shape[0] / steep) if steep > 0.0 else 1.0
    _stiffen(program, rows, heavy / rows[0, HEAVY])


@inline_kernel
def _not_usable(jacobian: FloatArray, low: FloatArray, high: FloatArray) -> bool:
    """Tell whether the rows hold a number that is not finite, or a limit that nothing can keep."""
    check = 0.0
    for j in range(jacobian.shape[1]):
        check += 0.0 if low[j] < math.inf and high[j] > -math.inf else math.nan
        for i in range(jacobian.shape[0]):
            check += 0.0 * jacobian[i, j]
    return check != 0.0


@inline_kernel
def _solve_rows(
    wrench: FloatArray, jacobian: FloatArray, low: FloatArray, high: FloatArray, work: FloatArray,
    program: Program, rows: FloatArray, tol: float, limit: float,
) -> tuple[float, int, bool, bool]:  # fmt: skip
    """Solve the loaded wrench program with the rows, a little inside their limits.

    Returns
    -------
    tuple
        ||F||² (infinite where the optimum was not reached), iterations, whether the multipliers have settled
        at the optimum and whether no force fits.
    """
    error, margin, iterations, tries = math.inf, INSET, 0, 0
    solved = empty = restoring = False
    while tries < TRIES:
        if restoring:
            _aim_at_forces(program, rows)
        else:
            _load_rows(wrench, jacobian, low, high, work, program, rows, margin)
        # one call for both: LLVM folds the whole method into every place that calls it
        reached, violation, used, settled, none = _keep_rows(
            program, rows, tol, INSET if restoring else margin, limit
        )
        iterations, tries = iterations + used, tries + 1
        empty = none  # the proof speaks of rows and cones alone, whatever is asked beside them
        if not restoring:
            solved = settled
            error = math.inf if empty else reached  # there is no optimum to be near
            margin = 4.0 * violation  # rounding allows no better: stay inside by more than that
        if settled or empty:
            break
        # broken by more than rounding could: a wider inset would not mend it
        if not restoring and (tries == TRIES or violation > WIDEST_INSET):
            restoring, tries, error = True, 0, math.inf
    return error, iterations, solved, empty


@inline_kernel
def _take_forces(points: FloatArray, work: FloatArray, contacts: int) -> bool:
    """Copy the forces found to `work`; False if they are too large for double precision."""
    check = 0.0
    for k in range(contacts):
        for i in range(3):
            work[k, base.FORCE + i] = points[VALUE, 3 * k + i]
            check += 0.0 * points[VALUE, 3 * k + i]
    return check == 0.0


@kernel
def distribute_with_rows(
    grasp_map: FloatArray, wrench: FloatArray, jacobian: FloatArray, low: FloatArray, high: FloatArray,
    work: FloatArray, columns: FloatArray, sets: FloatArray, points: FloatArray, duals: FloatArray,
    H: FloatArray, rows: FloatArray, forces: FloatArray,
) -> int:  # fmt: skip
    """Write the optimal (n, 3) forces [N] that also keep low <= Jᵀ f <= high; return a code.

    As for `distribute_wrench`, with J (3n, rows), limits (rows,) and what `rows_work` returns. The rows are
    first left out: mostly they hold by themselves, and then that is the optimum.
    """
    contacts, results = forces.shape[0], forces.shape[0] + 1
    if _not_usable(jacobian, low, high):
        base.hold(work, contacts, forces)
        return base.INVALID
    # without the rows first
    code = distribute_wrench(grasp_map, wrench, work, forces)
    violation = row_violation(jacobian, forces, low, high)
    work[results, base.ROW_VIOLATION] = violation
    if code == base.INVALID or violation <= 0.0:
        work[results, base.ROWS_WARM] = 0.0
        return code
    # cold: no multipliers yet, the wrench's dual is a good guess
    if work[results, base.ROWS_WARM] == 0.0:
        rows[:, MULTIPLIER] = 0.0
        rows[:, LAST] = 0.0
        for a in range(6):
            duals[DUAL, a] = work[contacts, base.DUAL + a]
    tol, limit = work[results, base.TOLERANCE] ** 2, max(work[results, base.LIMIT], LEAST_ITERATIONS)
    error, iterations, solved, empty = _solve_rows(
        wrench, jacobian, low, high, work, (columns, sets, points, duals, H), rows, tol, limit
    )
    if not _take_forces(points, work, contacts):
        work[results, base.WARM] = work[results, base.ROWS_WARM] = 0.0
        base.hold(work, contacts, forces)
        work[results, base.ROW_VIOLATION] = row_violation(jacobian, forces, low, high)
        return base.INVALID
    # measured anew on the wrench alone, and on the rows themselves
    base.unload(work, contacts, forces)
    missing = base.remainder(work, contacts, base.weigh(wrench, work, contacts))
    violation = row_violation(jacobian, forces, low, high)
    # the bound on the error counts the inset of the rows; forces that break a row have no such bound
    proven = math.inf
    if solved and violation <= 0.0:
        proven = max(error, gap_of_rows((columns, sets, points, duals, H), rows, low, high))
    left = base.measure(work, contacts, missing, proven)
    work[results, base.ROW_VIOLATION] = violation
    work[results, base.ITERATIONS] += iterations
    work[results, base.ROWS_WARM] = 1.0 if solved else 0.0
    if empty:
        return base.INFEASIBLE
    if solved and violation <= 0.0 and error <= max(tol, RELATIVE * left):
        return base.SOLVED
    return base.ALMOST if solved and violation <= ALMOST_KEPT else base.MAX_ITERATIONS
