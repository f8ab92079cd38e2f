"""Where forces may live: one cone per file, one interface."""

from surefoot.cones.cone import Cone as Cone
from surefoot.cones.friction import FrictionCone as FrictionCone
from surefoot.cones.polyhedral import FitError as FitError
from surefoot.cones.polyhedral import FrictionPyramid as FrictionPyramid
from surefoot.cones.polyhedral import PolyhedralCone as PolyhedralCone
from surefoot.cones.product import ProductCone as ProductCone
from surefoot.cones.wrench import WrenchCone as WrenchCone
