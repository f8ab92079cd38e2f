"""MOSEK: a commercial interior-point method on symmetric cones; it runs with a licence only.

A quadratic objective beside cones becomes one more cone: t with (t, 1, R x) in the rotated cone, P = RᵀR.

References
----------
.. [1] E. D. Andersen, C. Roos, T. Terlaky, "On implementing a primal-dual interior-point method for conic
   quadratic optimization", Mathematical Programming 95, 2003.
.. [2] MOSEK ApS, "MOSEK Optimizer API for Python", 11.0: affine conic constraints, domains.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray, IntArray
from surefoot.errors import MissingExtra, SolverNotFound
from surefoot.solvers.backends.backend import Backend, Options
from surefoot.solvers.backends.program import ConeProgram, End, Outcome, dense

LICENCE_CODES = range(1000, 1030)
"""MOSEK's response codes that concern its licence."""
ENDS = {
    "optimal": End.SOLVED,
    "integer_optimal": End.SOLVED,
    "prim_infeas_cer": End.INFEASIBLE,
    "dual_infeas_cer": End.UNBOUNDED,
}
"""By the name of the solution's status."""
STOPS = {"trm_max_iterations": End.MAX_ITERATIONS, "trm_max_time": End.MAX_TIME}
"""By the name of the reason why it stopped."""


class Mosek(Backend):
    """Takes every cone, exactly. `own` are its parameters by name, MSK_DPAR_... and so on."""

    name = package = "mosek"
    takes_cones = True
    tol_words = tuple(f"MSK_DPAR_INTPNT_CO_TOL_{what}" for what in ("PFEAS", "DFEAS", "REL_GAP"))
    iterations_word, time_word = "MSK_IPAR_INTPNT_MAX_ITERATIONS", "MSK_DPAR_OPTIMIZER_MAX_TIME"

    def __init__(self, options: Options | None = None) -> None:
        try:
            super().__init__(options)
        except MissingExtra as error:
            raise SolverNotFound(
                "mosek is not installed, and no extra brings it; run: pip install mosek, and get a licence"
            ) from error

    def ready(self, program: ConeProgram) -> Any:
        """Return n, the objective, linear rows, and conic blocks (kind, rows, F, g): F x + g in the cone."""
        n, linear = program.q.size, program.zero + program.nonneg
        A = sp.csr_matrix(program.A)
        blocks, at = [], linear
        for kind, size, order in _cones(program):
            rows = at + order
            blocks.append((kind, size, -A[rows], program.b[rows]))
            at += size
        root = factor(dense(program.P))
        if root.size:  # columns: x, then t
            F = sp.block_diag([[[1.0]], root], format="csr")
            top, rest = F[:1], F[1:]
            F = sp.vstack([top, sp.csr_matrix((1, n + 1)), rest], format="csr")
            F = sp.hstack([F[:, 1:], F[:, :1]], format="csr")
            g = np.concatenate([[0.0, 1.0], np.zeros(len(root))])
            blocks.append(("rquadratic", len(root) + 2, F, g))
        return n, program.q, A[:linear], program.b[:linear], program.zero, blocks

    def _set_up(self, item: Any) -> Any:
        n, q, A, b, zero, blocks = item
        kinds, extra = self.module.boundkey, int(any(kind == "rquadratic" for kind, *_ in blocks))
        task = self.module.Task()
        task.appendvars(n + extra)
        for k in range(n + extra):
            task.putvarbound(k, kinds.fr, -np.inf, np.inf)
        task.putcslice(0, n + extra, np.append(q, np.ones(extra)))
        task.appendcons(len(b))
        entries = sp.coo_matrix(A)
        task.putaijlist(entries.row, entries.col, entries.data)
        for k, limit in enumerate(b):  # rows with an infinite limit never get here, see `ConeProgram.of`
            task.putconbound(k, kinds.fx if k < zero else kinds.up, limit if k < zero else -np.inf, limit)
        first = 0
        for kind, size, F, g in blocks:
            entries = sp.coo_matrix(F)
            task.appendafes(size)
            task.putafefentrylist(first + entries.row.astype(np.int64), entries.col, entries.data)
            task.putafegslice(first, first + size, g)
            domain = getattr(task, f"append{kind}conedomain")(size)
            task.appendaccseq(domain, first, None)
            first += size
        for name, value in self._words().items():
            task.putparam(name, repr(value))
        return n, task

    def _run(self, solver: Any, start: FloatArray | None) -> Any:
        n, task = solver
        try:
            stop = task.optimize()
        except self.module.Error as error:
            if int(error.errno) in LICENCE_CODES:
                line = " ".join(str(error.msg).split())
                raise SolverNotFound(f"mosek has no valid licence: {line}") from error
            return None
        return n, task, stop

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        if answer is None:
            return Outcome(None, End.FAILED)
        n, task, stop = answer
        which = self.module.soltype.itr
        if not task.solutiondef(which):
            return Outcome(None, STOPS.get(_word(stop), End.FAILED))
        end = ENDS.get(_word(task.getsolsta(which)), STOPS.get(_word(stop), End.FAILED))
        iterations = task.getintinf(self.module.iinfitem.intpnt_iter)
        return Outcome(np.asarray(task.getxx(which), dtype=np.float64)[:n], end, int(iterations))


def licensed() -> bool:
    """Tell whether MOSEK is installed and solves."""
    try:
        mosek = importlib.import_module("mosek")
    except ImportError:
        return False
    try:
        mosek.Task().optimize()
    except mosek.Error:
        return False
    return True


def _word(code: Any) -> str:
    """Return the last part of an enumeration's name."""
    return str(code).rpartition(".")[2]


def _cones(program: ConeProgram) -> list[tuple[str, int, IntArray]]:
    """Return kind, rows and their order for each cone.

    Ours of a symmetric matrix are its upper triangle by columns, MOSEK's the lower one by columns.
    """
    out = [("quadratic", k, np.arange(k)) for k in program.second_order]
    for side in program.semidefinite:
        row, column = np.tril_indices(side)
        by_columns = np.lexsort((row, column))
        i, j = row[by_columns], column[by_columns]
        out.append(("svecpsd", side * (side + 1) // 2, i * (i + 1) // 2 + j))
    return out


def factor(P: FloatArray) -> FloatArray:
    """Return R (r, n) with P = RᵀR for a positive semidefinite P (n, n) of rank r."""
    if not P.any():
        return np.zeros((0, len(P)))
    value, vector = np.linalg.eigh(P)
    kept = value > 1e-14 * value[-1]
    root: FloatArray = np.sqrt(value[kept])[:, None] * vector[:, kept].T
    return root
