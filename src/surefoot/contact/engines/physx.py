"""PhysX's and Isaac Lab's words: compliant contact stiffness and damping on a material."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from surefoot.contact.engines.engine import EngineContact, Situation
from surefoot.contact.engines.physical import implicit_linear
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper

PER_POINT = "a stiffness counts per contact point: PhysX gives a flat sole up to four, which share the load"


@dataclass(frozen=True)
class PhysxContact(EngineContact):
    """A material with compliant contact: an implicit spring [N/m] and damper [N s/m].

    A material's restitution is not used where it is compliant.
    """

    engine: ClassVar[str] = "physx"
    compliant_contact_stiffness: float
    compliant_contact_damping: float

    def law(self, situation: Situation) -> SoftLaw:
        """Return the spring-damper; k dt of the damping is the implicit step's."""
        stiffness = self.compliant_contact_stiffness
        return SpringDamper(stiffness, self.compliant_contact_damping + situation.dt * stiffness)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return stiffness and damping, and what is lost."""
        stiffness, damping, lost = implicit_linear(law, situation)
        lost.append(PER_POINT)
        return cls(stiffness, damping), lost


@dataclass(frozen=True)
class IsaacLabContact(PhysxContact):
    """The same as fields of Isaac Lab's `RigidBodyMaterialCfg`."""

    engine: ClassVar[str] = "isaaclab"
    static_friction: float = 0.6
    dynamic_friction: float = 0.6

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return the material's fields, friction included, and what is lost."""
        contact, lost = super().from_law(law, situation)
        mu = law.friction.mu
        return replace(contact, static_friction=mu, dynamic_friction=mu), lost  # type: ignore[call-arg]

    def settings(self) -> dict[str, Any]:
        """Return the fields of the config."""
        return {
            **super().settings(),
            "restitution": 0.0,
            "friction_combine_mode": "average",
            "restitution_combine_mode": "average",
        }
