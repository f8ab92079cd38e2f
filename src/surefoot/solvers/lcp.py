"""The contract of LCP solvers: register, solve, certify; the small sibling of `solver`."""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from surefoot.arrays import FloatArray, real_number
from surefoot.contact.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.errors import NoSolution, SolverNotFound, unknown_name
from surefoot.solvers.solver import ALMOST_FACTOR, Settings

_MODULES = ("lemke", "lcp_iterative", "lcp_interior_point", "lcp_newton", "lcp_quadratic")


@dataclass(frozen=True)
class LcpAnswer:
    """What an LCP solver hands back: z, why it stopped, and a ray if it met one."""

    z: FloatArray
    iterations: int
    stop: Status = Status.MAX_ITERATIONS
    ray: FloatArray | None = None
    message: str = ""


@dataclass(frozen=True)
class LcpSolution:
    """A solution of an LCP with its own certificate.

    Attributes
    ----------
    problem, z, w
        What was asked, the solution and its slack M z + q.
    status
        SOLVED only if `residual` is below the tolerance; INFEASIBLE only with a Farkas vector as `ray`:
        v >= 0 with Mᵀ v <= 0 and q . v < 0.
    residual
        See `LCP.residual`.
    solver, iterations, solve_time
        Who solved it, in how many iterations or pivots, and how long it took [s].
    ray
        Where Lemke's method left along a ray: its direction in z; else None.
    message
        What there is to say beyond the status.
    """

    problem: LCP
    z: FloatArray
    w: FloatArray
    status: Status
    residual: float
    solver: str
    iterations: int
    solve_time: float
    ray: FloatArray | None = None
    message: str = field(default="")

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED

    def raise_if_failed(self) -> LcpSolution:
        """Return the solution itself if solved, else raise NoSolution."""
        if not self.solved:
            raise NoSolution(
                f"{self.solver} ended with status {self.status.value!r} (residual {self.residual:.1e})"
                + (f": {self.message}" if self.message else ""),
                self.problem,
                self,
            )
        return self


LcpFunction = Callable[[LCP, Settings], LcpAnswer]
_REGISTRY: dict[str, LcpFunction] = {}


def register_lcp(name: str) -> Callable[[LcpFunction], LcpFunction]:
    """Return the decorator that makes a function an LCP solver."""

    def decorate(function: LcpFunction) -> LcpFunction:
        _REGISTRY[name] = function
        return function

    return decorate


def lcp_solver_names() -> tuple[str, ...]:
    """Return the names of all LCP solvers; imports their files on first use."""
    for module in _MODULES:
        importlib.import_module(f"surefoot.solvers.{module}")
    return tuple(sorted(_REGISTRY))


def solve_lcp(
    problem: LCP,
    solver: str = "lemke",
    tol: float = 1e-8,
    *,
    max_iterations: int | None = None,
    max_time: float = math.inf,
) -> LcpSolution:
    """Solve an LCP and certify the answer.

    Parameters
    ----------
    problem
        What to solve.
    solver
        "lemke" (any matrix that it can process), "pgs" (symmetric positive definite, or diagonally dominant),
        "interior_point" (PSD), "newton" (any, no promise) or "qp" (PSD).
    tol
        Wanted `LCP.residual`.
    max_iterations, max_time
        Bounds; the time [s] is checked between iterations.

    Raises
    ------
    SolverNotFound
        If the name is unknown, or its package is missing.

    Examples
    --------
    >>> solution = solve_lcp(LCP([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0]))
    >>> solution.status.value, (3 * solution.z).round(6).tolist()
    ('solved', [4.0, 7.0])
    """
    names = lcp_solver_names()
    if solver not in names:
        raise SolverNotFound(unknown_name("LCP solver", solver, names))
    settings = Settings(
        real_number("tol", tol, low=0.0), max_iterations, real_number("max_time", max_time, low=0.0)
    )
    start = time.perf_counter()
    answer = LcpAnswer(np.zeros(0), 0) if problem.size == 0 else _REGISTRY[solver](problem, settings)
    spent = time.perf_counter() - start
    z = np.asarray(answer.z, dtype=np.float64)
    residual = problem.residual(z)
    if not math.isfinite(residual):
        status = Status.INVALID
    elif residual <= tol:
        status = Status.SOLVED
    elif answer.stop is Status.INFEASIBLE and _is_farkas(problem, answer.ray):
        status = Status.INFEASIBLE
    elif residual <= ALMOST_FACTOR * tol:
        status = Status.ALMOST
    else:
        status = Status.STALLED if answer.stop is Status.INFEASIBLE else answer.stop
    w = problem.M @ z + problem.q if np.isfinite(z).all() else np.full_like(z, np.nan)
    return LcpSolution(
        problem, z, w, status, residual, solver, answer.iterations, spent, answer.ray, answer.message
    )


def _is_farkas(problem: LCP, v: FloatArray | None) -> bool:
    """Tell whether v proves that no z >= 0 has M z + q >= 0."""
    if v is None or not np.isfinite(v).all():
        return False
    scale = float(np.abs(v).max())
    if scale <= 0.0 or (v < -1e-10 * scale).any():
        return False
    most = float((problem.M.T @ v).max())
    return most <= 1e-9 * scale * float(np.abs(problem.M).max()) and float(
        problem.q @ v
    ) < -1e-9 * scale * float(np.abs(problem.q).max())
