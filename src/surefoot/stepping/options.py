"""How a step is taken: its length, the contact law and what else it depends on besides the state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from surefoot.arrays import real_number
from surefoot.contact.laws import LAWS
from surefoot.errors import ProblemError, unknown_name

Stabilisation = Literal["projection", "baumgarte", "none"]
STABILISATIONS: tuple[Stabilisation, ...] = get_args(Stabilisation)


@dataclass(frozen=True)
class StepOptions:
    """What every step of a run has in common.

    Attributes
    ----------
    dt
        Length of a step [s].
    restitution
        Newton's coefficient of restitution of impacts, 0 to 1.
    stabilisation
        What undoes penetration: "projection" moves the robot out by the least motion in the metric of M and
        leaves its velocity alone, "baumgarte" asks for a separating velocity (which adds energy), "none"
        lets it be.
    law
        "coulomb", or "convex" to see what that relaxation does: a sliding contact then separates with
        mu ||u_t||, and floats at dt mu ||u_t|| over the ground.
    solver, tol
        For `surefoot.solve`.

    Raises
    ------
    ProblemError
        For a value out of range or an unknown name.
    """

    dt: float = 1e-3
    restitution: float = 0.0
    stabilisation: Stabilisation = "projection"
    law: str = "coulomb"
    solver: str = "auto"
    tol: float = 1e-8

    def __post_init__(self) -> None:
        if self.stabilisation not in STABILISATIONS:
            raise ProblemError(unknown_name("stabilisation", self.stabilisation, STABILISATIONS))
        if self.law not in LAWS:
            raise ProblemError(unknown_name("law", self.law, LAWS))
        object.__setattr__(self, "dt", real_number("dt", self.dt, low=1e-6))
        object.__setattr__(
            self, "restitution", real_number("restitution", self.restitution, low=0.0, high=1.0)
        )
