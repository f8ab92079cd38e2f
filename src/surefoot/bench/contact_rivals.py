"""Rivals of the contact solvers on the same matrices: Pinocchio's ADMM and PGS, and Siconos."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact import ContactProblem
from surefoot.errors import MissingExtra

Call = Callable[[], FloatArray]


def _pinocchio_parts(problem: ContactProblem) -> tuple[Any, Any, Any, Any]:
    """Return Pinocchio, its dense Delassus operator, and constraint models and data that carry only mu."""
    try:
        import pinocchio
    except ImportError as error:
        raise MissingExtra("pin", "robot") from error
    model = pinocchio.Model()
    place = pinocchio.SE3.Identity()
    model.addJoint(0, pinocchio.JointModelFreeFlyer(), place, "body")
    models = pinocchio.StdVec_ConstraintModel()
    datas = pinocchio.StdVec_ConstraintData()
    for mu in problem.mu:
        contact = pinocchio.PointContactConstraintModel(model, 0, place, 1, place)
        contact.setFriction(float(mu))
        models.append(pinocchio.ConstraintModel(contact))
    for item in models:
        datas.append(item.createData())
    return pinocchio, pinocchio.DelassusOperatorDense(problem.G), models, datas


def pinocchio_admm(problem: ContactProblem, tol: float, iterations: int = 20_000, **options: Any) -> Call:
    """Return a call that solves the problem by Pinocchio's ADMM from a cold start: (n, 3) impulses."""
    pinocchio, delassus, models, datas = _pinocchio_parts(problem)
    settings = pinocchio.ADMMSolverSettings()
    return _call(
        pinocchio.ADMMConstraintSolver(problem.g.size), settings, pinocchio.ADMMSolverResult,
        (delassus, problem.g, models, datas), tol, iterations, options,
    )  # fmt: skip


def pinocchio_pgs(problem: ContactProblem, tol: float, iterations: int = 100_000, **options: Any) -> Call:
    """Return a call that solves the problem by Pinocchio's projected Gauss-Seidel from a cold start."""
    pinocchio, delassus, models, datas = _pinocchio_parts(problem)
    return _call(
        pinocchio.PGSConstraintSolver(problem.g.size), pinocchio.PGSSolverSettings(), pinocchio.PGSSolverResult,
        (delassus, problem.g, models, datas), tol, iterations, options,
    )  # fmt: skip


def _call(
    solver: Any, settings: Any, make: Any, parts: tuple[Any, ...], tol: float, iterations: int, options: Any
) -> Call:
    """Return the timed part of a run: a new result object and one solve."""
    settings.max_iterations = iterations
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tol
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
    for name, value in options.items():
        setattr(settings, name, value)

    def solve() -> FloatArray:
        result = make()
        solver.reset()
        solver.solve(*parts, settings, result)
        call_result.append(result)
        return np.asarray(result.retrieveConstraintImpulses()).reshape(-1, 3)
    call_result: list[Any] = []
    solve.results = call_result
    return solve
