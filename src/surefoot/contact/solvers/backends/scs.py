"""SCS: a splitting method (ADMM) on the homogeneous embedding.

References
----------
.. [1] B. O'Donoghue, "Operator splitting for a homogeneous embedding of the linear complementarity problem",
   SIAM J. Optimization 31(3), 2021.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.contact.solvers.backends.backend import Backend
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, pattern, upper_triangle

ENDS = {1: End.SOLVED, 2: End.ALMOST, -2: End.INFEASIBLE, -7: End.ALMOST_INFEASIBLE, -1: End.UNBOUNDED}
ITERATIONS = 20_000


class Scs(Backend):
    """Takes second-order cones; made anew for each program, it starts at the last answer if wanted."""

    name = package = "scs"
    takes_cones = keeps_workspace = warm_starts = True
    tol_words, iterations_word, time_word = ("eps_abs", "eps_rel"), "max_iters", "time_limit_secs"

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and data and cones as `scs.SCS` wants them."""
        P, A = upper_triangle(program.P), sp.csc_matrix(program.A)
        data = {"P": P, "A": A, "b": program.b, "c": program.q}
        cone = {"z": program.zero, "l": program.nonneg, "q": list(program.second_order)}
        return pattern(P, A), data, cone

    def _set_up(self, item: Any) -> Any:
        words = {"verbose": False, "max_iters": ITERATIONS, **self._words()}
        return {"made": self.module.SCS(*item[1:], **words), "last": None}

    def _update(self, solver: Any, change: Any) -> None:
        solver["made"] = self._set_up(change)["made"]

    def _run(self, solver: Any) -> Any:
        old = solver["last"] if self.options.warm else None
        words = {} if old is None else {"warm_start": True, **{name: old[name] for name in ("x", "y", "s")}}
        found = solver["last"] = solver["made"].solve(**words)
        return found

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        info = answer["info"]
        end = ENDS.get(info["status_val"], End.FAILED)
        if end is End.ALMOST and info["iter"] >= (self.options.max_iterations or ITERATIONS):
            end = End.MAX_ITERATIONS
        return Outcome(np.asarray(answer["x"]), end, info["iter"], np.asarray(answer["y"]))
