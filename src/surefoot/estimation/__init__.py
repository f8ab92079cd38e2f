"""What recordings say about the ground: friction, restitution, stiffness, and where it is."""

from surefoot.estimation.identify import Estimate, TossFit, identify
from surefoot.estimation.toss_errors import TossErrors
from surefoot.estimation.tosses import Cube, Tosses, read_tosses, write_tosses

__all__ = [
    "Cube",
    "Estimate",
    "TossErrors",
    "TossFit",
    "Tosses",
    "identify",
    "read_tosses",
    "write_tosses",
]
