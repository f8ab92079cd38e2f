"""Contact laws by name: `surefoot.laws.COULOMB`, `surefoot.laws.HuntCrossley(stiffness=2e5, ...)`."""

from surefoot.contact.laws import CONVEX, COULOMB, Law
from surefoot.contact.laws.pressure import CompliantSolid, PressureField, PressurePatch
from surefoot.contact.laws.soft import (
    Behaviour,
    ExactFriction,
    ForceJacobian,
    Friction,
    Hertz,
    HuntCrossley,
    Linearisation,
    MujocoLaw,
    RegularisedFriction,
    SoftLaw,
    SpringDamper,
    behaviour,
    rebound,
    stable_step,
    stable_step_together,
    validate_law,
)

__all__ = [
    "CONVEX",
    "COULOMB",
    "Behaviour",
    "CompliantSolid",
    "ExactFriction",
    "ForceJacobian",
    "Friction",
    "Hertz",
    "HuntCrossley",
    "Law",
    "Linearisation",
    "MujocoLaw",
    "PressureField",
    "PressurePatch",
    "RegularisedFriction",
    "SoftLaw",
    "SpringDamper",
    "behaviour",
    "rebound",
    "stable_step",
    "stable_step_together",
    "validate_law",
]
