"""What a solver returns: forces, velocities, and a certificate that it did not write itself."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from surefoot.arrays import FloatArray, real_number
from surefoot.contact.problem import ContactProblem
from surefoot.contact.proof import InfeasibilityProof
from surefoot.contact.residuals import Residuals
from surefoot.errors import NoSolution

if TYPE_CHECKING:
    from surefoot.contact.derivative import ContactDerivative

Details = tuple[FloatArray, Residuals, dict[str, float], InfeasibilityProof | None]
"""Velocities, residuals, timings and the proof of INFEASIBLE."""


class Status(Enum):
    """How a solve ended.

    SOLVED means that `Residuals.velocity_error`, `rounding` and `energy_gap`, computed from the problem
    alone, are within the tolerance; ALMOST that the error is within a thousand times of it. INFEASIBLE
    means that there is no solution, and comes with a proof. INVALID: the forces' velocities overflow. The
    others say why the solver stopped.
    """

    SOLVED = "solved"
    ALMOST = "almost"
    STALLED = "stalled"
    MAX_ITERATIONS = "max_iterations"
    MAX_TIME = "max_time"
    INFEASIBLE = "infeasible"
    INVALID = "invalid"


class ContactSolution:
    """Forces and velocities of a `ContactProblem`, with their residuals; nothing of it can be set.

    Written out, with slots, because a solve of two microseconds would notice a frozen dataclass.

    Parameters
    ----------
    problem, forces, status, solver, iterations, solve_time
        See the attributes.
    rest
        Velocities, residuals, timings and proof; or the (2n + 3, 3) buffer of a compiled solver, from which
        they are cut when first read: forces, velocities, and the seven numbers of `Residuals`.

    Attributes
    ----------
    problem
        What was asked.
    forces, velocities
        (n, 3), contact frames (tangent, tangent, normal); velocities are G @ forces + g.
    status
        See `Status`.
    residuals
        Every law as a number, see `surefoot.contact.residuals`.
    solver
        Name of the solver that ran.
    iterations
        Its iterations (what one is depends on the solver).
    solve_time
        Wall time inside the solver [s].
    timings
        Parts of the solve, name to seconds, where the solver tells.
    proof
        The proof that there is no solution where the status is INFEASIBLE, else None.
    """

    __slots__ = ("_forces", "_iterations", "_problem", "_rest", "_solve_time", "_solver", "_status")

    def __init__(
        self,
        problem: ContactProblem,
        forces: FloatArray,
        status: Status,
        solver: str,
        iterations: int,
        solve_time: float,
        rest: Details | FloatArray,
    ) -> None:
        self._problem = problem
        self._forces = forces
        self._status = status
        self._solver = solver
        self._iterations = iterations
        self._solve_time = solve_time
        self._rest = rest

    @property
    def problem(self) -> ContactProblem:
        """What was asked."""
        return self._problem

    @property
    def forces(self) -> FloatArray:
        """The (n, 3) forces."""
        return self._forces

    @property
    def velocities(self) -> FloatArray:
        """The (n, 3) velocities G @ forces + g."""
        return self._details()[0]

    @property
    def status(self) -> Status:
        """How the solve ended."""
        return self._status

    @property
    def residuals(self) -> Residuals:
        """Every law as a number."""
        return self._details()[1]

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
    def timings(self) -> dict[str, float]:
        """Parts of the solve, name to seconds."""
        return self._details()[2]

    @property
    def proof(self) -> InfeasibilityProof | None:
        """The proof of INFEASIBLE, else None."""
        return self._details()[3]

    def _details(self) -> Details:
        """Return what `rest` holds; cut it out of the buffer the first time."""
        found = self._rest
        if not isinstance(found, tuple):
            n = self._problem.contacts
            numbers = found[2 * n :].ravel()[:7].tolist()
            found = self._rest = (found[n : 2 * n], Residuals(*numbers), {}, None)
        return found

    def __repr__(self) -> str:
        return (
            f"ContactSolution(status={self._status}, solver={self._solver!r}, iterations={self._iterations}, "
            f"solve_time={self._solve_time:.3g}, forces={self._forces!r}, residuals={self.residuals!r})"
        )

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED

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
        from surefoot.contact.derivative import ContactDerivative

        self.raise_if_failed()
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
