"""MOSEK without MOSEK: a stand-in takes its calls as its manual means them; Clarabel solves the rest."""

from __future__ import annotations

import sys
from enum import Enum
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from surefoot.errors import SolverNotFound
from surefoot.solvers.backends import ConeProgram, End, Options, backend, solve_program
from surefoot.solvers.backends.mosek import factor

Kind = Enum("boundkey", "fr fx up")
Which = Enum("soltype", "itr")
Status = Enum("solsta", "optimal prim_infeas_cer unknown")
Stop = Enum("rescode", "ok trm_max_iterations")


class Error(Exception):
    """As `mosek.Error`."""

    def __init__(self, errno: int, msg: str) -> None:
        self.errno, self.msg = errno, msg


class Task:
    """Keeps what `mosek.Task` is told and solves it as a program of its own."""

    failure: Error | None = None

    def __init__(self) -> None:
        self.words: dict[str, str] = {}
        self.cones: list[tuple[str, int, int]] = []

    def appendvars(self, n: int) -> None:
        self.q, self.free = np.zeros(n), np.zeros(n, dtype=bool)

    def putvarbound(self, k: int, kind: Kind, low: float, high: float) -> None:
        self.free[k] = kind is Kind.fr

    def putcslice(self, first: int, last: int, values: Any) -> None:
        self.q[first:last] = values

    def appendcons(self, m: int) -> None:
        self.A, self.bounds = np.zeros((m, len(self.q))), [(Kind.fr, 0.0)] * m

    def putaijlist(self, i: Any, j: Any, values: Any) -> None:
        self.A[i, j] = values

    def putconbound(self, k: int, kind: Kind, low: float, high: float) -> None:
        assert kind is Kind.up or low == high
        self.bounds[k] = kind, high

    def appendafes(self, rows: int) -> None:
        old = getattr(self, "F", np.zeros((0, len(self.q))))
        self.F = np.vstack([old, np.zeros((rows, len(self.q)))])
        self.g = np.append(getattr(self, "g", np.zeros(0)), np.zeros(rows))

    def putafefentrylist(self, i: Any, j: Any, values: Any) -> None:
        self.F[i, j] = values

    def putafegslice(self, first: int, last: int, values: Any) -> None:
        self.g[first:last] = values

    def appendquadraticconedomain(self, size: int) -> tuple[str, int]:
        return "quadratic", size

    def appendrquadraticconedomain(self, size: int) -> tuple[str, int]:
        return "rquadratic", size

    def appendsvecpsdconedomain(self, size: int) -> tuple[str, int]:
        return "svecpsd", size

    def appendaccseq(self, domain: tuple[str, int], first: int, b: None) -> None:
        self.cones.append((*domain, first))

    def putparam(self, name: str, value: str) -> None:
        self.words[name] = value

    def optimize(self) -> Stop:
        """Solve what was told by Clarabel: F x + g in a cone is b - A x in it with A = -F, b = g."""
        if self.failure is not None:
            raise self.failure
        assert self.free.all()
        equal = [k for k, (kind, _) in enumerate(self.bounds) if kind is Kind.fx]
        upper = [k for k, (kind, _) in enumerate(self.bounds) if kind is Kind.up]
        limit = np.array([high for _, high in self.bounds])
        A, b = [self.A[equal], self.A[upper]], [limit[equal], limit[upper]]
        second, sides = [], []
        for kind, size, first in sorted(self.cones, key=lambda cone: cone[0] == "svecpsd"):
            F, g = self.F[first : first + size], self.g[first : first + size]
            if (
                kind == "rquadratic"
            ):  # 2 x0 x1 >= ||x2..||², x0, x1 >= 0, is (x0 + x1, x0 - x1, √2 x2..) in the round one
                turn = np.diag([1.0, -1.0, *np.full(size - 2, np.sqrt(2.0))])
                turn[0, 1] = turn[1, 0] = 1.0
                F, g = turn @ F, turn @ g
            if kind == "svecpsd":
                side = int((np.sqrt(8 * size + 1) - 1) / 2)
                pairs = [(i, j) for j in range(side) for i in range(j, side)]  # lower triangle by columns
                order = [pairs.index((j, i)) for j in range(side) for i in range(j + 1)]
                F, g = F[order], g[order]
                sides.append(side)
            else:
                second.append(size)
            A.append(-F)
            b.append(g)
        program = ConeProgram(
            np.zeros((len(self.q),) * 2), self.q, np.vstack(A), np.concatenate(b), len(equal), len(upper),
            tuple(second), tuple(sides),
        )  # fmt: skip
        self.found = solve_program(program, "clarabel", tol=1e-9)
        return Stop.ok

    def solutiondef(self, which: Which) -> bool:
        return self.found.x is not None

    def getsolsta(self, which: Which) -> Status:
        return {
            End.SOLVED: Status.optimal,
            End.ALMOST: Status.optimal,
            End.INFEASIBLE: Status.prim_infeas_cer,
        }.get(self.found.end, Status.unknown)

    def getxx(self, which: Which) -> list[float]:
        return list(self.found.x)

    def getintinf(self, item: str) -> int:
        return self.found.iterations


@pytest.fixture
def mosek(monkeypatch: pytest.MonkeyPatch) -> type[Task]:
    pytest.importorskip("clarabel")
    told = type("TaskOfThisTest", (Task,), {})
    module = ModuleType("mosek")
    names = {"Task": told, "Error": Error, "boundkey": Kind, "soltype": Which, "solsta": Status}
    module.__dict__.update(names, iinfitem=SimpleNamespace(intpnt_iter="iterations"))
    monkeypatch.setitem(sys.modules, "mosek", module)
    return told


@pytest.mark.parametrize("seed", range(4))
def test_what_mosek_is_told_is_the_program(mosek: type[Task], seed: int) -> None:
    """A quadratic of any rank, equations, limits, two round cones and a semidefinite one."""
    rng = np.random.default_rng(seed)
    n = 9
    root = rng.normal(size=(n if seed % 2 else 5, n))
    inside = rng.normal(size=n)
    side = 3
    M = np.eye(side) + np.diag([0.5, 1.0, 2.0])
    upper = [M[i, j] * (1.0 if i == j else np.sqrt(2.0)) for j in range(side) for i in range(j + 1)]
    A = rng.normal(size=(1 + 4 + 3 + 4 + 6, n))
    slack = np.concatenate([[0.0], rng.uniform(0.1, 1.0, 4), [3.0, 1.0, 1.0], [4.0, 1.0, 1.0, 1.0], upper])
    form = sp.csr_matrix if seed > 1 else np.array
    P = root.T @ root
    q = P @ inside + 0.1 * rng.normal(size=n) if seed % 2 else -P @ rng.normal(size=n)
    program = ConeProgram(form(P), q, form(A), A @ inside + slack, 1, 4, (3, 4), (side,))
    right = solve_program(program, "clarabel", tol=1e-11).solution()
    found = solve_program(program, "mosek", tol=1e-9)

    def cost(x: np.ndarray) -> float:
        return float(0.5 * x @ P @ x + q @ x)

    assert found.end is End.SOLVED
    assert found.x is not None
    assert found.x.shape == (n,)
    assert found.iterations > 0
    assert cost(found.x) == pytest.approx(cost(right), abs=1e-6)
    if seed % 2:
        np.testing.assert_allclose(found.x, right, atol=1e-4)


def test_linear_objectives_options_and_infeasible_programs(mosek: type[Task]) -> None:
    row = np.array([[1.0, 0.0]])
    program = ConeProgram.of(None, [-1.0, 0.0], nonneg=(np.vstack([np.eye(2), -np.eye(2)]), np.ones(4)))
    solver = backend("mosek", Options(1e-9, 50, 2.0, own={"MSK_IPAR_NUM_THREADS": 1}))
    _, task = made = solver._set_up(solver.ready(program))
    assert task.words["MSK_DPAR_INTPNT_CO_TOL_PFEAS"] == "1e-09"
    assert task.words["MSK_IPAR_INTPNT_MAX_ITERATIONS"] == "50"
    assert task.words["MSK_DPAR_OPTIMIZER_MAX_TIME"] == "2.0"
    assert task.words["MSK_IPAR_NUM_THREADS"] == "1"
    assert solver.read(solver._run(made, None)).solution()[0] == pytest.approx(1.0, abs=1e-6)
    crossing = ConeProgram.of(np.eye(2), [0.0, 0.0], nonneg=(np.vstack([row, -row]), [-1.0, -1.0]))
    assert solver.solve(crossing).end is End.INFEASIBLE


def test_without_a_licence_one_line_says_so(mosek: type[Task]) -> None:
    program = ConeProgram.of(np.eye(2), [-1.0, 0.0], nonneg=(np.eye(2), np.ones(2)))
    mosek.failure = Error(1008, "License cannot be located.\nThe default search path is ':mosek.lic:'.")
    with pytest.raises(SolverNotFound, match=r"^mosek has no valid licence: License cannot be located\. The"):
        solve_program(program, "mosek")
    mosek.failure = Error(1501, "something else")
    assert solve_program(program, "mosek").end is End.FAILED


def test_where_it_is_not_installed_one_line_says_how(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mosek", None)
    with pytest.raises(SolverNotFound, match=r"mosek is not installed.*pip install mosek, and get a licence"):
        backend("mosek")


def test_path_is_answered_in_one_line() -> None:
    with pytest.raises(SolverNotFound, match="PATH is not among the solvers") as told:
        backend("path")
    assert "\n" not in str(told.value)
    with pytest.raises(SolverNotFound, match="PATH is not among the solvers"):
        sf.solve_lcp(sf.LCP(np.eye(2), -np.ones(2)), "path")


def test_factors_of_any_rank() -> None:
    rng = np.random.default_rng(1)
    for rank in (0, 1, 4):
        half = rng.normal(size=(rank, 4))
        R = factor(half.T @ half)
        assert R.shape == (rank, 4)
        np.testing.assert_allclose(R.T @ R, half.T @ half, atol=1e-12)
