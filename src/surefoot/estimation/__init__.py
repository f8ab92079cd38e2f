"""What motion and recordings tell: contact forces, and the ground's friction, restitution and place."""

from surefoot.estimation.forces import ForceEstimate, estimate_forces
from surefoot.estimation.identify import Estimate, TossFit, identify
from surefoot.estimation.toss_errors import TossErrors
from surefoot.estimation.tosses import Cube, Tosses, read_tosses, write_tosses

__all__ = [
    "Cube",
    "Estimate",
    "ForceEstimate",
    "TossErrors",
    "TossFit",
    "Tosses",
    "estimate_forces",
    "identify",
    "read_tosses",
    "write_tosses",
]
