"""QP solvers that qpsolvers drives as well as we could: OSQP, PIQP, quadprog and HiGHS.

ProxQP is not among them, for qpsolvers has no way to its `eps_primal_inf`; nor DAQP, whose bounds it hands
over as rows. Prepared calls and kept workspaces, which only benchmarks want, are in `benchmarks/prepared`.

References
----------
.. [1] S. Caron and others, "qpsolvers: quadratic programming solvers in Python", github.com/qpsolvers.
.. [2] B. Stellato and others, "OSQP: an operator splitting solver for quadratic programs", Mathematical
   Programming Computation 12, 2020.
.. [3] R. Schwan, Y. Jiang, D. Kuhn, C. N. Jones, "PIQP: a proximal interior-point quadratic programming
   solver", CDC 2023.
.. [4] D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic
   programs", Mathematical Programming 27, 1983 (quadprog).
.. [5] Q. Huangfu, J. A. J. Hall, "Parallelizing the dual revised simplex method", Mathematical Programming
   Computation 10, 2018 (HiGHS).
"""

from __future__ import annotations

import warnings
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp

from surefoot.base.errors import MissingExtra
from surefoot.contact.solvers.backends.backend import Backend, Options
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense

WORDS = {
    "primal infeasible": End.INFEASIBLE,
    "primal_infeasible": End.INFEASIBLE,
    "dual infeasible": End.UNBOUNDED,
    "dual_infeasible": End.UNBOUNDED,
    "inaccurate": End.ALMOST,
    "max": End.MAX_ITERATIONS,
    "time": End.MAX_TIME,
}
"""What a solver's own word for its status, in small letters, holds."""


class QpSolvers(Backend):
    """Takes linear rows, by `qpsolvers.solve_problem`; from nothing each time."""

    package = "qpsolvers"
    sparse: ClassVar[bool | None] = None
    """Whether it is given sparse matrices; None for what the options say."""
    fixed: ClassVar[dict[str, Any]] = {}
    """Settings by its own names that are always given."""

    def __init__(self, options: Options | None = None) -> None:
        super().__init__(options)
        if self.name not in self.module.available_solvers:
            raise MissingExtra(self.name, "qp")

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern and a `qpsolvers.Problem`."""
        E, e, C, low, high, lower, upper = program.two_sided(bounds=True)
        shape = sp.csc_matrix if (self.options.sparse if self.sparse is None else self.sparse) else dense
        two = np.isfinite(low)
        rows = sp.vstack([sp.csr_matrix(C), -sp.csr_matrix(C)[two]])
        limits = np.concatenate([high, -low[two]])
        return None, self.module.Problem(
            shape(program.P), program.q, *((shape(rows), limits) if limits.size else (None, None)),
            *((shape(E), e) if e.size else (None, None)), lower, upper,
        )  # fmt: skip

    def _run(self, solver: Any) -> Any:
        words = {**self.fixed, **self._words()}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # how it ended is in `end`
                return self.module.solve_problem(solver[1], self.name, **words)
        except (self.module.exceptions.QPError, ValueError, ArithmeticError):
            return None

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        if answer is None:
            return Outcome(None, End.FAILED)
        info = answer.extras.get("info")
        word = str(getattr(info, "status", "")).lower()
        known = (end for part, end in WORDS.items() if part in word)
        end = End.SOLVED if answer.found else next(known, self.otherwise)
        return Outcome(answer.x, end, int(getattr(info, "iter", 0)))

    otherwise: ClassVar[End] = End.FAILED
    """How it ended where it found nothing and does not say why."""


class Osqp(QpSolvers):
    """A splitting method (ADMM), sparse. Without polishing, which talks on stdout."""

    name = "osqp"
    sparse = True
    fixed: ClassVar[dict[str, Any]] = {"max_iter": 20_000, "polishing": False}
    tol_words, iterations_word, time_word = ("eps_abs", "eps_rel"), "max_iter", "time_limit"


class Piqp(QpSolvers):
    """A proximal interior-point method, dense or sparse."""

    name = "piqp"
    tol_words = ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel")
    iterations_word = "max_iter"


class Quadprog(QpSolvers):
    """A dual active-set method, dense; takes a P with a Cholesky factor and stops by no tolerance."""

    name = "quadprog"
    sparse, has_tol, otherwise = False, False, End.INFEASIBLE


class Highs(QpSolvers):
    """An active-set method, sparse. It regularises P by its default; see `own`."""

    name = "highs"
    sparse, has_tol = True, False

    def _words(self) -> dict[str, Any]:
        words = super()._words()
        if self.options.tol is not None:
            tol = max(self.options.tol, 1e-10)  # its own least
            words = {"primal_feasibility_tolerance": tol, "dual_feasibility_tolerance": tol} | words
        return words
