"""Bodies as simple shapes, and where two of them touch: narrow phase by coal, contact points here."""

from surefoot.collision.fitting import robot_geometry as robot_geometry
from surefoot.collision.pairs import PairSearch as PairSearch
from surefoot.collision.shapes import Box as Box
from surefoot.collision.shapes import Capsule as Capsule
from surefoot.collision.shapes import Shape as Shape
from surefoot.collision.shapes import Sphere as Sphere
from surefoot.collision.solids import Geometry as Geometry
from surefoot.collision.solids import Solid as Solid
from surefoot.collision.solids import ground_solids as ground_solids
