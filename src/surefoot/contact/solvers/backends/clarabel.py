"""Clarabel: an interior-point method for quadratic objectives over symmetric cones.

References
----------
.. [1] P. Goulart, Y. Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives",
   2024.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.contact.solvers.backends.backend import Backend, Options
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, pattern, upper_triangle

ENDS = {
    "Solved": End.SOLVED,
    "AlmostSolved": End.ALMOST,
    "PrimalInfeasible": End.INFEASIBLE,
    "AlmostPrimalInfeasible": End.ALMOST_INFEASIBLE,
    "DualInfeasible": End.UNBOUNDED,
    "AlmostDualInfeasible": End.UNBOUNDED,
    "MaxIterations": End.MAX_ITERATIONS,
    "MaxTime": End.MAX_TIME,
}


class Clarabel(Backend):
    """Takes second-order cones; keeps its workspace, but has no use for an old answer."""

    name = package = "clarabel"
    takes_cones = keeps_workspace = True
    tol_words = ("tol_gap_abs", "tol_gap_rel", "tol_feas")
    iterations_word, time_word = "max_iter", "time_limit"

    def __init__(self, options: Options | None = None) -> None:
        super().__init__(options)
        settings = self._settings = self.module.DefaultSettings()
        settings.verbose = False
        settings.presolve_enable = False  # it would forbid updates
        self._set(settings)

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern and what `clarabel.DefaultSolver` wants."""
        kinds = self.module
        cones = [kinds.ZeroConeT(program.zero)] if program.zero else []
        cones += [kinds.NonnegativeConeT(program.nonneg)] if program.nonneg else []
        cones += [kinds.SecondOrderConeT(k) for k in program.second_order]
        P, A = upper_triangle(program.P), sp.csc_matrix(program.A)
        return pattern(P, A), P, program.q, A, program.b, cones

    def _set_up(self, item: Any) -> Any:
        return self.module.DefaultSolver(*item[1:], self._settings)

    def _update(self, solver: Any, change: Any) -> None:
        _, P, q, A, b, _ = change
        solver.update(P=P.data, q=q, A=A.data, b=b)

    def _run(self, solver: Any) -> Any:
        return solver.solve()

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        end = ENDS.get(str(answer.status), End.FAILED)
        return Outcome(np.asarray(answer.x), end, answer.iterations, np.asarray(answer.z))
