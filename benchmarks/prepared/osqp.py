"""OSQP: a splitting method (ADMM) for QPs.

References
----------
.. [1] B. Stellato and others, "OSQP: an operator splitting solver for quadratic programs", Mathematical
   Programming Computation 12, 2020.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray
from surefoot.contact.solvers.backends.backend import Backend, Options
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, pattern, upper_triangle

ENDS = {
    1: End.SOLVED, 2: End.ALMOST, 3: End.INFEASIBLE, 4: End.ALMOST_INFEASIBLE, 5: End.UNBOUNDED,
    6: End.UNBOUNDED, 7: End.MAX_ITERATIONS, 8: End.MAX_TIME,
}  # fmt: skip
ITERATIONS = 20_000


class PreparedOsqp(Backend):
    """Takes linear rows; keeps its workspace and starts warm. For infeasible programs, look at `end`."""

    name = package = "osqp"
    keeps_workspace = warm_starts = True
    tol_words, iterations_word, time_word = ("eps_abs", "eps_rel"), "max_iter", "time_limit"

    def __init__(self, options: Options | None = None) -> None:
        super().__init__(options)
        self._rows: dict[Any, FloatArray] = {}

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and P, q, rows and limits as `osqp.OSQP.setup` wants them."""
        E, e, C, low, high, *_ = program.two_sided()
        P, rows = upper_triangle(program.P), sp.vstack([E, C], format="csc")
        return (
            pattern(P, rows), P, program.q, rows, np.concatenate([e, low]), np.concatenate([e, high])
        )  # fmt: skip

    def _set_up(self, item: Any) -> Any:
        _, P, q, rows, low, high = item
        given, solver = self.options, self.module.OSQP()
        # no polishing: where no constraint is active OSQP says so on stdout, whatever verbose is
        words: dict[str, Any] = {"verbose": False, "polishing": False, "warm_starting": given.warm}
        words["max_iter"] = ITERATIONS
        # on copies: its updates write into the matrices that it was set up with
        solver.setup(P.copy(), q, rows.copy(), low, high, **{**words, **self._words()})
        self._rows[item[0]] = rows.data
        return solver

    def _change(self, item: Any) -> Any:
        kept, rows = self._rows[item[0]], item[3].data
        return item, kept if np.array_equal(kept, rows) else rows

    def _update(self, solver: Any, change: Any) -> None:
        (key, P, q, _, low, high), rows = change
        if rows is self._rows[key]:
            solver.update(Px=P.data, q=q, l=low, u=high)
        else:
            solver.update(Px=P.data, Ax=rows, q=q, l=low, u=high)
            self._rows[key] = rows

    def _run(self, solver: Any) -> Any:
        return solver.solve(raise_error=False)

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        info = answer.info
        return Outcome(np.asarray(answer.x), ENDS.get(info.status_val, End.FAILED), info.iter)
