"""Who touches what, where, and with which friction."""

from surefoot.stance.batch import StanceBatch
from surefoot.stance.contact import Contact, PatchContact, PointContact
from surefoot.stance.files import StanceQuestion, read_stance, write_stance
from surefoot.stance.grasp import grasp_map
from surefoot.stance.halfspaces import HalfSpaces
from surefoot.stance.heightfield import HeightfieldTerrain
from surefoot.stance.stairs import StairsTerrain
from surefoot.stance.stance import Stance
from surefoot.stance.terrain import FlatTerrain, SlopeTerrain, Terrain

__all__ = [
    "Contact",
    "FlatTerrain",
    "HalfSpaces",
    "HeightfieldTerrain",
    "PatchContact",
    "PointContact",
    "SlopeTerrain",
    "StairsTerrain",
    "Stance",
    "StanceBatch",
    "StanceQuestion",
    "Terrain",
    "grasp_map",
    "read_stance",
    "write_stance",
]
