"""Solve and certify an LCP, the small sibling of `solver`; a method is one file and one line of `METHODS`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, of_kind, real_number
from surefoot.base.blas_threads import light_blas
from surefoot.base.errors import NoSolution, SolverNotFound, unknown_name
from surefoot.base.kernels import working_time
from surefoot.contact.problem.lcp import LCP
from surefoot.contact.solution import Status
from surefoot.contact.solvers.lcp_interior_point import solve_interior_point
from surefoot.contact.solvers.lcp_proof import farkas
from surefoot.contact.solvers.lemke import solve_lemke
from surefoot.contact.solvers.solver import ALMOST_FACTOR, Answer, SolverSettings


@dataclass(frozen=True, repr=False)
class LcpSolution:
    """A solution of an LCP with its own certificate.

    Attributes
    ----------
    problem, z, w
        What was asked, the solution (n,) and its slack M z + q (n,), in the units of the problem.
    status
        SOLVED only if `residual`, and what rounding leaves open (`LCP.rounding`), are below the tolerance;
        INFEASIBLE only with a `proof`.
    residual
        See `LCP.residual`.
    solver, iterations, solve_time
        Who solved it, in how many iterations or pivots, and how long it took [s].
    ray
        Where Lemke's method left along a ray: its direction (n,) in z, in any unit; else None. It proves
        nothing by itself.
    proof
        With INFEASIBLE: v >= 0, (n,) in any unit, with Mᵀ v <= 0 and q . v < 0, in exact arithmetic on the
        numbers as they are (`LCP.proves_infeasible`); else None.
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
    message: str = ""
    proof: FloatArray | None = None

    def __repr__(self) -> str:
        return f"LcpSolution({self.status.name}, size={len(self.z)}, residual={self.residual:.1e})"

    def __str__(self) -> str:
        said = f" {self.message[:1].upper()}{self.message[1:]}" if self.message else ""
        size = f"{len(self.z)} unknowns, residual {self.residual:.1e}"
        return f"{self.status.name} by {self.solver}: {size}.{said}"

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


LcpFunction = Callable[[LCP, SolverSettings], Answer]
METHODS: dict[str, LcpFunction] = {"interior_point": solve_interior_point, "lemke": solve_lemke}
"""All LCP solvers by name."""


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
        "lemke" (any matrix that it can process) or "interior_point" (PSD).
    tol
        Wanted `LCP.residual` [-].
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
    of_kind("problem", problem, LCP)
    if solver not in METHODS:
        raise SolverNotFound(unknown_name("LCP solver", solver, METHODS))
    settings = SolverSettings(
        real_number("tol", tol, low=0.0), max_iterations, real_number("max_time", max_time, low=0.0)
    )
    start = time.perf_counter()
    answer = _by_parts(problem, METHODS[solver], settings)
    z, stop, message, proof = answer.forces, answer.stop, answer.message, None
    if not np.isfinite(z).all():
        z, stop, message = np.zeros(problem.size), Status.INVALID, "the method left the range of numbers"
    residual = problem.residual(z)
    error = max(residual, problem.rounding(z))
    if error <= tol and stop is not Status.INVALID:
        stop = Status.SOLVED
    elif stop is Status.INFEASIBLE:
        proof = farkas(problem, answer.ray, max_time)
        stop = Status.STALLED if proof is None else stop
    if stop not in (Status.SOLVED, Status.INFEASIBLE, Status.INVALID) and error <= ALMOST_FACTOR * tol:
        stop = Status.ALMOST
    spent = time.perf_counter() - start
    with np.errstate(over="ignore", invalid="ignore"):
        w = problem.M @ z + problem.q
    return LcpSolution(
        problem, z, w, stop, residual, solver, answer.iterations, spent, answer.ray, message, proof
    )


def _by_parts(problem: LCP, method: LcpFunction, settings: SolverSettings) -> Answer:
    """Solve one uncoupled part after the other; stop at the first that the method leaves along a ray.

    A part with q >= 0 is solved by z = 0.
    """
    end = working_time() + settings.max_time
    z, iterations, stop = np.zeros(problem.size), 0, None
    ray, message = None, ""
    for index in problem.parts:
        if (problem.q[index] >= 0.0).all():
            continue
        part, unit = _of_unit_size(problem.part(index))
        left = None if settings.max_iterations is None else max(0, settings.max_iterations - iterations)
        with np.errstate(all="ignore"), light_blas(part.size):  # what is lost shows in the residual
            found = method(part, SolverSettings(settings.tol, left, max(0.0, end - working_time())))
            z[index], iterations = np.ldexp(found.forces, unit), iterations + found.iterations
        # a part is judged by itself, so that one without solution does not take the others' answers along
        if part.residual(found.forces) <= settings.tol:
            continue
        if stop is None or found.stop is Status.INFEASIBLE:
            stop, message = found.stop, found.message
            if found.ray is not None:
                ray = np.zeros(problem.size)
                ray[index] = found.ray
        if found.stop is Status.INFEASIBLE:
            break
    return Answer(z, iterations, stop or Status.STALLED, ray=ray, message=message)


def _of_unit_size(problem: LCP) -> tuple[LCP, int]:
    """Return the problem with M and q of largest entries near one, and the exponent k of z = 2^k z'."""
    (M, m), (q, k) = (_power_of_two(x) for x in (problem.M, problem.q))
    return LCP(M, q), k - m


def _power_of_two(x: FloatArray) -> tuple[FloatArray, int]:
    """Return x / 2^k with a largest entry near one, and k; or x and 0, where that would round an entry."""
    k = int(np.frexp(np.abs(x).max())[1])
    scaled = np.ldexp(x, -k)
    return (scaled, k) if np.array_equal(np.ldexp(scaled, k), x) else (x, 0)
