"""What one engine's contact parameters must be able to do, and the table of engines."""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.errors import check_name
from surefoot.spatial import GRAVITY

ENGINES: dict[str, tuple[str, str]] = {
    "physical": ("physical", "PhysicalContact"),
    "hunt-crossley": ("physical", "HuntCrossleyContact"),
    "mujoco": ("mujoco", "MujocoContact"),
    "drake": ("drake", "DrakeContact"),
    "drake-hunt-crossley": ("drake", "DrakeHuntCrossleyContact"),
    "drake-hydroelastic": ("drake", "DrakeHydroelasticContact"),
    "physx": ("physx", "PhysxContact"),
    "isaaclab": ("physx", "IsaacLabContact"),
    "ode": ("ode", "OdeContact"),
    "bullet": ("ode", "BulletContact"),
}
"""Name -> (file of this folder, class): an engine is one file and one line."""


@dataclass(frozen=True)
class Situation:
    """The situation in which a translation is asked.

    Attributes
    ----------
    mass
        Effective mass of the contact, 1 / G_nn [kg]: of a robot on four feet about a quarter of its own.
    gravity
        [m/s²].
    speed
        Impact speed at which bounces are compared [m/s].
    dt
        The engine's step [s].
    area, thickness
        Of a flat compliant layer, for hydroelastic moduli [m²], [m]; 0 if unknown.
    keep
        What is kept where rest depth and motion cannot both be: "motion" or "rest".
    impedance
        MuJoCo's d of the translated contact.
    """

    mass: float
    gravity: float = GRAVITY
    speed: float = 1.0
    dt: float = 1e-3
    area: float = 0.0
    thickness: float = 0.0
    keep: str = "motion"
    impedance: float = 1e-3

    @property
    def weight(self) -> float:
        """Return what the contact carries at rest [N]."""
        return self.mass * self.gravity


@dataclass(frozen=True)
class EngineContact(ABC):
    """Contact parameters in one engine's words."""

    engine: ClassVar[str]
    implicit: ClassVar[bool] = False
    """Whether the engine's implicit step adds damping that its words cannot take off again."""

    @abstractmethod
    def law(self, situation: Situation) -> SoftLaw:
        """Return the contact law that the engine makes of them."""

    @classmethod
    @abstractmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return the parameters that come closest to a law, and in words what is lost."""

    def settings(self) -> dict[str, Any]:
        """Return the parameters as the engine's own fields."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}


def engine_named(name: str) -> type[EngineContact]:
    """Return the class of an engine's contact parameters.

    Raises
    ------
    ProblemError
        For an unknown name; the message lists the names.
    """
    check_name("engine", name, ENGINES)
    file, kind = ENGINES[name]
    found: type[EngineContact] = getattr(importlib.import_module(f"surefoot.contact.engines.{file}"), kind)
    return found
