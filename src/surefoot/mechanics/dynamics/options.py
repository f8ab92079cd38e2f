"""How a step is taken: its length, the contact law and what else it depends on besides the state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict, get_args

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name, unknown_name
from surefoot.base.spatial import GRAVITY
from surefoot.contact import LAWS, SoftLaw

Stabilisation = Literal["projection", "baumgarte", "none"]
STABILISATIONS: tuple[Stabilisation, ...] = get_args(Stabilisation)
Impacts = Literal["auto", "located", "stepped"]
IMPACTS: tuple[Impacts, ...] = get_args(Impacts)
ORDERS = (1, 2)
PULL = 0.2
"""Share of a penetration that Baumgarte's term takes back per step."""


class StepSettings(TypedDict, total=False):
    """What `StepOptions` takes beside dt, as keyword arguments of a world; a law of None is Coulomb's."""

    restitution: float
    stabilisation: Stabilisation
    law: str | SoftLaw | None
    solver: str
    solver_tol: float
    order: int
    impacts: Impacts


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
        mu ||u_t||, and floats at dt mu ||u_t|| over the ground. Or a soft law (`surefoot.laws`): restitution
        and stabilisation are then its own affair; its force is that at the end of the step, stable for any
        stiffness. Which friction coefficient holds, the ground says.
    solver, solver_tol
        For `surefoot.solve`.
    order
        Order in dt where forces are smooth. 2: forces in the middle of free motion that is integrated to a
        tolerance. 1: semi-implicit Euler with all forces at the start, one contact problem for the gaps at
        the end: what planners take (`Knot`). "projection" then asks a penetration back within the step, by
        its velocity.
    impacts
        "located": where something in free flight touches within a step, impulse and bounce come at that time
        (`located_impacts`); "stepped": in the middle of the step, as always while other contacts press,
        under a push and in a `Knot`; "auto": located where there is restitution.

    Raises
    ------
    ProblemError
        For a value out of range or an unknown name.
    """

    dt: float = 1e-3
    restitution: float = 0.0
    stabilisation: Stabilisation = "projection"
    law: str | SoftLaw = "coulomb"
    solver: str = "auto"
    solver_tol: float = 1e-8
    order: int = 2
    impacts: Impacts = "auto"

    def __post_init__(self) -> None:
        check_name("stabilisation", self.stabilisation, STABILISATIONS)
        check_name("impacts", self.impacts, IMPACTS)
        if self.soft is not None:
            self._fit_soft_law(self.soft)
        elif self.law not in LAWS:
            raise ProblemError(unknown_name("law", self.law, LAWS))
        if self.order not in ORDERS:
            raise ProblemError(f"order must be 1 or 2, got {self.order!r}")
        if self.order == 1 and self.soft is not None:
            raise ProblemError(f"order=1 takes the laws {', '.join(LAWS)}, got a {type(self.soft).__name__}")
        object.__setattr__(self, "dt", real_number("dt", self.dt, low=1e-6))
        object.__setattr__(
            self, "restitution", real_number("restitution", self.restitution, low=0.0, high=1.0)
        )

    @classmethod
    def of(cls, dt: float, settings: StepSettings) -> StepOptions:
        """Return the options of a step and keyword arguments."""
        given = dict(settings)
        if given.get("law", "") is None:
            del given["law"]
        return cls(dt, **given)  # type: ignore[arg-type]

    @property
    def soft(self) -> SoftLaw | None:
        """The soft law, None where contacts are rigid."""
        return self.law if isinstance(self.law, SoftLaw) else None

    @property
    def pull(self) -> float:
        """Share of a penetration that the laws ask back per step, by the velocity."""
        if self.stabilisation == "projection":
            return 1.0 if self.order == 1 else 0.0
        return PULL if self.stabilisation == "baumgarte" else 0.0

    @property
    def rest_speed(self) -> float:
        """Speed of arrival [m/s] up to which a contact does not bounce: what gravity makes in two steps."""
        # Slower arrivals are those of a contact that rests: without this bound bounces would never end.
        return 2.0 * self.dt * GRAVITY

    @property
    def problem_law(self) -> str:
        """The law of the contact problems: soft laws keep exact Coulomb friction."""
        return "coulomb" if isinstance(self.law, SoftLaw) else self.law

    def _fit_soft_law(self, law: SoftLaw) -> None:
        """Refuse what does not go with a soft law."""
        if self.restitution != 0.0:
            raise ProblemError(
                f"restitution is of rigid contacts, got {self.restitution:g} with a {type(law).__name__}: a "
                "soft law bounces by its own damping, e.g. SpringDamper.bouncing"
            )
        if self.stabilisation == "baumgarte":
            raise ProblemError("stabilisation='baumgarte' is of rigid contacts: overlap is a soft law's own")
        if not law.friction.exact:
            raise ProblemError(
                f"the step solves ExactFriction, which {type(law.friction).__name__} replaces: it is of laws "
                "to be translated and of forces on their own"
            )
        object.__setattr__(self, "stabilisation", "none")
