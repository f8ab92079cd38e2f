"""What a solver returns: forces, velocities, and a certificate that it did not write itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.residuals import Residuals
from surefoot.errors import NoSolution


class Status(Enum):
    """How a solve ended.

    SOLVED means that the residual, computed from the problem alone, is below the tolerance; ALMOST
    that it is within a thousand times of it. The others say why the solver stopped above that.
    """

    SOLVED = "solved"
    ALMOST = "almost"
    STALLED = "stalled"
    MAX_ITERATIONS = "max_iterations"
    MAX_TIME = "max_time"
    INFEASIBLE = "infeasible"
    INVALID = "invalid"


@dataclass(frozen=True)
class ContactSolution:
    """Forces and velocities of a `ContactProblem`, with their residuals.

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
    """

    problem: ContactProblem
    forces: FloatArray
    velocities: FloatArray
    status: Status
    residuals: Residuals
    solver: str
    iterations: int
    solve_time: float
    timings: dict[str, float] = field(default_factory=dict)

    def __getattr__(self, name: str) -> Any:
        """Cut a field out of the buffer; called only for what is not there yet."""
        fields = self.__dict__
        if "buffer" not in fields or name not in ("velocities", "residuals", "timings"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        buffer, n = fields["buffer"], fields["problem"].contacts
        if name == "velocities":
            fields[name] = buffer[n : 2 * n]
        elif name == "residuals":
            fields[name] = Residuals(*buffer[2 * n :].ravel()[:5].tolist())
        else:
            fields[name] = {}
        return fields[name]

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED

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
                f"(natural map {self.residuals.natural_map:.1e} after {self.iterations} iterations)",
                self.problem,
                self,
            )
        return self


def from_buffer(
    problem: ContactProblem,
    buffer: FloatArray,
    solver: str,
    iterations: int,
    solve_time: float,
    _new: Callable[[type[ContactSolution]], ContactSolution] = object.__new__,
    _fill: Callable[[ContactSolution, str, dict[str, Any]], None] = object.__setattr__,
    _solved: Status = Status.SOLVED,
) -> ContactSolution:
    """Return a solved solution whose velocities and residuals are cut out of a buffer when first read.

    The buffer is (2n + 2, 3): forces, velocities, and the numbers of `Residuals`. Frozen dataclasses fill
    field by field; for a call of two microseconds that matters, as does where names are looked up.
    """
    found = _new(ContactSolution)
    fields = {
        "problem": problem,
        "buffer": buffer,
        "forces": buffer[: problem.contacts],
        "status": _solved,
        "solver": solver,
        "iterations": iterations,
        "solve_time": solve_time,
    }
    _fill(found, "__dict__", fields)
    return found
