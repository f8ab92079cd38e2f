"""Controllers that execute a plan: whole-body control on the ground, joint control in flight, landings."""

from surefoot.planning.tracking.reference import Reference, Sample
from surefoot.planning.tracking.tracker import TrackCommand, TrackingController

__all__ = ["Reference", "Sample", "TrackCommand", "TrackingController"]
