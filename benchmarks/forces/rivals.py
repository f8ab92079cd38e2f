"""Rivals of `ForceDistributor`: cone solvers with exact cones and QP solvers with facets.

Each rival gets the problem in its own words, prepared outside the clock (the Hessian too, which
`ForceDistributor` does not need and does not get), with its native interface where that is faster than
a wrapper. `cold` solves from nothing; `warm`, where the rival can, goes on from the last solution.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray
from surefoot.problems.allocation_program import Program, cone_rows

Call = Callable[[], FloatArray | None]
TOLERANCE = 1e-6
"""Asked of solvers that stop by a tolerance, unless the benchmark finds that a looser one will do."""


class Rival(ABC):
    """A solver on one kind of program; `tol` is its stopping tolerance, where it has one."""

    name = ""
    exact = False
    can_warm = False
    has_tol = False
    tol = TOLERANCE

    def cold(self, p: Program) -> Call:
        """Return the call that sets up and solves."""
        return self._cold(p)

    def warm(self, p: Program) -> Call:
        """Return the call that solves from the last answer; a cold one where the rival cannot."""
        return self._warm(p) if self.can_warm else self._cold(p)

    @abstractmethod
    def _cold(self, p: Program) -> Call:
        """Return the call that sets up and solves."""

    def _warm(self, p: Program) -> Call:
        """Return the call that solves from the last answer, for rivals that can."""
        return self._cold(p)


class Clarabel(Rival):
    """Interior point on exact cones."""

    name, exact, has_tol = "Clarabel", True, True

    def _cold(self, p: Program) -> Call:
        import clarabel

        M, b = cone_rows(p)
        a = p.mu.size
        P, rows = sp.csc_matrix(np.triu(p.H)), sp.csc_matrix(M)
        cones = [clarabel.NonnegativeConeT(2 * a)] + [clarabel.SecondOrderConeT(3)] * a
        options = clarabel.DefaultSettings()
        options.verbose = options.presolve_enable = False
        options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = self.tol

        def solve() -> FloatArray | None:
            found = clarabel.DefaultSolver(P, p.h, rows, b, cones, options).solve()
            return np.asarray(found.x) if "Solved" in str(found.status) else None

        return solve


class Ecos(Rival):
    """Interior point on exact cones; the quadratic objective becomes one more cone."""

    name, exact, has_tol = "ECOS", True, True

    def _cold(self, p: Program) -> Call:
        import ecos

        M, b = cone_rows(p)
        m = p.h.size
        a = p.mu.size
        root = np.linalg.cholesky(p.H).T
        shift = np.linalg.solve(root.T, p.h)  # 1/2 |root x + shift|² + const
        objective = np.zeros(m + 1)
        objective[m] = 1.0
        top = np.zeros((m + 1, m + 1))
        top[0, m] = -1.0
        top[1:, :m] = -root
        G = sp.csc_matrix(np.vstack([np.hstack([M, np.zeros((len(M), 1))]), top]))
        right = np.concatenate([b, [0.0], shift])
        dims = {"l": 2 * a, "q": [3] * a + [m + 1]}

        def solve() -> FloatArray | None:
            found = ecos.solve(
                objective, G, right, dims, verbose=False, abstol=self.tol, reltol=self.tol, feastol=self.tol
            )
            return np.asarray(found["x"][:m]) if found["info"]["exitFlag"] in (0, 10) else None

        return solve


class Scs(Rival):
    """ADMM on exact cones."""

    name, exact, can_warm, has_tol = "SCS", True, True, True

    def __init__(self) -> None:
        self._last: Any = None

    def _solver(self, p: Program) -> Callable[[], Any]:
        import scs

        M, b = cone_rows(p)
        a = p.mu.size
        data = {"P": sp.csc_matrix(np.triu(p.H)), "A": sp.csc_matrix(M), "b": b, "c": p.h}
        cone = {"l": 2 * a, "q": [3] * a}
        options = {"verbose": False, "eps_abs": self.tol, "eps_rel": self.tol, "max_iters": 20_000}
        return lambda: scs.SCS(data, cone, **options)

    def _cold(self, p: Program) -> Call:
        make = self._solver(p)

        def solve() -> FloatArray | None:
            found = make().solve()
            return np.asarray(found["x"]) if found["info"]["status_val"] in (1, 2) else None

        return solve

    def _warm(self, p: Program) -> Call:
        make = self._solver(p)

        def solve() -> FloatArray | None:
            old = self._last
            fits = old is not None and old["x"].size == p.h.size
            start = {"warm_start": True, "x": old["x"], "y": old["y"], "s": old["s"]} if fits else {}
            found = make().solve(**start)
            self._last = found
            return np.asarray(found["x"]) if found["info"]["status_val"] in (1, 2) else None

        return solve


class Daqp(Rival):
    """Dual active set on facets."""

    name, can_warm = "DAQP", True

    def __init__(self) -> None:
        self._model: Any = None
        self._shape: tuple[int, ...] = ()

    def _data(self, p: Program) -> tuple[Any, ...]:
        assert p.C is not None
        upper = np.concatenate([p.high, np.zeros(len(p.C))])
        lower = np.concatenate([p.low, np.full(len(p.C), -np.inf)])
        H, C = np.ascontiguousarray(p.H), np.ascontiguousarray(p.C)
        return H, p.h, C, np.clip(upper, -1e30, 1e30), np.clip(lower, -1e30, 1e30)

    def _cold(self, p: Program) -> Call:
        import daqp

        data = (*self._data(p), np.zeros(p.high.size + len(p.C if p.C is not None else ()), dtype=np.int32))

        def solve() -> FloatArray | None:
            x, _, flag, _ = daqp.solve(*data)
            return np.asarray(x) if flag > 0 else None

        return solve

    def _warm(self, p: Program) -> Call:
        import daqp

        data = self._data(p)
        if self._model is None or self._shape != data[2].shape:
            self._model, self._shape = daqp.Model(), data[2].shape
            self._model.setup(*data)

        def solve() -> FloatArray | None:
            self._model.update(*data)
            x, _, flag, _ = self._model.solve()
            return np.asarray(x) if flag > 0 else None

        return solve


class Quadprog(Rival):
    """Goldfarb and Idnani's dual active set on facets."""

    name = "quadprog"

    def _cold(self, p: Program) -> Call:
        import quadprog

        assert p.C is not None
        box = np.eye(p.h.size)[2::3]
        C = np.ascontiguousarray(np.vstack([-p.C, box, -box]).T)
        b = np.concatenate([np.zeros(len(p.C)), p.low[2::3], -p.high[2::3]])
        a = -p.h

        def solve() -> FloatArray | None:
            try:
                return np.asarray(quadprog.solve_qp(p.H, a, C, b)[0])
            except ValueError:
                return None

        return solve


class Osqp(Rival):
    """ADMM on facets."""

    name, can_warm, has_tol = "OSQP", True, True

    def __init__(self) -> None:
        self._solver: Any = None
        self._rows: Any = None

    def _data(self, p: Program) -> tuple[Any, ...]:
        assert p.C is not None
        box = np.eye(p.h.size)[2::3]
        rows = sp.csc_matrix(np.vstack([p.C, box]))
        low = np.concatenate([np.full(len(p.C), -np.inf), p.low[2::3]])
        high = np.concatenate([np.zeros(len(p.C)), p.high[2::3]])
        # every entry of the upper triangle is kept, also a zero: updates need a fixed pattern
        i, j = np.triu_indices(p.h.size)
        order = np.lexsort((i, j))
        pointers = np.concatenate([[0], np.cumsum(np.arange(1, p.h.size + 1))])
        P = sp.csc_matrix((p.H[i[order], j[order]], i[order], pointers), p.H.shape)
        return P, p.h, rows, low, high

    def _setup(self, data: tuple[Any, ...]) -> Any:
        import osqp

        solver = osqp.OSQP()
        P, h, rows, low, high = data  # on copies: its updates write into the matrices that it was set up with
        solver.setup(
            P.copy(),
            h,
            rows.copy(),
            low,
            high,
            verbose=False,
            eps_abs=self.tol,
            eps_rel=self.tol,
            max_iter=20_000,
            polishing=False,
        )
        return solver

    @staticmethod
    def _answer(found: Any) -> FloatArray | None:
        return np.asarray(found.x) if found.info.status_val == 1 else None

    def _cold(self, p: Program) -> Call:
        data = self._data(p)
        return lambda: self._answer(self._setup(data).solve(raise_error=False))

    def _warm(self, p: Program) -> Call:
        data = self._data(p)
        rows, last = data[2], self._rows
        if last is None or last.shape != rows.shape or not np.array_equal(last.indices, rows.indices):
            self._solver = self._setup(data)
            last = rows
        change = {"Px": data[0].data, "q": data[1], "l": data[3], "u": data[4]}
        if not np.array_equal(last.data, rows.data):  # the friction is new
            change["Ax"] = rows.data
        self._rows = rows

        def solve() -> FloatArray | None:
            self._solver.update(**change)
            return self._answer(self._solver.solve(raise_error=False))

        return solve


class ProxQp(Rival):
    """Proximal augmented Lagrangian on facets."""

    name, can_warm, has_tol = "ProxQP", True, True

    def __init__(self) -> None:
        self._qp: Any = None
        self._rows: FloatArray = np.zeros((0, 0))

    def _data(self, p: Program) -> tuple[Any, ...]:
        assert p.C is not None
        box = np.eye(p.h.size)[2::3]
        rows = np.vstack([p.C, box])
        low = np.concatenate([np.full(len(p.C), -1e20), p.low[2::3]])
        high = np.concatenate([np.zeros(len(p.C)), np.minimum(p.high[2::3], 1e20)])
        return p.H, p.h, None, None, rows, low, high

    def _setup(self, data: tuple[Any, ...]) -> Any:
        import proxsuite

        qp = proxsuite.proxqp.dense.QP(data[1].size, 0, len(data[4]))
        qp.settings.eps_abs, qp.settings.eps_rel = self.tol, 0.0
        qp.init(*data)
        return qp

    @staticmethod
    def _answer(qp: Any) -> FloatArray | None:
        qp.solve()
        return np.array(qp.results.x) if "SOLVED" in str(qp.results.info.status) else None

    def _cold(self, p: Program) -> Call:
        data = self._data(p)
        return lambda: self._answer(self._setup(data))

    def _warm(self, p: Program) -> Call:
        import proxsuite

        data = self._data(p)
        if self._qp is None or self._rows.shape != data[4].shape:
            self._qp, self._rows = self._setup(data), data[4]
            guess = proxsuite.proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            self._qp.settings.initial_guess = guess
        change = {"H": data[0], "g": data[1], "l": data[5], "u": data[6]}
        if not np.array_equal(self._rows, data[4]):  # the friction is new
            change["C"] = data[4]
        self._rows = data[4]

        def solve() -> FloatArray | None:
            self._qp.update(**change)
            return self._answer(self._qp)

        return solve


class Piqp(Rival):
    """Proximal interior point on facets."""

    name, has_tol = "PIQP", True

    def _cold(self, p: Program) -> Call:
        import piqp

        assert p.C is not None
        H, C = np.asfortranarray(p.H), np.asfortranarray(p.C)
        zero = np.zeros(len(C))
        below = np.full(len(C), -np.inf)

        def solve() -> FloatArray | None:
            solver = piqp.DenseSolver()
            solver.settings.eps_abs = solver.settings.eps_rel = self.tol
            solver.settings.eps_duality_gap_abs = solver.settings.eps_duality_gap_rel = self.tol
            solver.setup(H, p.h, None, None, C, below, zero, p.low, p.high)
            status = solver.solve()
            return np.array(solver.result.x) if status == piqp.PIQP_SOLVED else None

        return solve


class Highs(Rival):
    """Active set on facets, through qpsolvers."""

    name = "HiGHS"

    def _cold(self, p: Program) -> Call:
        import qpsolvers

        assert p.C is not None
        problem = qpsolvers.Problem(
            sp.csc_matrix(p.H), p.h, sp.csc_matrix(p.C), np.zeros(len(p.C)), lb=p.low, ub=p.high
        )

        def solve() -> FloatArray | None:
            found = qpsolvers.solve_problem(problem, "highs")
            return np.asarray(found.x) if found.found and found.x is not None else None

        return solve


EXACT_RIVALS: tuple[type[Rival], ...] = (Clarabel, Ecos, Scs)
FACET_RIVALS: tuple[type[Rival], ...] = (Daqp, Quadprog, ProxQp, Osqp, Piqp, Highs)


def available(rivals: tuple[type[Rival], ...]) -> list[type[Rival]]:
    """Return the rivals whose package is installed."""
    import importlib.util

    packages = {"Clarabel": "clarabel", "ProxQP": "proxsuite", "HiGHS": "highspy"}
    return [r for r in rivals if importlib.util.find_spec(packages.get(r.name, r.name.lower())) is not None]
