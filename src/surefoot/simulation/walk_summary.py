"""Moved, see below; these names work for one release."""

from surefoot.deprecation import moved

__getattr__ = moved(__name__, {"summarise_walk": "surefoot.simulation.old"})
