"""The solver contract: register an algorithm, solve a problem, certify the answer."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, of_kind, real_number, whole_number
from surefoot.base.blas_threads import light_blas
from surefoot.base.errors import ProblemError, SolverNotFound, unknown_name
from surefoot.base.kernels import working_time
from surefoot.base.lazy_table import LazyTable
from surefoot.contact.laws import LAWS
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.proof import InfeasibilityProof
from surefoot.contact.problem.residuals import certificate
from surefoot.contact.solution import ContactSolution, Status, record_of
from surefoot.contact.solvers.infeasibility import find_proof

ALMOST_FACTOR = 1e3
"""A residual within this factor of the tolerance is ALMOST solved."""
_clock, _INFINITY, _SOLVED = time.perf_counter, math.inf, Status.SOLVED


@dataclass(frozen=True)
class SolverSettings:
    """What every solver is told.

    Attributes
    ----------
    tol
        Wanted velocity error, see `surefoot.contact.problem.residuals`.
    max_iterations
        Bound on the iterations; None for the solver's own default. It alone bounds a solve the same way on
        every machine, however busy.
    max_time
        Bound on the wall time [s], checked between iterations: what is reached within it is another thing
        on a faster or a busier machine.
    """

    tol: float = 1e-8
    max_iterations: int | None = None
    max_time: float = math.inf


class Answer(NamedTuple):
    """What a solver hands back to `solve` or `solve_lcp`: its forces and why it stopped, no claim of success.

    `forces` have the shape of the problem's, (n, 3), and its unit [N s, or N], or are z (n,) of an LCP.
    `stop` is read only where the residuals do not already say SOLVED or ALMOST; INFEASIBLE
    needs the proof. `ray` (n,) is a direction of Lemke's method that may lead to one.
    """

    forces: FloatArray
    iterations: int
    stop: Status = Status.MAX_ITERATIONS
    proof: InfeasibilityProof | None = None
    ray: FloatArray | None = None
    message: str = ""


SolverFunction = Callable[[ContactProblem, SolverSettings, FloatArray | None], Answer]
Attempt = Callable[
    [ContactProblem, float, int | None, float, FloatArray | None],
    tuple[FloatArray, int, bool, int] | None,
]
"""(problem, tol, max_iterations, max_time, warm start) -> record of `ContactSolution`, iterations, whether
`problem.residuals` says SOLVED, iterations that were allowed; None for a problem that it does not take."""
Function = TypeVar("Function", bound=SolverFunction)


@dataclass(frozen=True)
class SolverEntry:
    """A registered solver and what it can take."""

    name: str
    function: SolverFunction
    laws: tuple[str, ...] | None
    exact: bool
    polyhedral: bool
    bilateral: bool
    bounds: bool
    general: bool
    attempt: Attempt | None = None
    proves: bool = False


_REGISTRY: dict[str, SolverEntry] = {}
SOLVERS: LazyTable[SolverFunction] = LazyTable(
    "solver",
    {
        "distribution": "surefoot.contact.solvers.distribution:solve_distribution",
        "auto": "surefoot.contact.solvers.auto:solve_auto",
        "newton": "surefoot.contact.solvers.newton:solve_newton",
        "nsgs": "surefoot.contact.solvers.nsgs:solve_nsgs",
        "admm": "surefoot.contact.solvers.admm:solve_admm",
        "interior_point": "surefoot.contact.solvers.interior_point:solve_interior",
        "lemke": "surefoot.contact.solvers.lemke:solve_friction",
        "daqp": "surefoot.contact.solvers.daqp:solve_daqp",
    },
)
"""The package's own solvers; to import one registers it."""
GAVE_UP = (Status.STALLED, Status.MAX_ITERATIONS, Status.INVALID)
"""What may have its cause in a problem without solution."""


def register(
    name: str,
    *,
    laws: Iterable[str] | None = tuple(LAWS),
    exact: bool = True,
    polyhedral: bool = False,
    bilateral: bool = False,
    bounds: bool = True,
    general: bool = False,
    attempt: Attempt | None = None,
    proves: bool = False,
) -> Callable[[Function], Function]:
    """Return the decorator that makes a function a solver.

    Parameters
    ----------
    name
        What users pass to `solve`.
    laws
        The laws it solves, by name; None for any `Law`.
    exact, polyhedral
        Whether it takes problems with exact cones, and with pyramids.
    bilateral
        Whether it takes problems with bilateral contacts.
    bounds
        Whether it takes normal bounds other than 0 and infinity.
    general
        Whether it takes contacts of any kind, through `problem.contact_set`.
    attempt
        What `solve` tries first, one compiled call that solves and has `problem.residuals` judge. If that
        is not solved, the function goes on from its forces.
    proves
        Whether it looks for a proof of infeasibility itself; for the others `solve` does, once they gave up.
    """

    def decorate(function: Function) -> Function:
        own = None if laws is None else tuple(laws)
        _REGISTRY[name] = SolverEntry(
            name, function, own, exact, polyhedral, bilateral, bounds, general, attempt, proves
        )
        return function

    return decorate


def registry() -> dict[str, SolverEntry]:
    """Return all solvers by name; imports their files on first use."""
    for name in SOLVERS:
        SOLVERS.load(name)
    return _REGISTRY


def solver_names(problem: ContactProblem | None = None) -> tuple[str, ...]:
    """Return the names of all solvers, or of those that take a problem's law, cones and bounds."""
    if problem is not None:
        of_kind("problem", problem, ContactProblem)
    entries = registry().values()
    return tuple(sorted(e.name for e in entries if problem is None or mismatch(e, problem) is None))


def solve(
    problem: ContactProblem,
    solver: str = "auto",
    tol: float = 1e-8,
    *,
    max_iterations: int | None = None,
    max_time: float = math.inf,
    warm_start: FloatArray | None = None,
) -> ContactSolution:
    """Solve a contact problem and certify the answer.

    Parameters
    ----------
    problem
        What to solve.
    solver
        A name from `solver_names`, or "auto".
    tol
        Wanted velocity error, rounding and energy gap, see `Residuals`: all are relative to the problem's
        own.
    max_iterations, max_time
        Bounds, see `SolverSettings`; up to 128 contacts on exact cones the time is kept by estimate.
    warm_start
        (n, 3) forces to start from, or `problem.shape`; see `problem.warm_start` for contacts that
        came and went.

    Returns
    -------
    ContactSolution
        Also for a problem that could not be solved: look at `status`, or call `raise_if_failed`.

    Raises
    ------
    SolverNotFound
        If the name is unknown or its package is missing.
    ProblemError
        If the solver does not take this law or these cones, or a setting is out of range.
    """
    start = _clock()
    of_kind("problem", problem, ContactProblem)
    entry = _REGISTRY.get(solver) if type(solver) is str else None
    if (
        type(tol) is not float
        or type(max_time) is not float
        or not (0.0 <= tol < _INFINITY and max_time >= 0.0)
    ):
        tol = real_number("tol", tol, low=0.0, high=1e300)
        max_time = real_number("max_time", max_time, low=0.0)
    if max_iterations is not None:
        max_iterations = whole_number("max_iterations", max_iterations)
    if warm_start is not None:
        warm_start = finite_array("warm_start", warm_start, problem.shape)
    if entry is None:
        entry = find_solver(solver, problem)
    before, end = 0, _INFINITY if max_time == _INFINITY else working_time() + max_time
    if entry.attempt is not None:
        first = entry.attempt(problem, tol, max_iterations, max_time, warm_start)
        if first is not None:
            record, before, solved, _ = first
            if solved:
                return ContactSolution(problem, record, _SOLVED, solver, before, _clock() - start)
            warm_start = record[: problem.contacts]
    entry = find_solver(solver, problem)
    if problem.contacts == 0:
        answer = Answer(np.zeros(problem.shape), 0)
    else:
        remaining = None if max_iterations is None else max_iterations - before
        left = max(end - working_time(), 0.0)
        # the certificate says what became of it
        with np.errstate(all="ignore"), light_blas(problem.g.size):
            answer = entry.function(problem, SolverSettings(tol, remaining, left), warm_start)
    answer = answer._replace(iterations=before + answer.iterations)
    found = certify(problem, answer, entry.name, tol, _clock() - start)
    left = end - working_time()
    if found.status not in GAVE_UP or entry.proves or left <= 0.0:
        return found
    with np.errstate(all="ignore"), light_blas(problem.g.size):
        proof = find_proof(problem, left)
    if proof is not None:
        return certify(problem, answer._replace(proof=proof), entry.name, tol, _clock() - start)
    return found


def start_forces(problem: ContactProblem, warm_start: FloatArray | None) -> FloatArray:
    """Return the flat (m,) forces to start from, a fresh array: zero without a warm start."""
    return np.zeros(problem.g.size) if warm_start is None else warm_start.flatten()


def certify(
    problem: ContactProblem, answer: Answer, name: str, tol: float, solve_time: float
) -> ContactSolution:
    """Return the solution with a status that the residuals bear out, whatever the solver believes.

    Forces that are not finite are replaced by the admissible ones nearest to zero.
    """
    forces = np.ascontiguousarray(answer.forces, dtype=np.float64).reshape(problem.shape)
    if not np.isfinite(forces).all():
        forces = nearest_to_zero(problem)
    still = problem.scales[1] == 0.0
    if still.any():  # parts without any velocity: their solution is known
        counts = np.diff(problem.contact_set.offsets) if problem.general else 3
        rows = np.repeat(still, counts).reshape(problem.shape)
        forces = np.where(rows, nearest_to_zero(problem), forces)
    velocities, numbers = certificate(problem, forces)
    error, rest = numbers[0], max(numbers[1], numbers[2])
    # a solver's word for infeasible counts for nothing without a proof
    stop = Status.STALLED if answer.stop is Status.INFEASIBLE else answer.stop
    if error <= tol and rest <= tol:
        status, proof = Status.SOLVED, None
    elif answer.proof is not None:
        status, proof = Status.INFEASIBLE, answer.proof
    elif math.isnan(error):
        status, proof = Status.INVALID, None
    # only the velocity error may be too large for ALMOST: rounding and
    # energy gap are bounds on what can be known
    elif error <= ALMOST_FACTOR * tol and rest <= tol:
        status, proof = Status.ALMOST, None
    else:
        status, proof = stop, None
    record = record_of(forces, velocities, numbers)
    return ContactSolution(problem, record, status, name, answer.iterations, solve_time, proof)


def nearest_to_zero(problem: ContactProblem) -> FloatArray:
    """Return the admissible forces nearest to zero, in the problem's shape: (n, 3), (n, d) or (m,)."""
    if problem.general:
        return problem.contact_set.nearest_to_zero()
    forces = np.zeros((problem.contacts, 3))
    forces[:, 2] = np.maximum(problem.normal_min, 0.0)
    return forces


def find_solver(name: str, problem: ContactProblem) -> SolverEntry:
    """Return the entry of a solver that takes the problem; see `solve` for the errors."""
    if isinstance(name, str) and name in SOLVERS:  # the others are not needed
        SOLVERS.load(name)
    if not isinstance(name, str) or (name not in _REGISTRY and name not in registry()):
        raise SolverNotFound(unknown_name("solver", name, registry()))
    entry = _REGISTRY[name]
    reason = mismatch(entry, problem)
    if reason is not None:
        raise ProblemError(f"{name} {reason}; solvers that do: {', '.join(solver_names(problem)) or 'none'}")
    return entry


def mismatch(entry: SolverEntry, problem: ContactProblem) -> str | None:
    """Return why a solver does not take a problem, or None."""
    if entry.laws is not None and problem.law not in entry.laws:
        return f"does not solve law={str(problem.law)!r}"
    if entry.general:
        return None
    if problem.general:
        return "takes contacts of three rows under Coulomb's or the convex law only"
    if problem.facets is None and not entry.exact:
        return "takes pyramids only (use problem.polyhedral(facets))"
    if problem.facets is not None and not entry.polyhedral:
        return "takes exact cones only (facets=None)"
    if problem.bilateral is not None and not entry.bilateral:
        return "takes no bilateral contacts"
    if not entry.bounds and problem.bounded:
        return "takes no normal bounds"
    return None
