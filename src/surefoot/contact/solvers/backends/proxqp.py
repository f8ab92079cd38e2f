"""ProxQP: a proximal augmented Lagrangian for QPs.

References
----------
.. [1] A. Bambade, S. El-Kazdadi, A. Taylor, J. Carpentier, "ProxQP: yet another quadratic programming solver
   for robotics and beyond", RSS 2022.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.contact.solvers.backends.backend import Backend, Options
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense, pattern

ENDS = {
    "PROXQP_SOLVED": End.SOLVED,
    "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE": End.ALMOST,
    "PROXQP_MAX_ITER_REACHED": End.MAX_ITERATIONS,
    "PROXQP_PRIMAL_INFEASIBLE": End.INFEASIBLE,
    "PROXQP_DUAL_INFEASIBLE": End.UNBOUNDED,
}
FAR = 1e20
"""Its infinity."""
DOUBT = 10.0
"""Its tolerances of infeasibility over its tolerance. Left at their 1e-4 they strike before a tight tolerance
is reached: 7 of 100 feasible whole-body programs were called infeasible. At 1 it proves nothing any more."""


class ProxQp(Backend):
    """Takes linear rows, dense or sparse; keeps its workspace and starts warm."""

    name, package = "proxqp", "proxsuite"
    keeps_workspace = warm_starts = True
    tol_words, iterations_word = ("eps_abs",), "max_iter"

    def __init__(self, options: Options | None = None) -> None:
        super().__init__(options)
        proxqp = self.module.proxqp
        guess = proxqp.InitialGuess
        self._qp = (proxqp.sparse if self.options.sparse else proxqp.dense).QP
        self._cold = guess.EQUALITY_CONSTRAINED_INITIAL_GUESS
        self._again = guess.WARM_START_WITH_PREVIOUS_RESULT if self.options.warm else self._cold
        self._ends = {getattr(proxqp.QPSolverOutput, name, None): end for name, end in ENDS.items()}

    def _words(self) -> dict[str, Any]:
        tol = self.options.tol
        tests = {} if tol is None else dict.fromkeys(("eps_primal_inf", "eps_dual_inf"), DOUBT * tol)
        return {**tests, **super()._words()}

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and H, g, A, b, C, l, u as its `init` wants them."""
        E, e, C, low, high, *_ = program.two_sided()
        shape = sp.csc_matrix if self.options.sparse else (lambda m: np.asfortranarray(dense(m)))
        P, E, C = shape(program.P), shape(E), shape(C)
        return pattern(P, E, C), P, program.q, E, e, C, np.maximum(low, -FAR), np.minimum(high, FAR)

    def _set_up(self, item: Any) -> Any:
        _, P, q, E, e, C, low, high = item
        qp = self._qp(q.size, e.size, low.size)
        if self.options.tol is not None:
            qp.settings.eps_rel = 0.0
        self._set(qp.settings)
        qp.init(P, q, E, e, C, low, high)
        qp.settings.initial_guess = self._cold  # nothing to go by
        return qp

    def _change(self, item: Any) -> Any:
        _, P, q, E, e, C, low, high = item
        return {"H": P, "g": q, "A": E, "b": e, "C": C, "l": low, "u": high}

    def _update(self, solver: Any, change: Any) -> None:
        solver.update(**change)

    def _run(self, solver: Any) -> Any:
        solver.solve()
        solver.settings.initial_guess = self._again
        return solver.results

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        end = self._ends.get(answer.info.status, End.FAILED)
        return Outcome(np.array(answer.x), end, answer.info.iter)
