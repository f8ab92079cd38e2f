"""`solve_batch`: many contact problems of one size, on threads; see there."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cached_property, partial
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    array_of,
    finite_array,
    numbers,
    real_array,
    real_number,
    whole_number,
)
from surefoot.base.cores import in_ranges
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of, located
from surefoot.contact.batch.derivative import BatchDerivative
from surefoot.contact.batch.loops import solve_range
from surefoot.contact.derivative.rates import fitting
from surefoot.contact.laws import LAWS, Law
from surefoot.contact.problem.matrix import ASYMMETRY, SINGLE_ASYMMETRY
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.sets.contact import MOST_FRICTION
from surefoot.contact.solution import Status, record_of
from surefoot.contact.solvers.compiled import NOT_NUMBERS
from surefoot.contact.solvers.solver import solve

MOST_CONTACTS = 256
"""Contacts of a problem up to which a batch takes it: above, dense factors take a second of a hard one."""
SMALL = 128
"""Problems up to which one thread does it: waking others takes longer."""
MOST = 10_000
"""Sweeps and Newton steps of a problem, all methods together, as of a `ContactSolver`."""


@dataclass(frozen=True, repr=False)
class BatchSolution(Drawn):
    """Solutions of a batch of problems, each with its own certificate.

    Attributes
    ----------
    forces, velocities
        (B, n, 3) in contact frames [N s] and [m/s], or [N] and [m/s²].
    status
        (B,) of `Status`.
    residual
        (B,) the first field of `Residuals`: velocity errors, relative.
    iterations
        (B,) sweeps and Newton steps.
    derivative
        With `derivative=True`; else None.
    """

    forces: FloatArray
    velocities: FloatArray
    status: Any
    residual: FloatArray
    iterations: IntArray
    derivative: BatchDerivative | None

    def __repr__(self) -> str:
        done = int(np.count_nonzero(self.solved))
        return f"BatchSolution({len(self.residual)} problems, {done} SOLVED, forces {self.forces.shape})"

    def __str__(self) -> str:
        names, counts = np.unique([status.name for status in self.status], return_counts=True)
        ends = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        worst = float(np.max(self.residual, initial=0.0))
        return f"{count_of(len(self.residual), 'problem')}: {ends}; velocity errors up to {worst:.1e}."

    @cached_property
    def solved(self) -> BoolArray:
        """(B,) whether the status is SOLVED."""
        return np.asarray(self.status == Status.SOLVED, dtype=np.bool_)


def solve_batch(
    G: ArrayLike,
    g: ArrayLike,
    mu: ArrayLike,
    normal_min: ArrayLike = 0.0,
    normal_max: ArrayLike = np.inf,
    law: str = "coulomb",
    *,
    tol: float = 1e-8,
    warm_start: ArrayLike | None = None,
    threads: int | None = None,
    derivative: bool = False,
) -> BatchSolution:
    """Solve many contact problems with up to 256 contacts each, on exact cones.

    Every problem is solved and certified as `ContactSolver` does it, independently of the others: the answers
    do not depend on the number of threads.

    Parameters
    ----------
    G, g
        (B, 3n, 3n) Delassus operators [m/s per unit of force: 1/kg for impulses in N s] and (B, 3n) free
        velocities [m/s]. Single precision is accepted (and computed in double; G may then be asymmetric by
        1e-5 of its largest entry).
    mu, normal_min, normal_max
        A number, (n,) or (B, n); mu dimensionless, the bounds in the forces' unit [N or N s]; see
        `ContactProblem`. normal_min = -inf holds a contact in all directions; problems of mixed sizes are
        padded with rows of zeros and normal_max = 0.
    law
        "coulomb" or "convex".
    tol
        Wanted velocity error and rounding, see `Residuals`.
    warm_start
        (B, n, 3) forces to start from, in their unit [N or N s].
    threads
        None for as many as there are cores for this process, or as NUMBA_NUM_THREADS says.
    derivative
        Whether to keep what `BatchSolution.derivative` needs.

    Raises
    ------
    ProblemError
        If an argument is out of range, naming it; never for a problem that is hard or has no solution, and
        not for one whose numbers are not finite: that one is INVALID.
    """
    check_name("law", law, LAWS)
    named = LAWS[law]
    tol = real_number("tol", tol, low=0.0, high=1e300)
    workers = numba.config.NUMBA_NUM_THREADS if threads is None else whole_number("threads", threads, low=1)
    matrices, free, single = _read(G, g)
    B, m = free.shape
    n = m // 3
    if n > MOST_CONTACTS:
        raise ProblemError(f"a batch takes up to {MOST_CONTACTS} contacts a problem, got {n}")
    laws, convex = _read_laws(mu, normal_min, normal_max, B, n), named == "convex"
    buffers, done = np.empty((B, 2 * n + 3, 3)), np.empty(B, dtype=np.int64)
    if warm_start is not None:
        buffers[:, :n] = finite_array("warm_start", warm_start, (B, n, 3))
    limit, warm = SINGLE_ASYMMETRY if single else ASYMMETRY, warm_start is not None
    run = partial(in_ranges, count=B, threads=workers if B > SMALL else 1)
    run(lambda a, b: solve_range(matrices, free, laws, convex, limit, tol, MOST, warm, buffers, done, a, b))
    status, valid = np.full(B, Status.SOLVED, dtype=object), done >= 0
    for b in np.flatnonzero(done < 0).tolist():
        own = laws[b if len(laws) > 1 else 0]
        status[b] = _solve_rest(b, matrices[b], free[b], own, named, tol, done, buffers[b])
        valid[b] = status[b] is Status.SOLVED
    found = BatchDerivative(matrices, free, laws, convex, buffers, valid, run) if derivative else None
    return BatchSolution(
        buffers[:, :n], buffers[:, n : 2 * n], status, buffers[:, 2 * n, 0], np.abs(done), found
    )


def _solve_rest(
    b: int, G: FloatArray, g: FloatArray, laws: FloatArray, law: Law, tol: float, done: IntArray,
    buffer: FloatArray,
) -> Status:  # fmt: skip
    """Solve by the general path what the compiled loop left; fill the buffer and return the status."""
    n = laws.shape[1]
    used = int(~done[b]) if done[b] > NOT_NUMBERS else 0
    start = buffer[:n].copy()
    buffer[:] = 0.0
    if not (np.isfinite(G).all() and np.isfinite(g).all()):
        done[b] = 0
        buffer[2 * n :] = np.nan
        return Status.INVALID
    (mu, low, high), held = laws, np.isinf(laws[1])
    with located(f"problem {b} of the batch"):
        problem = ContactProblem(G, g, mu, np.where(held, 0.0, low), high, law, bilateral=held)
    guess = start if used > 0 and np.isfinite(start).all() else None
    found = solve(problem, "auto", tol, max_iterations=max(MOST - used, 0), warm_start=guess)
    buffer[:] = record_of(found.forces, found.velocities, astuple(found.residuals))
    done[b] = used + found.iterations
    return found.status


def _read(G: ArrayLike, g: ArrayLike) -> tuple[FloatArray, FloatArray, bool]:
    """Return G (B, 3n, 3n) and g (B, 3n) as doubles, and whether G was of single precision."""
    given = array_of("G", G, "biufO", "numeric", None)
    matrices, free = numbers("G", given), numbers("g", g)
    if free.ndim != 2 or free.shape[1] % 3 or free.shape[1] == 0:
        raise ProblemError(f"g must have shape (B, 3n), got {free.shape}")
    if matrices.shape != (*free.shape, free.shape[1]):
        raise ProblemError(
            f"G must have shape {(*free.shape, free.shape[1])} for this g, got {matrices.shape}"
        )
    return matrices, free, given.dtype == np.float32


def _read_laws(mu: ArrayLike, low: ArrayLike, high: ArrayLike, B: int, n: int) -> FloatArray:
    """Return the laws (1, 3, n), or (B, 3, n) where they differ from problem to problem."""
    names = ("mu", "normal_min", "normal_max")
    read = [real_array(name, value) for name, value in zip(names, (mu, low, high), strict=True)]
    for name, value in zip(names, read, strict=True):
        fitting(name, value, (B,), n)
        held = (value == -np.inf) & (name == "normal_min")
        if (~held & (value < 0.0)).any() or (name != "normal_max" and (value > MOST_FRICTION).any()):
            words = ">= 0" if name == "normal_max" else f"finite and >= 0, at most {MOST_FRICTION:g}"
            raise ProblemError(f"{name} must be {words}")
    laws = np.empty((B if any(value.ndim == 2 for value in read) else 1, 3, n))
    for row, value in enumerate(read):
        laws[:, row] = value
    if (laws[:, 1] > laws[:, 2]).any():
        raise ProblemError("normal_min must be <= normal_max")
    if ((laws[:, 1] == -np.inf) & (laws[:, 2] != np.inf)).any():
        raise ProblemError("a bilateral contact takes no normal bounds")
    return laws
