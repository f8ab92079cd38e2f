"""What motion and recordings tell: contact forces, and the ground's friction, restitution and place."""

from surefoot.estimation.contact_detection import (
    ContactDetector,
    DetectionSettings,
    detect_contacts,
    detection_errors,
)
from surefoot.estimation.contact_odds import TouchSettings
from surefoot.estimation.forces import ForceEstimate, estimate_forces
from surefoot.estimation.friction import FrictionTracker
from surefoot.estimation.identify import TossFit, identify
from surefoot.estimation.inekf import FilterNoise, InvariantFilter
from surefoot.estimation.inekf_robot import InvariantEkf
from surefoot.estimation.state_estimator import Health, Reading, StateEstimator, WatchSettings
from surefoot.estimation.toss_audit import TossAudit, audit_tosses
from surefoot.estimation.toss_errors import TossErrors
from surefoot.estimation.tosses import Cube, Tosses, holds_tosses, read_tosses, write_tosses

__all__ = [
    "ContactDetector",
    "Cube",
    "DetectionSettings",
    "FilterNoise",
    "ForceEstimate",
    "FrictionTracker",
    "Health",
    "InvariantEkf",
    "InvariantFilter",
    "Reading",
    "StateEstimator",
    "TossAudit",
    "TossErrors",
    "TossFit",
    "Tosses",
    "TouchSettings",
    "WatchSettings",
    "audit_tosses",
    "detect_contacts",
    "detection_errors",
    "estimate_forces",
    "holds_tosses",
    "identify",
    "read_tosses",
    "write_tosses",
]
