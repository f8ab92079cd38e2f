"""Contact laws as values; each in a file of its own."""

from surefoot.contact.laws.behaviour import Behaviour, behaviour, rebound
from surefoot.contact.laws.friction import ExactFriction, Friction, RegularisedFriction
from surefoot.contact.laws.hunt_crossley import Hertz, HuntCrossley
from surefoot.contact.laws.mujoco import MujocoLaw
from surefoot.contact.laws.soft import ForceJacobian, Linearisation, SoftLaw
from surefoot.contact.laws.spring_damper import SpringDamper
from surefoot.contact.laws.validation import validate_law

__all__ = [
    "Behaviour",
    "ExactFriction",
    "ForceJacobian",
    "Friction",
    "Hertz",
    "HuntCrossley",
    "Linearisation",
    "MujocoLaw",
    "RegularisedFriction",
    "SoftLaw",
    "SpringDamper",
    "behaviour",
    "rebound",
    "validate_law",
]
