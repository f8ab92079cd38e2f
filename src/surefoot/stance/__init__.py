"""Who touches what, where, and with which friction."""

from surefoot.stance.contact import Contact, PatchContact, PointContact
from surefoot.stance.stance import Stance
from surefoot.stance.terrain import FlatTerrain, SlopeTerrain, Terrain

__all__ = ["Contact", "FlatTerrain", "PatchContact", "PointContact", "SlopeTerrain", "Stance", "Terrain"]
