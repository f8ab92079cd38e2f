"""Where forces may live: one cone per file, one interface."""

from surefoot.cones.cone import Cone
from surefoot.cones.friction import FrictionCone
from surefoot.cones.polyhedral import FitError, FrictionPyramid, PolyhedralCone
from surefoot.cones.product import ProductCone
from surefoot.cones.wrench import WrenchCone

__all__ = [
    "Cone",
    "FitError",
    "FrictionCone",
    "FrictionPyramid",
    "PolyhedralCone",
    "ProductCone",
    "WrenchCone",
]
