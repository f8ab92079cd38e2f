"""Moved, see below; these names work for one release."""

from surefoot.deprecation import moved

__getattr__ = moved(__name__, {"summarise": "surefoot.simulation.old"})
