"""HiGHS: an active-set method for QPs, through qpsolvers, which knows its long-winded interface.

References
----------
.. [1] Q. Huangfu, J. A. J. Hall, "Parallelizing the dual revised simplex method", Mathematical Programming
   Computation 10, 2018.
"""

from __future__ import annotations

import warnings
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra
from surefoot.solvers.backends.backend import Backend, Options
from surefoot.solvers.backends.program import ConeProgram, End, Outcome


class Highs(Backend):
    """Takes linear rows, sparse. It regularises P by its default; see `own`."""

    name, package = "highs", "qpsolvers"
    has_tol = False
    contact_words: ClassVar[dict[str, float]] = {"qp_regularization_value": 1e-11}  # the default would show

    def __init__(self, options: Options | None = None) -> None:
        super().__init__(options)
        if "highs" not in self.module.available_solvers:
            raise MissingExtra("highspy", "qp")

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern and a `qpsolvers.Problem`."""
        E, e, C, low, high, lower, upper = program.two_sided(bounds=True)
        C, E = sp.csc_matrix(C), sp.csc_matrix(E)
        two = np.isfinite(low)
        rows = sp.vstack([C, -C[two]], format="csc")
        limits = np.concatenate([high, -low[two]])
        return None, self.module.Problem(
            sp.csc_matrix(program.P), program.q, *((rows, limits) if limits.size else (None, None)),
            *((E, e) if e.size else (None, None)), lower, upper,
        )  # fmt: skip

    def _set_up(self, item: Any) -> Any:
        return item[1]

    def _run(self, solver: Any, start: FloatArray | None) -> Any:
        words: dict[str, Any] = {}
        if self.options.tol is not None:
            tol = max(self.options.tol, 1e-10)  # its own least
            words = {"primal_feasibility_tolerance": tol, "dual_feasibility_tolerance": tol}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # how it ended is in `end`
                return self.module.solve_problem(solver, "highs", **words, **self.options.own)
        except (self.module.exceptions.QPError, ValueError, ArithmeticError):
            return None

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        if answer is None:
            return Outcome(None, End.FAILED)
        return Outcome(answer.x, End.SOLVED if answer.found else End.FAILED)
