"""Our solvers as callables of the contact benchmark: on one ready problem, and on a new matrix each call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solvers.compiled import COMPILED_CONTACTS
from surefoot.contact.solvers.contact_solver import ContactSolver
from surefoot.contact.solvers.solver import solve

CONTACT_SOLVER = "contact solver"
"""Name of the real-time path in the tables."""
MAX_TIME = 10.0
"""Bound on one solve [s]."""
Call = Callable[[int], FloatArray]
Item = tuple[Any, FloatArray]
"""A matrix and a free velocity."""


def our_calls(
    problem: ContactProblem, copies: Sequence[ContactProblem], solvers: Sequence[str], tol: float
) -> dict[str, tuple[Call, Call]]:
    """Return, by solver, its call on the problem and its call on a copy's raw arrays; both give forces.

    The second takes the number of its turn, and goes round the copies.
    """
    raw = [(matrix_of(p), p.g) for p in copies]
    own = [(matrix_of(problem), problem.g)]
    out = {name: _by_solve(problem, raw, name, tol) for name in solvers}
    path = real_time_path(problem, tol) if "auto" in solvers else None
    if path is not None:
        out[CONTACT_SOLVER] = in_turn(path, own), in_turn(path, raw)
    return out


def matrix_of(problem: ContactProblem) -> Any:
    """Return G as a user has it: an array, or compressed rows where many contacts leave most of it empty."""
    if problem.contacts <= COMPILED_CONTACTS or np.count_nonzero(problem.G) > 0.25 * problem.G.size:
        return problem.G
    return sp.csr_matrix(problem.G)


def real_time_path(problem: ContactProblem, tol: float) -> Callable[[Item], FloatArray] | None:
    """Return `ContactSolver` as a function of raw G and g, from a cold start; None above its contacts."""
    if problem.contacts > COMPILED_CONTACTS:
        return None
    solver = ContactSolver(  # G already holds the compliance
        problem.contacts, problem.mu, problem.law, _lower_bounds(problem), problem.normal_max,
        facets=problem.facets, fit=problem.fit, bilateral=problem.bilateral, tol=tol, warm_start=False,
    )  # fmt: skip

    def forces(item: Item) -> FloatArray:
        return np.asarray(solver.solve(*item).forces)

    return forces


def _lower_bounds(problem: ContactProblem) -> FloatArray:
    """Return the lower normal bounds as they were given: a bilateral contact's read -inf."""
    if problem.bilateral is None:
        return np.asarray(problem.normal_min)
    return np.asarray(np.where(problem.bilateral, 0.0, problem.normal_min))


def in_turn(function: Callable[[Item], FloatArray], items: Sequence[Item]) -> Call:
    """Return a call that takes the number of its turn and goes round the items."""
    count = len(items)
    return lambda k: function(items[k % count])


def _by_solve(problem: ContactProblem, raw: Sequence[Item], name: str, tol: float) -> tuple[Call, Call]:
    """Return the calls of `solve`, the second with a new `ContactProblem` each."""
    low = _lower_bounds(problem)
    mu, high, law, facets, fit, mask = (
        problem.mu, problem.normal_max, problem.law, problem.facets, problem.fit, problem.bilateral
    )  # fmt: skip

    def ready(_: int) -> FloatArray:
        return solve(problem, name, tol, max_time=MAX_TIME).forces

    def fresh(item: Item) -> FloatArray:
        new = ContactProblem(*item, mu, low, high, law, facets, fit, bilateral=mask)
        return solve(new, name, tol, max_time=MAX_TIME).forces

    return ready, in_turn(fresh, raw)
