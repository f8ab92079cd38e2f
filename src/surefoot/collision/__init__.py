"""Bodies as simple shapes, and where two of them touch: narrow phase by coal, contact points here."""

from surefoot.collision.fitting import robot_geometry
from surefoot.collision.pairs import PairSearch
from surefoot.collision.shapes import Box, Capsule, Shape, Sphere
from surefoot.collision.solids import Geometry, Solid, ground_solids

__all__ = [
    "Box",
    "Capsule",
    "Geometry",
    "PairSearch",
    "Shape",
    "Solid",
    "Sphere",
    "ground_solids",
    "robot_geometry",
]
