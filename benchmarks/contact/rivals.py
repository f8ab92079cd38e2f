"""Pinocchio's contact solvers on the same matrices: ADMM and PGS, each in all settings that help it.

Each rival stops by a test of its own, so each is tried with tightening tolerances until our judge is
content, and timed with the loosest one that satisfies it; see `judge.coarsest`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from benchmarks.problems.judge import coarsest, judge
from surefoot.base.arrays import FloatArray
from surefoot.base.libraries import import_pinocchio
from surefoot.contact.problem import ContactProblem

BUDGET = 8.0
"""Seconds after which a rival that has not reached the residual gets no tighter tolerance."""
FEW, ITERATIONS, ITERATIONS_MANY = 40, 20_000, 3000
"""Contacts up to which a rival has so many iterations, and how many it has above."""


@dataclass(frozen=True)
class Setting:
    """One way to run Pinocchio's solvers.

    Attributes
    ----------
    method
        "admm" or "pgs".
    rule
        Of ADMM's penalty: "OSQP" or "SPECTRAL".
    anderson
        Capacity of ADMM's Anderson acceleration, 0 for none.
    relaxation
        Over-relaxation of PGS.
    sparse
        Whether ADMM factorises a sparse Delassus matrix.
    """

    method: Literal["admm", "pgs"]
    rule: Literal["OSQP", "SPECTRAL"] = "OSQP"
    anderson: int = 0
    relaxation: float = 1.0
    sparse: bool = False


DENSE: dict[str, Setting] = {
    "pinocchio admm": Setting("admm"),
    "pinocchio admm spectral": Setting("admm", "SPECTRAL"),
    "pinocchio admm anderson": Setting("admm", anderson=5),
    "pinocchio admm spectral anderson": Setting("admm", "SPECTRAL", 5),
    "pinocchio pgs": Setting("pgs"),
    "pinocchio pgs 1.3": Setting("pgs", relaxation=1.3),
    "pinocchio pgs 1.6": Setting("pgs", relaxation=1.6),
}
SPARSE: dict[str, Setting] = {
    "pinocchio admm sparse": Setting("admm", sparse=True),
    "pinocchio admm spectral sparse": Setting("admm", "SPECTRAL", sparse=True),
    "pinocchio admm anderson sparse": Setting("admm", anderson=5, sparse=True),
    "pinocchio admm spectral anderson sparse": Setting("admm", "SPECTRAL", 5, sparse=True),
}
"""In place of ADMM's dense ones for problems of more than `FEW` contacts whose matrix is sparse."""
FULL = 0.25
"""Share of entries that are not zero above which a matrix is taken as dense."""


def settings(problem: ContactProblem) -> dict[str, Setting]:
    """Return the settings that are run on a problem."""
    if problem.contacts <= FEW or problem.blocks.density > FULL:
        return DENSE
    return {**SPARSE, **{name: s for name, s in DENSE.items() if s.method == "pgs"}}


class PinocchioCall:
    """One problem set up for one of Pinocchio's solvers; a call solves it from a cold start.

    The constraint models (which carry only the friction coefficient), the solver and its settings are made
    beforehand, as a simulator would. `ready` then times the solve on a Delassus operator made beforehand
    too, and `fresh` making that operator from a new matrix and the solve. ADMM sets the operator's damping
    itself at the start of every solve, so one operator serves any number of them.
    """

    def __init__(self, problem: ContactProblem, setting: Setting, tol: float, iterations: int) -> None:
        pinocchio = import_pinocchio()
        model, place = pinocchio.Model(), pinocchio.SE3.Identity()
        model.addJoint(0, pinocchio.JointModelFreeFlyer(), place, "body")
        self.models, self.datas = pinocchio.StdVec_ConstraintModel(), pinocchio.StdVec_ConstraintData()
        for mu in problem.mu:
            contact = pinocchio.PointContactConstraintModel(model, 0, place, 1, place)
            contact.setFriction(float(mu))
            self.models.append(pinocchio.ConstraintModel(contact))
        for item in self.models:
            self.datas.append(item.createData())
        self.operator = (
            pinocchio.DelassusOperatorSparse if setting.sparse else pinocchio.DelassusOperatorDense
        )
        name = setting.method.upper()
        self.solver = getattr(pinocchio, f"{name}ConstraintSolver")(problem.g.size)
        options = getattr(pinocchio, f"{name}SolverSettings")()
        self.make = getattr(pinocchio, f"{name}SolverResult")
        if setting.method == "admm":
            options.admm_update_rule = getattr(pinocchio.ADMMUpdateRule, setting.rule)
            options.anderson_capacity = setting.anderson
        else:
            options.over_relaxation = setting.relaxation
        options.max_iterations = iterations
        options.absolute_feasibility_tol = options.absolute_complementarity_tol = tol
        options.relative_feasibility_tol = options.relative_complementarity_tol = 0.0
        options.solve_ncp = problem.law == "coulomb"
        self.settings, self.tol = options, tol
        self.delassus: Any = self.operator(matrix(problem, setting))
        self.g = problem.g

    def ready(self, _turn: int = 0) -> FloatArray:
        """Solve the problem with everything made beforehand, and return the (n, 3) impulses."""
        return self._solve(self.delassus, self.g)

    def fresh(self, item: tuple[Any, FloatArray]) -> FloatArray:
        """Set up a new matrix (in the setting's format) and free velocity, solve, return the impulses."""
        return self._solve(self.operator(item[0]), item[1])

    def _solve(self, delassus: Any, g: FloatArray) -> FloatArray:
        result = self.make()
        self.solver.reset()
        self.solver.solve(delassus, g, self.models, self.datas, self.settings, result)
        return np.asarray(result.retrieveConstraintImpulses()).reshape(-1, 3)


def matrix(problem: ContactProblem, setting: Setting) -> Any:
    """Return G in the format of a setting."""
    return sp.csc_matrix(problem.operator) if setting.sparse else problem.G


def best_call(
    problem: ContactProblem, setting: Setting, tol: float, copies: Sequence[ContactProblem] = ()
) -> tuple[PinocchioCall | None, float]:
    """Return the loosest call that satisfies our judge on the problem and its copies, and its residual.

    None and the least residual found, if none does within `BUDGET` (a started solve is finished).
    """
    scale = float(np.abs(problem.g).max(initial=0.0)) or 1.0  # its tolerances are absolute velocities
    iterations = ITERATIONS if problem.contacts <= FEW else ITERATIONS_MANY
    formats = [(p, (matrix(p, setting), p.g)) for p in copies]
    least = [float("inf")]
    stop = time.perf_counter() + BUDGET

    def attempt(step: float) -> tuple[PinocchioCall, float] | None:
        call = PinocchioCall(problem, setting, tol * step * scale, iterations)
        gap = judge(problem, call.ready())
        if gap <= tol:
            gap = max([gap, *(judge(p, call.fresh(item)) for p, item in formats)])
        least[0] = min(least[0], gap)
        return (call, gap) if gap <= tol else None

    found = coarsest(attempt, lambda: time.perf_counter() < stop)
    return (None, least[0]) if found is None else found
