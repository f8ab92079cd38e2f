"""Bodies as simple shapes, and where two of them touch: narrow phase by coal, contact points here."""

from surefoot.mechanics.collision.fitting import robot_geometry as robot_geometry
from surefoot.mechanics.collision.pairs import PairSearch as PairSearch
from surefoot.mechanics.collision.rounded_shapes import Box as Box
from surefoot.mechanics.collision.rounded_shapes import Capsule as Capsule
from surefoot.mechanics.collision.rounded_shapes import Shape as Shape
from surefoot.mechanics.collision.rounded_shapes import Sphere as Sphere
from surefoot.mechanics.collision.solids import Geometry as Geometry
from surefoot.mechanics.collision.solids import Solid as Solid
from surefoot.mechanics.collision.solids import ground_solids as ground_solids
