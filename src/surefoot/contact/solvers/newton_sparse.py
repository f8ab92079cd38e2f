"""The Newton step of `newton` for many contacts: a sparse reduced matrix, factorised by SuperLU or LAPACK."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel, working_time
from surefoot.contact.problem.blocks import block_product
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solvers.newton_step import PATIENCE, PROXIMAL, PROXIMAL_FAR, classify, spread
from surefoot.contact.solvers.nsgs import prepare_blocks, run_blocks
from surefoot.contact.solvers.stopping import force_error, velocity_error

SWEEPS_GROW, SWEEPS_MOST = 1.1, 400
"""By how much more sweeps follow each further step, and the most of them."""
DENSE_ROWS, DENSE_ABOVE = 150, 0.25
"""Rows below which, and share of non-zeros above which, the reduced matrix is factorised as a dense one."""
SYMMETRIC: dict[str, Any] = {
    "permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.1, "options": {"SymmetricMode": True},
}  # fmt: skip
"""How SuperLU orders and pivots: where the non-zeros are is symmetric, and least degree on them takes a half
to two thirds of the time of its default, which orders the columns for any rows."""


@kernel
def _reduced_entries(
    starts: IntArray, neighbours: IntArray, values: FloatArray, rows: FloatArray, columns: FloatArray,
    weight: FloatArray, count: IntArray, first: IntArray,
) -> tuple[IntArray, IntArray, FloatArray]:  # fmt: skip
    """Return the reduced matrix in compressed rows."""
    n = count.size
    # room first: a block gives as many entries as its two contacts have unknowns
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
                B = values[at]  # the entry rows_kc · G_kj columns_jd, and the weight on the diagonal
                p = rows[k, c, 0] * B[0, 0] + rows[k, c, 1] * B[1, 0] + rows[k, c, 2] * B[2, 0]
                q = rows[k, c, 0] * B[0, 1] + rows[k, c, 1] * B[1, 1] + rows[k, c, 2] * B[2, 1]
                r = rows[k, c, 0] * B[0, 2] + rows[k, c, 1] * B[1, 2] + rows[k, c, 2] * B[2, 2]
                # rows differ from columns under Coulomb's law where a
                # contact slides: the matrix is not symmetric
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
    transposed = sp.csc_matrix((entries, where, begin), shape=(m, m))
    try:
        if m < DENSE_ROWS or entries.size > DENSE_ABOVE * m * m:
            # small or nearly full: SuperLU's ordering and bookkeeping would
            # take longer than LAPACK's dense factors
            lu, pivots, info = scipy.linalg.lapack.dgetrf(transposed.toarray(order="F"), overwrite_a=True)
            if info != 0:
                return None
            x: FloatArray = scipy.linalg.lapack.dgetrs(lu, pivots, b, trans=1)[0]
        else:
            factors: Any = scipy.sparse.linalg.splu(transposed, **SYMMETRIC)
            x = factors.solve(b, trans="T")
    except RuntimeError:  # SuperLU's word for a singular matrix
        return None
    return x if np.isfinite(x).all() else None


class BlockNewton:
    """Newton steps on one problem's 3x3 blocks, with Gauss-Seidel sweeps between them if wanted.

    A sweep costs a hundredth of a step with its factorisation. A few dozen after each step take out what a
    wrong guess of who slides has left, as a smoother does between the levels of a multigrid method; without
    them Newton's method cycles on redundant contacts.
    """

    def __init__(self, problem: ContactProblem, tol: float, end: float) -> None:
        self.problem, self.tol, self.end = problem, tol, end
        b, n = problem.blocks, problem.contacts
        self.matrix = b.starts, b.columns, b.values
        self.local = prepare_blocks(*self.matrix, problem.scales)
        self.convex = problem.law.shift == 0.0
        self.laws = problem.mu, problem.normal_min, problem.normal_max
        self._frames, self._known = np.empty((2, n, 3, 3)), np.empty((3, n, 3))
        self._step, self._count = np.empty(3 * n), np.empty(n, dtype=np.int64)

    def measure(self, forces: FloatArray) -> tuple[FloatArray, float, float]:
        """Return the velocities of flat (3n,) forces, their velocity error, and their force error."""
        g = self.problem.g
        velocities = block_product(*self.matrix, forces) + g
        error = float(velocity_error(forces, velocities, *self.laws, self.local, self.convex))
        far = float(force_error(forces, velocities, g, *self.laws, self.local, self.convex))
        return velocities, error, far

    def sweep(self, forces: FloatArray, count: int) -> int:
        """Sweep over flat (3n,) forces in place, until solved or `count` times; return how often."""
        state = np.array([1.0, np.inf, 0.0])
        return run_blocks(
            *self.matrix, self.problem.g, *self.laws, self.convex, self.tol, count, self.local, forces, state
        )[0]  # fmt: skip

    def step(self, forces: FloatArray, velocities: FloatArray, proximal: float) -> FloatArray | None:
        """Return the (3n,) forces after one step; None if the linearised equations are singular."""
        (rows, columns), (weight, jump, target), count = self._frames, self._known, self._count
        known = rows, columns, weight, jump, target
        classify(forces, velocities, self.local, *self.laws, self.convex, *known, proximal, count)
        first = np.concatenate([[0], np.cumsum(count)])
        moved = velocities + block_product(*self.matrix, jump.ravel())
        reduced = _reduced_entries(*self.matrix, rows, columns, weight, count, first)
        unknowns = _solve(*reduced, _right_hand_side(moved, rows, target, count, first))
        if unknowns is None:
            return None
        spread(columns, jump, count, unknowns, self._step)
        return forces + self._step

    def run(
        self,
        forces: FloatArray,
        limit: int,
        share: float,
        sweeps: int = 0,
        patience: int = PATIENCE,
        span: int | None = None,
    ) -> tuple[int, float]:
        """Take steps from flat forces, updated in place and never worse; return their number and the error.

        Parameters
        ----------
        forces
            Flat forces.
        limit
            Most steps, or most of steps and sweeps if there are sweeps.
        share
            The proximal term over the force error, see `newton`.
        sweeps
            After the first step; `SWEEPS_GROW` times as many after each further one.
        patience
            Steps that may pass without a force error that falls well.
        span
            Steps in which the velocity error has to halve; None without such a bound.
        """
        current = forces.copy()
        velocities, best, far = self.measure(current)
        nearest, done, since, count = far, 0, 0, float(sweeps)
        mark, idle = best, 0
        while done < limit and best > self.tol and since < patience and working_time() < self.end:
            # the force error steers (the proximal term, patience): velocities of a high
            # stack stay large until its last force is right. The velocity error judges: the
            # forces kept are those with the least of it
            moved = self.step(current, velocities, max(PROXIMAL, min(PROXIMAL_FAR, share * far)))
            done, since, idle = done + 1, since + 1, idle + 1
            if moved is None:
                break
            current = moved
            velocities, error, far = self.measure(current)
            if sweeps and error > self.tol and done < limit:
                done += self.sweep(current, min(int(count), SWEEPS_MOST, limit - done))
                count *= SWEEPS_GROW
                velocities, error, far = self.measure(current)
            if far < 0.9 * nearest:
                nearest, since = far, 0
            if error < best:
                best = error
                forces[:] = current
            if best < 0.5 * mark:
                mark, idle = best, 0
            elif idle == span:
                break
        return done, best
