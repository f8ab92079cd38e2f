"""quadprog: Goldfarb and Idnani's dual active-set method for dense, strictly convex QPs.

References
----------
.. [1] D. Goldfarb, A. Idnani, "A numerically stable dual method for solving strictly convex quadratic
   programs", Mathematical Programming 27, 1983.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.contact.solvers.backends.backend import Backend
from surefoot.contact.solvers.backends.program import ConeProgram, End, Outcome, dense


class PreparedQuadprog(Backend):
    """Takes linear rows and a P with a Cholesky factor; stops by no tolerance."""

    name = package = "quadprog"
    has_tol = False

    def ready(self, program: ConeProgram) -> Any:
        """Return the pattern, and G, a, C, b and the number of equations as `solve_qp` wants them."""
        if program.second_order:
            program.two_sided()  # says so
        C = np.ascontiguousarray(-dense(program.A).T)  # its rows are Cᵀx >= b, equations first
        return None, dense(program.P), -program.q, C, -program.b, program.zero

    def _run(self, solver: Any) -> Any:
        _, P, a, C, b, equations = solver
        try:
            return self.module.solve_qp(P, a, C, b, equations)
        except ValueError as error:
            return error

    def read(self, answer: Any) -> Outcome:
        """Return its answer in our words."""
        if isinstance(answer, ValueError):
            return Outcome(None, End.INFEASIBLE if "inconsistent" in str(answer) else End.FAILED)
        x, _, _, (steps, _), *_ = answer
        return Outcome(x, End.SOLVED, int(steps))
