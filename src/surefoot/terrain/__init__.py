"""The ground: height, slope and frames at a place, and shapes for engines."""

from surefoot.terrain.flat import FlatTerrain as FlatTerrain
from surefoot.terrain.heightfield import HeightfieldTerrain as HeightfieldTerrain
from surefoot.terrain.levels import LevelsTerrain as LevelsTerrain
from surefoot.terrain.pit import PitTerrain as PitTerrain
from surefoot.terrain.rough import rough_ground as rough_ground
from surefoot.terrain.shapes import Grid as Grid
from surefoot.terrain.shapes import GroundBox as GroundBox
from surefoot.terrain.shapes import Plane as Plane
from surefoot.terrain.shapes import Shape as Shape
from surefoot.terrain.slope import SlopeTerrain as SlopeTerrain
from surefoot.terrain.stairs import StairsTerrain as StairsTerrain
from surefoot.terrain.table import TERRAINS as TERRAINS
from surefoot.terrain.table import read_terrain as read_terrain
from surefoot.terrain.table import terrain_forms as terrain_forms
from surefoot.terrain.terrain import Terrain as Terrain
