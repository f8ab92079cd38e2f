"""PIQP: a proximal interior-point method for QPs.

References
----------
.. [1] R. Schwan, Y. Jiang, D. Kuhn, C. N. Jones, "PIQP: a proximal interior-point quadratic programming
   solver", CDC 2023.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.contact.solvers.backends.backend import Backend
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense, pattern

ENDS = {
    "PIQP_SOLVED": End.SOLVED,
    "PIQP_MAX_ITER_REACHED": End.MAX_ITERATIONS,
    "PIQP_PRIMAL_INFEASIBLE": End.INFEASIBLE,
    "PIQP_DUAL_INFEASIBLE": End.UNBOUNDED,
}


class PreparedPiqp(Backend):
    """Takes linear rows, dense or sparse; keeps its workspace, but has no use for an old answer."""

    name = package = "piqp"
    keeps_workspace = True
    tol_words = ("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel")
    iterations_word = "max_iter"

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and P, c, A, b, G, limits and bounds as its `setup` wants them."""
        E, e, C, low, high, lower, upper = program.two_sided(bounds=True)
        shape = sp.csc_matrix if self.options.sparse else (lambda m: np.asfortranarray(dense(m)))
        P, E, C = shape(program.P), shape(E), shape(C)
        return pattern(P, E, C), P, program.q, E, e, C, low, high, lower, upper

    def _set_up(self, item: Any) -> Any:
        solver = self.module.SparseSolver() if self.options.sparse else self.module.DenseSolver()
        self._set(solver.settings)
        solver.setup(*item[1:])
        return solver

    def _update(self, solver: Any, change: Any) -> None:
        solver.update(*change[1:])

    def _run(self, solver: Any) -> Any:
        return solver.solve(), solver.result

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        status, found = answer
        end = ENDS.get(getattr(status, "name", str(status)), End.FAILED)
        return Outcome(np.array(found.x), end, found.info.iter)
