"""Where forces may live: one cone per file, one interface."""

from surefoot.contact.cones.cone import Cone as Cone
from surefoot.contact.cones.friction import FrictionCone as FrictionCone
from surefoot.contact.cones.polyhedral import FitError as FitError
from surefoot.contact.cones.polyhedral import FrictionPyramid as FrictionPyramid
from surefoot.contact.cones.polyhedral import PolyhedralCone as PolyhedralCone
from surefoot.contact.cones.polyhedral import RayCone as RayCone
from surefoot.contact.cones.product import ProductCone as ProductCone
from surefoot.contact.cones.sole import Sole as Sole
