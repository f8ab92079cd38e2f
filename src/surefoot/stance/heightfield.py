"""Moved to `surefoot.terrain`."""

from surefoot.deprecation import moved

_HOMES = {"HeightfieldTerrain": "surefoot.terrain"}
__getattr__ = moved(__name__, _HOMES)
