"""Drake's words: point stiffness with relaxation time (SAP) or dissipation, hydroelastic modulus.

Drake's documentation, "Hydroelastic contact" and `MultibodyPlant`, "Modeling of contact": of two bodies,
stiffness is k1 k2 / (k1 + k2), dissipation weighed by the other's stiffness, relaxation times add up. What
its step cannot resolve SAP takes for nearly rigid: 1 / (dt (dt + tau) k) is at least 1 / (4 π² m) (A. Castro
et al., "An unconstrained convex formulation of compliant contact", IEEE T-RO 2022, with beta = 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from surefoot.contact.engines.engine import EngineContact, Situation
from surefoot.contact.engines.physical import hunt_crossley, implicit_linear
from surefoot.contact.laws.soft.hunt_crossley import HuntCrossley
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class DrakeContact(EngineContact):
    """Point contact with discrete approximation "sap": f = point_stiffness (depth + relaxation_time rate).

    Attributes
    ----------
    point_stiffness
        Of the contact [N/m]; give twice as much to each of two equal bodies.
    relaxation_time
        Of the contact [s]; give half to each of two bodies.
    """

    engine: ClassVar[str] = "drake"
    point_stiffness: float
    relaxation_time: float

    def law(self, situation: Situation) -> SoftLaw:
        """Return the linear spring and damper; SAP softens what its step cannot resolve.

        The implicit step adds k dt of damping.
        """
        step, time = situation.dt, self.relaxation_time
        regularised = step * (step + time) * self.point_stiffness
        rigid = 4.0 * math.pi**2 * situation.mass
        stiffness = self.point_stiffness * min(1.0, rigid / regularised if regularised else 1.0)
        return SpringDamper(stiffness, stiffness * (time + step))

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return point stiffness and relaxation time, and what is lost."""
        stiffness, damping, lost = implicit_linear(law, situation)
        return cls(stiffness, damping / stiffness), lost

    def settings(self) -> dict[str, Any]:
        """Return the contact's numbers, and the proximity properties of each of two equal bodies."""
        return {
            **super().settings(),
            "discrete_contact_approximation": "sap",
            "each_body": {
                "point_contact_stiffness": 2.0 * self.point_stiffness,
                "relaxation_time": 0.5 * self.relaxation_time,
            },
        }


@dataclass(frozen=True)
class DrakeHuntCrossleyContact(EngineContact):
    """Point contact with "tamsi", "similar" or "lagged", or in continuous time.

    Attributes
    ----------
    point_stiffness
        Of the contact [N/m]; give twice as much to each of two equal bodies.
    hunt_crossley_dissipation
        [s/m], the same for each of two equal bodies.
    """

    engine: ClassVar[str] = "drake-hunt-crossley"
    implicit: ClassVar[bool] = True
    point_stiffness: float
    hunt_crossley_dissipation: float

    def law(self, situation: Situation) -> SoftLaw:
        """Return the Hunt-Crossley law of exponent 1."""
        return HuntCrossley(self.point_stiffness, self.hunt_crossley_dissipation)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return stiffness and dissipation, and what is lost."""
        stiffness, dissipation, lost = hunt_crossley(law, situation)
        return cls(stiffness, dissipation), lost

    def settings(self) -> dict[str, Any]:
        """Return the contact's numbers, and the proximity properties of each of two equal bodies."""
        return {
            **super().settings(),
            "discrete_contact_approximation": "lagged",
            "each_body": {
                "point_contact_stiffness": 2.0 * self.point_stiffness,
                "hunt_crossley_dissipation": self.hunt_crossley_dissipation,
            },
        }


@dataclass(frozen=True)
class DrakeHydroelasticContact(EngineContact):
    """A flat compliant layer on rigid ground: pressure = modulus depth / thickness, over its area.

    Attributes
    ----------
    hydroelastic_modulus
        [Pa].
    hunt_crossley_dissipation
        [s/m].
    area, thickness
        Of the layer [m²], [m].
    """

    engine: ClassVar[str] = "drake-hydroelastic"
    implicit: ClassVar[bool] = True
    hydroelastic_modulus: float
    hunt_crossley_dissipation: float
    area: float
    thickness: float

    def law(self, situation: Situation) -> SoftLaw:
        """Return the law of the layer pressed flat."""
        stiffness = self.hydroelastic_modulus * self.area / self.thickness
        return HuntCrossley(stiffness, self.hunt_crossley_dissipation)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return the modulus for the situation's area and thickness, and what is lost."""
        if not (situation.area > 0.0 and situation.thickness > 0.0):
            raise ProblemError("a hydroelastic modulus needs the sole: area [m²] and thickness [m], both > 0")
        stiffness, dissipation, lost = hunt_crossley(law, situation)
        lost.append("the contact is a flat layer: tilting stiffness follows from its shape, not from the law")
        modulus = stiffness * situation.thickness / situation.area
        return cls(modulus, dissipation, situation.area, situation.thickness), lost
