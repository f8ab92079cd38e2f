"""ECOS: an interior-point method on second-order cones; the quadratic objective becomes one more cone.

References
----------
.. [1] A. Domahidi, E. Chu, S. Boyd, "ECOS: an SOCP solver for embedded systems", ECC 2013.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.contact.solvers.backends.backend import Backend
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense

ENDS = {0: End.SOLVED, 10: End.ALMOST, 1: End.INFEASIBLE, 2: End.UNBOUNDED, -1: End.MAX_ITERATIONS}


class Ecos(Backend):
    """Takes second-order cones and a P with a Cholesky factor, or none."""

    name = package = "ecos"
    takes_cones = True
    tol_words, iterations_word = ("abstol", "reltol", "feastol"), "max_iters"

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, n, and what `ecos.solve` wants: ½ xᵀP x + qᵀx becomes a bound t on its root."""
        n, z = program.q.size, program.zero
        A, P = dense(program.A), dense(program.P)
        E: Any = sp.csc_matrix(A[:z]) if z else None
        e = program.b[:z] if z else None
        rows, right, sizes = A[z:], program.b[z:], [*program.second_order]
        objective = program.q
        if P.any():  # min t with ||R x + R^-T q|| <= t, where P = RᵀR
            root = np.linalg.cholesky(P).T
            objective = np.append(np.zeros(n), 1.0)
            top = np.zeros((n + 1, n + 1))
            top[0, n], top[1:, :n] = -1.0, -root
            rows = np.vstack([np.hstack([rows, np.zeros((len(rows), 1))]), top])
            right = np.concatenate([right, [0.0], np.linalg.solve(root.T, program.q)])
            sizes.append(n + 1)
            E = sp.hstack([E, sp.csc_matrix((z, 1))], format="csc") if z else None
        return None, n, objective, sp.csc_matrix(rows), right, {"l": program.nonneg, "q": sizes}, E, e

    def _run(self, solver: Any) -> Any:
        _, n, *data = solver
        return n, self.module.solve(*data, **{"verbose": False, **self._words()})

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        n, found = answer
        info = found["info"]
        return Outcome(np.asarray(found["x"])[:n], ENDS.get(info["exitFlag"], End.FAILED), info["iter"])
