"""Moved to `surefoot.terrain`."""

from surefoot.deprecation import moved

_HOMES = {"StairsTerrain": "surefoot.terrain"}
__getattr__ = moved(__name__, _HOMES)
