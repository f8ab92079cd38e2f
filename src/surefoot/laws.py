"""Contact laws by name: `surefoot.laws.COULOMB`, `surefoot.laws.HuntCrossley(stiffness=2e5, ...)`."""

from surefoot.contact.laws import CONVEX, COULOMB, Law
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
    validate_law,
)

__all__ = [
    "CONVEX",
    "COULOMB",
    "Behaviour",
    "ExactFriction",
    "ForceJacobian",
    "Friction",
    "Hertz",
    "HuntCrossley",
    "Law",
    "Linearisation",
    "MujocoLaw",
    "RegularisedFriction",
    "SoftLaw",
    "SpringDamper",
    "behaviour",
    "rebound",
    "validate_law",
]
