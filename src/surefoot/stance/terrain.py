"""Moved to `surefoot.terrain`."""

from surefoot.deprecation import moved

_HOMES = dict.fromkeys(("FlatTerrain", "SlopeTerrain", "Terrain"), "surefoot.terrain")
__getattr__ = moved(__name__, _HOMES)
