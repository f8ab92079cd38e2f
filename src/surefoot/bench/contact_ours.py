"""Our solvers as callables of the contact benchmark: on one ready problem, and on a new matrix each call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

import surefoot
from surefoot.arrays import FloatArray
from surefoot.contact import ContactProblem
from surefoot.contact.problem import COMPILED_CONTACTS
from surefoot.solvers import solve

CONTACT_SOLVER = "contact solver"
"""Name of the real-time path in the tables."""
Call = Callable[[int], FloatArray]


def our_calls(
    problem: ContactProblem, copies: Sequence[ContactProblem], solvers: Sequence[str], tol: float,
    max_time: float,
) -> dict[str, tuple[Call, Call]]:  # fmt: skip
    """Return, by solver, its call on the problem and its call on a copy's raw arrays; both give forces.

    The second takes the number of its turn, and goes round the copies.
    """
    raw = [(matrix_of(p), p.g) for p in copies]
    own = [(matrix_of(problem), problem.g)]
    out = {name: _by_solve(problem, raw, name, tol, max_time) for name in solvers}
    path = real_time_path(problem, tol) if "auto" in solvers else None
    if path is not None:
        out[CONTACT_SOLVER] = _in_turn(path, own), _in_turn(path, raw)
    return out


def matrix_of(problem: ContactProblem) -> Any:
    """Return G as a user has it: an array, or compressed rows where many contacts leave most of it empty."""
    if problem.contacts <= COMPILED_CONTACTS or np.count_nonzero(problem.G) > 0.25 * problem.G.size:
        return problem.G
    return sp.csr_matrix(problem.G)


def real_time_path(problem: ContactProblem, tol: float) -> Callable[[Any, FloatArray], FloatArray] | None:
    """Return `ContactSolver` as a function of raw G and g, from a cold start; None if it is not for these.

    G must already hold the problem's compliance, as `ContactProblem.G` does.
    """
    maker = getattr(surefoot, "ContactSolver", None)
    if maker is None or problem.contacts > COMPILED_CONTACTS:
        return None
    low = (
        problem.normal_min
        if problem.bilateral is None
        else np.where(problem.bilateral, 0.0, problem.normal_min)
    )
    solver = maker(
        problem.contacts, problem.mu, law=problem.law, normal_min=low, normal_max=problem.normal_max,
        facets=problem.facets, bilateral=problem.bilateral, tol=tol,
    )  # fmt: skip

    def forces(G: Any, g: FloatArray) -> FloatArray:
        solver.reset()
        return np.asarray(solver.solve(G, g).forces)

    return forces


def _in_turn(
    function: Callable[[Any, FloatArray], FloatArray], items: Sequence[tuple[Any, FloatArray]]
) -> Call:
    """Return a call that goes round the items."""
    count = len(items)
    return lambda k: function(*items[k % count])


def _by_solve(
    problem: ContactProblem, raw: Sequence[tuple[Any, FloatArray]], name: str, tol: float, max_time: float
) -> tuple[Call, Call]:
    """Return the calls of `solve`, the second with a new `ContactProblem` each."""
    low = (
        problem.normal_min
        if problem.bilateral is None
        else np.where(problem.bilateral, 0.0, problem.normal_min)
    )
    mu, high, law, facets, fit, mask = (
        problem.mu, problem.normal_max, problem.law, problem.facets, problem.fit, problem.bilateral
    )  # fmt: skip

    def ready(_: int) -> FloatArray:
        return solve(problem, name, tol, max_time=max_time).forces

    def fresh(G: Any, g: FloatArray) -> FloatArray:
        new = ContactProblem(G, g, mu, low, high, law, facets, fit, bilateral=mask)
        return solve(new, name, tol, max_time=max_time).forces

    return ready, _in_turn(fresh, raw)
