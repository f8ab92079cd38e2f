"""Outside solvers behind one program: each solves what it takes, says what it cannot, keeps its hands off."""

from __future__ import annotations

import pickle
import sys
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from benchmarks.prepared import rival
from surefoot.base.errors import MissingExtra, ProblemError, SolverNotFound
from surefoot.contact.solvers.backends import (
    BACKENDS,
    ConeProgram,
    End,
    Options,
    backend,
    installed,
    solve_program,
)

NAMES = [pytest.param(name, marks=pytest.mark.skipif(not installed(name), reason=name)) for name in BACKENDS]
EXACT = {"daqp", "quadprog"}
"""Active sets: no tolerance of their own to speak of."""
WITHIN = {"ecos": 1e-6, "highs": 1e-6}
"""Distance to the optimum at a tolerance of 1e-9, else 1e-7."""


def linear_program(rng: np.random.Generator, sparse: bool = False) -> ConeProgram:
    """Return a strictly convex QP with equations, one-sided and two-sided rows and bounds."""
    n = 8
    root = rng.normal(size=(n, n))
    P, E, C = root @ root.T + np.eye(n), rng.normal(size=(2, n)), rng.normal(size=(6, n))
    box = np.eye(n)[2:5]
    rows = np.vstack([C, box, -box, -C[:2]])
    right = np.concatenate([rng.uniform(0.1, 0.5, 6), np.full(3, 0.05), np.full(3, 0.1), [1.0, np.inf]])
    form = sp.csr_matrix if sparse else np.array
    zero = form(E), 0.1 * rng.normal(size=2)
    return ConeProgram.of(form(P), rng.normal(size=n), zero=zero, nonneg=(form(rows), right))


def optimal(program: ConeProgram, x: np.ndarray) -> float:
    """Return how far x is from optimal by the optimality conditions alone (non-negative least squares)."""
    from scipy.optimize import nnls

    A, b, z = np.asarray(sp.csr_matrix(program.A).toarray()), program.b, program.zero
    slack = b - A @ x
    feasible = max(float(np.abs(slack[:z]).max(initial=0.0)), float(-slack[z:].min(initial=0.0)))
    active = np.flatnonzero(slack[z:] < 1e-5) + z
    normals = np.vstack([A[:z], -A[:z], A[active]])
    gradient = np.asarray(program.P @ x) + program.q
    return max(feasible, float(nnls(normals.T, -gradient)[1]))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("sparse", [False, True])
def test_every_backend_solves_a_qp(name: str, sparse: bool) -> None:
    for seed in range(5):
        program = linear_program(np.random.default_rng(seed), sparse)
        found = backend(name, Options(1e-9, sparse=sparse)).solve(program)
        assert found.end is End.SOLVED
        assert optimal(program, found.solution()) < 10.0 * WITHIN.get(name, 1e-7)
        assert found.iterations > 0 or name in ("highs", "quadprog")  # qpsolvers does not hand them on


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("warm", [False, True])
def test_a_kept_workspace_follows_changes_and_writes_into_nothing(name: str, warm: bool) -> None:
    """Matrices, vectors and bounds change from one program to the next, then the first comes back."""
    solver = rival(name, Options(1e-9, keep=True, warm=warm))  # with the benchmarks' prepared calls
    programs = [linear_program(np.random.default_rng(seed)) for seed in (0, 1, 2, 0)]
    items = [solver.ready(program) for program in programs]
    before = pickle.dumps([numbers(item) for item in items])
    for program, item in zip(programs, items, strict=True):
        found = solver.read(solver.call(item)())
        assert optimal(program, found.solution()) < 10.0 * WITHIN.get(name, 1e-7)
    assert pickle.dumps([numbers(item) for item in items]) == before


def numbers(item: Any) -> Any:
    """Return all arrays of a ready program."""
    if isinstance(item, tuple):
        return [numbers(part) for part in item]
    if isinstance(item, dict):
        return [numbers(part) for part in item.values()]
    return item.toarray() if sp.issparse(item) else item if isinstance(item, np.ndarray) else None


@pytest.mark.parametrize("name", NAMES)
def test_infeasible_programs_are_called_so(name: str) -> None:
    for row in (np.array([[1.0, 0.0, 0.0]]), np.array([[1.0, 1.0, 0.0]])):  # a bound and a row: <= -1, >= 1
        program = ConeProgram.of(np.eye(3), np.ones(3), nonneg=(np.vstack([row, -row]), [-1.0, -1.0]))
        found = backend(name, Options(1e-9)).solve(program)
        assert not found.found
        assert found.end in (End.INFEASIBLE, End.ALMOST_INFEASIBLE) or name == "highs"
        with pytest.raises(ProblemError, match="the solver ended"):
            found.solution()


@pytest.mark.parametrize("name", NAMES)
def test_cones_are_taken_or_refused(name: str) -> None:
    """The point of the cone (0.5 z, x, y) nearest to (3, 0, 1) with z <= 1.5 is (0.75, 0, 1.5)."""
    cone = -np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    program = ConeProgram.of(
        np.eye(3), [-3.0, 0.0, -1.0], nonneg=(np.eye(3)[2:], [1.5]), second_order=(cone, np.zeros(3))
    )
    if not BACKENDS[name].takes_cones:
        with pytest.raises(ProblemError, match="linear rows only"):
            solve_program(program, name)
        return
    found = solve_program(program, name, tol=1e-10)
    assert found.solution() == pytest.approx([0.75, 0.0, 1.5], abs=1e-6)
    linear = ConeProgram.of(
        None, [-1.0, 0.0, 0.0], nonneg=(np.eye(3)[2:], [1.5]), second_order=(cone, np.zeros(3))
    )
    assert solve_program(linear, name, tol=1e-9).solution()[0] == pytest.approx(0.75, abs=1e-6)


def test_proxqp_calls_no_feasible_program_infeasible() -> None:
    """Its tests of infeasibility go with the tolerance; as they come, tight tolerances run into them."""
    pytest.importorskip("proxsuite")
    refused = {"eps_primal_inf": 1e-4, "eps_dual_inf": 1e-4}, {}
    counts = []
    for own in refused:
        solver, found = backend("proxqp", Options(1e-9, own=own)), 0
        for seed in range(30):
            rng = np.random.default_rng(seed)
            x, C = rng.normal(size=10), rng.normal(size=(30, 10)) * 10.0 ** rng.uniform(-1, 1, (30, 1))
            P = np.diag(10.0 ** rng.uniform(-4, 1, 10))
            program = ConeProgram.of(P, rng.normal(size=10), nonneg=(C, C @ x))  # x keeps every row
            found += solver.solve(program).found
        counts.append(found)
    assert counts[0] < counts[1] == 30


def test_multipliers_come_in_the_rows_order() -> None:
    pytest.importorskip("clarabel")
    program = linear_program(np.random.default_rng(3))
    found = solve_program(program, tol=1e-11)
    gradient = program.P @ found.x + program.q + program.A.T @ found.y
    assert np.abs(gradient).max() < 1e-8
    assert found.y[program.zero :].min() > -1e-9


@pytest.mark.parametrize("sparse", [False, True])
def test_two_sided_rows_describe_the_same_set(sparse: bool) -> None:
    program = linear_program(np.random.default_rng(4), sparse)
    plain = program.two_sided()
    assert len(plain.low) == 6 + 3  # three of the boxes and one of the others have become two-sided
    assert np.isfinite(plain.low).sum() == 3 + 1
    bounded = program.two_sided(bounds=True)
    assert np.isfinite(bounded.lower).sum() == np.isfinite(bounded.upper).sum() == 3
    x = np.random.default_rng(5).normal(size=(2000, 8)) * 0.3
    A = sp.csr_matrix(program.A).toarray()[program.zero :]
    inside = (x @ A.T <= program.b[program.zero :]).all(axis=1)
    for sides in (plain, bounded):
        C = sp.csr_matrix(sides.C).toarray()
        again = ((x @ C.T <= sides.high) & (x @ C.T >= sides.low)).all(axis=1)
        again &= ((x >= sides.lower) & (x <= sides.upper)).all(axis=1)
        assert np.array_equal(again, inside)
    assert 0 < inside.sum() < 2000


def test_two_sided_keeps_limits_that_cross_apart() -> None:
    row = np.array([[1.0, 2.0]])
    sides = ConeProgram.of(np.eye(2), np.zeros(2), nonneg=(np.vstack([row, -row]), [1.0, -2.0])).two_sided()
    assert len(sides.high) == 2
    assert (sides.low <= sides.high).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.eye(2), np.zeros(3), np.zeros((0, 3)), np.zeros(0)), "P must have shape"),
        ((np.eye(3), np.zeros(3), np.zeros((2, 3)), np.zeros(2), 1), "A must have shape"),
        ((np.eye(3), np.zeros(3), np.zeros((2, 3)), np.zeros(3), 1, 1), "b must have shape"),
    ],
)
def test_programs_that_do_not_fit_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        ConeProgram(*arguments)


def test_names_and_packages_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SolverNotFound, match=r"unknown backend 'gurobi'; valid names: clarabel"):
        backend("gurobi")
    monkeypatch.setitem(sys.modules, "clarabel", None)
    with pytest.raises(MissingExtra, match=r"\[qp\]"):
        backend("clarabel")
