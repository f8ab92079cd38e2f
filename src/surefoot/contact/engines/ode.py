"""ODE's and Bullet's words: ERP and CFM, which mean a spring only together with the step.

ODE's manual, "How to use ERP and CFM": ERP = dt k / (dt k + d), CFM = 1 / (dt k + d).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from surefoot.arrays import real_number
from surefoot.contact.engines.engine import EngineContact, Situation
from surefoot.contact.engines.physical import implicit_linear, require_dt
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class OdeContact(EngineContact):
    """Error reduction and constraint force mixing of one contact joint.

    Attributes
    ----------
    soft_erp
        Share of the overlap that a step takes away, in (0, 1].
    soft_cfm
        [m/s per N], > 0.
    """

    engine: ClassVar[str] = "ode"
    soft_erp: float
    soft_cfm: float

    def law(self, situation: Situation) -> SoftLaw:
        """Return the spring-damper at the situation's step; k dt of the damping is the implicit step's."""
        dt = require_dt(situation)
        erp = real_number("soft_erp", self.soft_erp, low=0.0, high=1.0)
        if not (erp > 0.0 and self.soft_cfm > 0.0):
            raise ProblemError(
                f"soft_erp and soft_cfm must be > 0 to mean a spring, got {erp:g} and {self.soft_cfm:g}"
            )
        return SpringDamper(erp / (dt * self.soft_cfm), 1.0 / self.soft_cfm)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return ERP and CFM at the situation's step, and what is lost."""
        dt = require_dt(situation)
        stiffness, damping, lost = implicit_linear(law, situation)
        lost.append(f"ERP and CFM belong to the step of {dt:g} s: with another they mean another spring")
        total = dt * stiffness + damping
        return cls(dt * stiffness / total, 1.0 / total), lost


@dataclass(frozen=True)
class BulletContact(EngineContact):
    """`contactStiffness` [N/m] and `contactDamping` [N s/m], which Bullet turns into ERP and CFM itself.

    Those of the contact: Bullet puts both bodies' stiffnesses in series and adds their dampings, so that each
    of two equal bodies gets twice the stiffness and half the damping (`settings`).
    """

    engine: ClassVar[str] = "bullet"
    contactStiffness: float  # noqa: N815 - Bullet's own spelling
    contactDamping: float  # noqa: N815

    def law(self, situation: Situation) -> SoftLaw:
        """Return the spring-damper; k dt of the damping is the implicit step's."""
        return SpringDamper(self.contactStiffness, self.contactDamping + situation.dt * self.contactStiffness)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return stiffness and damping, and what is lost."""
        stiffness, damping, lost = implicit_linear(law, situation)
        lost.append(
            "Bullet puts both bodies' stiffnesses in series and adds their dampings: each_body is for two "
            "equal ones, and a ground that was given none is rigid only if it is given a large stiffness"
        )
        return cls(stiffness, damping), lost

    def settings(self) -> dict[str, Any]:
        """Return the contact's numbers, and `changeDynamics` for each of two equal bodies."""
        each = {"contactStiffness": 2.0 * self.contactStiffness, "contactDamping": 0.5 * self.contactDamping}
        return {**super().settings(), "each_body": each}
