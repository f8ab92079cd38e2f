"""What a solver returns: forces, velocities, and a certificate that it did not write itself."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import NoSolution, ProblemError, count_of
from surefoot.contact.laws import LAWS
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.proof import InfeasibilityProof
from surefoot.contact.problem.residuals import Residuals
from surefoot.contact.problem.set_residuals import Numbers

if TYPE_CHECKING:
    from surefoot.contact.derivative.solution_derivative import ContactDerivative


class Status(Enum):
    """How a solve ended.

    SOLVED means that `Residuals.velocity_error`, `rounding` and `energy_gap`, computed from the problem
    alone, are within the tolerance; ALMOST that the error is within a thousand times of it. INFEASIBLE
    means that there is no solution, and comes with a proof. INVALID: the forces' velocities overflow.
    COMPROMISED is of commands alone: every limit holds, but what was asked for is not met. The others say why
    the solver stopped.
    """

    SOLVED = "solved"
    ALMOST = "almost"
    STALLED = "stalled"
    MAX_ITERATIONS = "max_iterations"
    MAX_TIME = "max_time"
    INFEASIBLE = "infeasible"
    COMPROMISED = "compromised"
    INVALID = "invalid"


def record_of(forces: FloatArray, velocities: FloatArray, numbers: Numbers) -> FloatArray:
    """Return a `ContactSolution`'s record, (2n + 3, 3): forces, velocities, the fields of `Residuals`."""
    rest = np.zeros((-(-len(numbers) // math.prod(forces.shape[1:])), *forces.shape[1:]))
    rest.reshape(-1)[: len(numbers)] = numbers
    return np.concatenate([forces, velocities, rest])


class Certified(Drawn):
    """Forces and velocities, a status and the residuals, read from one record: what every answer is.

    Answers fill its slots themselves: a call for it would take a twentieth of a solve.
    """

    __slots__ = ("_forces", "_record", "_status")
    _record: FloatArray
    _forces: FloatArray
    _status: Status

    @property
    def forces(self) -> FloatArray:
        """The (n, 3) forces [N s, or N]."""
        return self._forces

    @property
    def velocities(self) -> FloatArray:
        """The (n, 3) velocities G @ forces + g [m/s, or m/s²]."""
        n = len(self._forces)
        return self._record[n : 2 * n]

    @property
    def status(self) -> Status:
        """How the solve ended."""
        return self._status

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self._status is Status.SOLVED

    def __str__(self) -> str:
        normal = self._forces.reshape(len(self._forces), -1)[:, -1]
        press = int(np.count_nonzero(normal > 1e-9 * float(normal.max(initial=0.0))))
        most, error = float(normal.max(initial=0.0)), self.residuals.velocity_error
        pressing = f"{press} of {count_of(len(normal), 'contact')} press, at most {most:.4g}"
        return f"{self._status.name}: {pressing}; velocity error {error:.1e}."

    @property
    def residuals(self) -> Residuals:
        """Every law as a number, see `surefoot.contact.problem.residuals`."""
        return Residuals(*self._record[2 * len(self._forces) :].ravel()[:7].tolist())


class ContactSolution(Certified):
    """Forces and velocities of a `ContactProblem`, with their residuals; nothing of it can be set.

    Written out, with slots, because a solve of two microseconds would notice a frozen dataclass.

    Parameters
    ----------
    problem, status, solver, iterations, solve_time, proof
        See the attributes.
    record
        Forces, velocities and the seven numbers of `Residuals` one below the other, in rows as long as those
        of the forces: what a compiled solver fills; see `record_of`.

    Attributes
    ----------
    problem
        What was asked.
    forces, velocities
        (n, 3) in contact frames (tangent, tangent, normal), or `problem.shape`; velocities are G forces + g.
        Impulses [N s] and velocities [m/s], or forces [N] and accelerations [m/s²]: what the problem is in.
    status
        See `Status`.
    residuals
        Every law as a number, see `surefoot.contact.problem.residuals`.
    solver
        Name of the solver that ran.
    iterations
        Its iterations (what one is depends on the solver).
    solve_time
        Wall time inside the solver [s].
    proof
        The proof that there is no solution where the status is INFEASIBLE, else None.
    """

    __slots__ = ("_iterations", "_problem", "_proof", "_solve_time", "_solver")

    def __init__(
        self,
        problem: ContactProblem,
        record: FloatArray,
        status: Status,
        solver: str,
        iterations: int,
        solve_time: float,
        proof: InfeasibilityProof | None = None,
    ) -> None:
        self._record, self._forces, self._status = record, record[: problem.shape[0]], status
        self._problem = problem
        self._solver = solver
        self._iterations = iterations
        self._solve_time = solve_time
        self._proof = proof

    @property
    def problem(self) -> ContactProblem:
        """What was asked."""
        return self._problem

    @property
    def solver(self) -> str:
        """Name of the solver that ran."""
        return self._solver

    @property
    def iterations(self) -> int:
        """The solver's iterations."""
        return self._iterations

    @property
    def solve_time(self) -> float:
        """Wall time inside the solver [s]."""
        return self._solve_time

    @property
    def proof(self) -> InfeasibilityProof | None:
        """The proof of INFEASIBLE, else None."""
        return self._proof

    def __repr__(self) -> str:
        error = self.residuals.velocity_error
        return (
            f"ContactSolution({self._status.name}, solver={self._solver!r}, contacts={len(self._forces)}, "
            f"velocity_error={error:.1e}, iterations={self._iterations}, solve_time={self._solve_time:.3g})"
        )

    def derivative(self, smoothing: float = 0.0, kink_tol: float = 1e-9) -> ContactDerivative:
        """Return the derivative of forces and velocities, see `ContactDerivative`.

        Parameters
        ----------
        smoothing
            0 for the law itself; else normal force times normal velocity on the central path [W].
        kink_tol
            Distance below which a contact counts as about to change its mode, see `Kink.distance`.

        Raises
        ------
        NoSolution
            If the status is anything but SOLVED.
        ProblemError
            If an argument is out of range.
        """
        from surefoot.contact.derivative.solution_derivative import ContactDerivative

        self.raise_if_failed()
        if self.problem.general or self.problem.law not in LAWS:
            raise ProblemError(
                f"derivatives take contacts of three rows under {' or '.join(LAWS)}, not other kinds of "
                f"contact or the law {str(self.problem.law)!r}"
            )
        smoothing = real_number("smoothing", smoothing, low=0.0, high=1e300)
        kink_tol = real_number("kink_tol", kink_tol, low=0.0, high=1.0)
        return ContactDerivative(self.problem, self.forces, self.velocities, smoothing, kink_tol)

    def raise_if_failed(self) -> ContactSolution:
        """Return the solution itself if solved.

        Raises
        ------
        NoSolution
            If the status is anything but SOLVED; it carries the problem and this solution.
        """
        if not self.solved:
            raise NoSolution(
                f"{self.solver} ended with status {self.status.value!r} "
                f"(velocity error {self.residuals.velocity_error:.1e} after {self.iterations} iterations)",
                self.problem,
                self,
            )
        return self
