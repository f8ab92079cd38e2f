"""What motion and recordings tell: contact forces, and the ground's friction, restitution and place."""

from surefoot.estimation.contact_detection import (
    ContactDetector,
    Detection,
    DetectionErrors,
    DetectionSettings,
    detect_contacts,
    detection_errors,
)
from surefoot.estimation.forces import ForceEstimate, estimate_forces
from surefoot.estimation.friction import FrictionBounds, FrictionTracker
from surefoot.estimation.identify import Estimate, TossFit, identify
from surefoot.estimation.toss_errors import TossErrors
from surefoot.estimation.tosses import Cube, Tosses, read_tosses, write_tosses

__all__ = [
    "ContactDetector",
    "Cube",
    "Detection",
    "DetectionErrors",
    "DetectionSettings",
    "Estimate",
    "ForceEstimate",
    "FrictionBounds",
    "FrictionTracker",
    "TossErrors",
    "TossFit",
    "Tosses",
    "detect_contacts",
    "detection_errors",
    "estimate_forces",
    "identify",
    "read_tosses",
    "write_tosses",
]
