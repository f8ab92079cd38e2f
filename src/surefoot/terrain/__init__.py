"""The ground: height, slope and frames at a place, and shapes for engines."""

from surefoot.terrain.flat import FlatTerrain
from surefoot.terrain.heightfield import HeightfieldTerrain
from surefoot.terrain.levels import LevelsTerrain
from surefoot.terrain.pit import PitTerrain
from surefoot.terrain.rough import rough_ground
from surefoot.terrain.shapes import Box, Grid, Plane, Shape
from surefoot.terrain.slope import SlopeTerrain
from surefoot.terrain.stairs import StairsTerrain
from surefoot.terrain.table import TERRAINS, read_terrain, terrain_forms
from surefoot.terrain.terrain import Terrain

__all__ = [
    "TERRAINS",
    "Box",
    "FlatTerrain",
    "Grid",
    "HeightfieldTerrain",
    "LevelsTerrain",
    "PitTerrain",
    "Plane",
    "Shape",
    "SlopeTerrain",
    "StairsTerrain",
    "Terrain",
    "read_terrain",
    "rough_ground",
    "terrain_forms",
]
