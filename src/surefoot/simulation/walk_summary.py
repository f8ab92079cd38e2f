"""Moved, see below; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(
    __name__, {"summarise_walk": ("surefoot.simulation.old", "surefoot.audit.summarise_walk")}
)
