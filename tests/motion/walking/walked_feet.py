"""Feet of a trot that tests walk on step by step, away from any robot."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.mechanics.terrain import FlatTerrain, Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.foot_phases import FeetContact
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walking_feet import Feet, FeetModel, SwingRequest

TROT = Gait.from_phases("trot", 0.4, 0.5, [0.0, 0.5, 0.5, 0.0])
CENTRES = np.array([[0.2, 0.15, 0.02], [0.2, -0.15, 0.02], [-0.2, 0.15, 0.02], [-0.2, -0.15, 0.02]])


class WalkedFeet:
    """The feet as they are now, and what makes the next ones of them."""

    def __init__(
        self, terrain: Terrain | None = None, schedule: ContactSchedule = TROT, clearance: float = 0.06,
        descent: float = 0.1, centres: FloatArray = CENTRES,
    ) -> None:  # fmt: skip
        radii = np.full(len(centres), 0.02)
        self.model = FeetModel(terrain or FlatTerrain(), radii, clearance, descent)
        self.feet, self.schedule = self.model.standing(centres), schedule
        self.request = SwingRequest(clearance)
        self.fastest: float | None = None
        self.careful = False

    @property
    def now(self) -> Feet:
        """The feet as they are now."""
        return self.feet

    def update(
        self, time: float, sensed: BoolArray, centres: FloatArray, *, struck: int | None = None,
        false: int | None = None,
    ) -> bool:  # fmt: skip
        """Move on to a time of the schedule; return whether a foot has lifted, landed or lost the ground."""
        masks = np.array([[k == which for k in range(len(sensed))] for which in (struck, false)])
        contact = FeetContact(np.ascontiguousarray(sensed), *masks)
        clock = GaitClock(time)
        self.feet, changed = self.model.advance(
            self.feet, self.schedule, clock, contact, centres, self.careful
        )
        return changed

    def aim(self, k: int, place: FloatArray) -> None:
        """Send a foot in the air to a place."""
        self.feet = self.model.aimed(self.feet, k, place, self.request)

    def motions(self, time: float) -> FloatArray:
        """Return the reference motions at a time of the schedule."""
        return self.model.motions(self.feet, GaitClock(time), self.fastest)
