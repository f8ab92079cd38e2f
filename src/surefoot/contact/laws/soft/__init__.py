"""Compliant contact laws as values; each in a file of its own."""

from surefoot.contact.laws.soft.behaviour import (
    MassOnContact,
    behaviour,
    rebound,
    stable_step,
)
from surefoot.contact.laws.soft.hunt_crossley import Hertz, HuntCrossley
from surefoot.contact.laws.soft.mujoco import MujocoLaw
from surefoot.contact.laws.soft.soft_law import (
    ExactFriction,
    ForceJacobian,
    Friction,
    RegularisedFriction,
    SoftLaw,
)
from surefoot.contact.laws.soft.spring_damper import SpringDamper

__all__ = [
    "ExactFriction",
    "ForceJacobian",
    "Friction",
    "Hertz",
    "HuntCrossley",
    "MassOnContact",
    "MujocoLaw",
    "RegularisedFriction",
    "SoftLaw",
    "SpringDamper",
    "behaviour",
    "rebound",
    "stable_step",
]
