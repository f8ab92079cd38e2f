"""The ground: height, slope and frames at a place, and shapes for engines."""

from surefoot.mechanics.terrain.flat import FlatTerrain as FlatTerrain
from surefoot.mechanics.terrain.heightfield import HeightfieldTerrain as HeightfieldTerrain
from surefoot.mechanics.terrain.levels import LevelsTerrain as LevelsTerrain
from surefoot.mechanics.terrain.pit import PitTerrain as PitTerrain
from surefoot.mechanics.terrain.rough import rough_ground as rough_ground
from surefoot.mechanics.terrain.slope import SlopeTerrain as SlopeTerrain
from surefoot.mechanics.terrain.stairs import StairsTerrain as StairsTerrain
from surefoot.mechanics.terrain.surface_shapes import Grid as Grid
from surefoot.mechanics.terrain.surface_shapes import GroundBox as GroundBox
from surefoot.mechanics.terrain.surface_shapes import Plane as Plane
from surefoot.mechanics.terrain.surface_shapes import Shape as Shape
from surefoot.mechanics.terrain.terrain import Terrain as Terrain
from surefoot.mechanics.terrain.terrain_names import TERRAINS as TERRAINS
from surefoot.mechanics.terrain.terrain_names import read_terrain as read_terrain
from surefoot.mechanics.terrain.terrain_names import terrain_forms as terrain_forms
