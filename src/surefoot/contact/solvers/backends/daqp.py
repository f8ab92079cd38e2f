"""DAQP: a dual active-set method for dense QPs.

References
----------
.. [1] D. Arnström, A. Bemporad, D. Axehill, "A dual active-set solver for embedded quadratic programming
   using recursive LDLᵀ updates", IEEE TAC 67(8), 2022.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.contact.solvers.backends.backend import Backend, Call
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense

ENDS = {1: End.SOLVED, 2: End.ALMOST, -1: End.INFEASIBLE, -3: End.UNBOUNDED, -4: End.MAX_ITERATIONS}
FAR = 1e30
"""Its infinity."""
EQUATION = 5
"""Its mark of a row that always holds."""


class Daqp(Backend):
    """Takes linear rows, dense; keeps its workspace and with it the active set."""

    name = package = "daqp"
    keeps_workspace = warm_starts = True
    tol_words, iterations_word, time_word = ("primal_tol", "dual_tol"), "iter_limit", "time_limit"

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and H, f, A, limits and kinds of rows as `daqp.solve` wants them."""
        E, e, C, low, high, lower, upper = program.two_sided(bounds=True)
        C = dense(C)
        bounded = np.flatnonzero(np.isfinite(lower) | np.isfinite(upper))
        first = int(bounded[-1]) + 1 if bounded.size else 0  # its bounds are of the first entries of x
        lower, upper = lower[:first], upper[:first]
        rows = np.ascontiguousarray(np.vstack([C, dense(E)]))
        most = np.clip(np.concatenate([upper, high, e]), -FAR, FAR)
        least = np.clip(np.concatenate([lower, low, e]), -FAR, FAR)
        kinds = np.zeros(most.size, dtype=np.int32)
        kinds[most.size - e.size :] = EQUATION
        return (rows.shape, most.size), dense(program.P), program.q, rows, most, least, kinds

    def call(self, item: Any) -> Call:
        """Return the call, see `Backend.call`; without a workspace the library's shortest."""
        if self.options.keep and self.options.warm:  # a kept one starts at its last active set
            return super().call(item)
        solve, data, words = self.module.solve, item[1:], self._words()

        return lambda: solve(*data, **words)

    def _set_up(self, item: Any) -> Any:
        solver = self.module.Model()
        solver.setup(*item[1:])
        if words := self._words():
            solver.settings = words
        return solver

    def _update(self, solver: Any, change: Any) -> None:
        solver.update(*change[1:])

    def _run(self, solver: Any) -> Any:
        return solver.solve()

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        x, _, flag, info = answer
        return Outcome(x if flag > 0 else None, ENDS.get(flag, End.FAILED), info["iterations"])
