"""Controllers that execute a plan: whole-body control on the ground, joint control in flight, landings."""

from surefoot.motion.planning.tracking.reference import Reference, Sample
from surefoot.motion.planning.tracking.tracker import TrackCommand, TrackingController

__all__ = ["Reference", "Sample", "TrackCommand", "TrackingController"]
