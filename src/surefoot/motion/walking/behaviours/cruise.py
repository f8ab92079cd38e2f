"""Going at the commanded velocity: as fast as the gait is fit for, and as the ground allows once it is known.

Limits of a command on known ground are set before the walk (`command_limits`). A slope that feet have found
and stairs that come into view take the same: friction's margin on the slope, the speeds at which steps are
taken in step with their treads.
"""

from __future__ import annotations

import math

from surefoot.motion.gaits.library import named_gait
from surefoot.motion.ground.ground_belief import BeliefTerrain, believed
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Request, WalkFacts, WalkView
from surefoot.motion.walking.command_limits import slope_speed, step_speed
from surefoot.motion.walking.stair_gait import speed_in_step


class Cruise:
    """Keeps the speed to what gait and ground allow.

    Parameters
    ----------
    walk
        What it is for; a trot that follows the speed walks in step with stairs.
    """

    name = "cruise"

    def __init__(self, walk: WalkFacts) -> None:
        self.settings = walk.settings.cruise
        self._belief = believed(walk.terrain)
        self.mu, self.height, self.radius = walk.friction_share * walk.mu, walk.height, walk.radius
        in_step = walk.schedule.adapts and walk.schedule.name == "trot" and walk.schedule.feet == 4
        self.period = named_gait("trot", 4, walk.height).period if in_step else 0.0

    def reset(self) -> None:
        """Have nothing to forget: what is known of the ground is the terrain's."""

    def propose(self, view: WalkView) -> Request:
        """Ask for no more speed than the ground allows, and the gait is fit for."""
        at_most = None if view.fits else view.velocity
        if self._belief is not None:
            return Request(speed_cap=self._allowed(self._belief, view), at_most=at_most)
        return NOTHING if at_most is None else Request(at_most=at_most)

    def _allowed(self, belief: BeliefTerrain, view: WalkView) -> float:
        """Return how fast the ground can be walked on by what is believed of it now [m/s]."""
        if belief.highest_step == 0.0:
            return self.settings.slack * slope_speed(math.hypot(*belief.slope), self.mu, self.height)
        fastest = self.settings.slack * step_speed(belief, self.height)
        x, y, turn = (float(part) for part in view.command)
        size = math.hypot(x, y) + abs(turn) * self.radius
        slowed = min(1.0, fastest / size) if size > 0.0 else 1.0
        forward = slowed * abs(x)
        if self.period > 0.0 and forward > 0.0:
            most = speed_in_step(belief, forward, self.height, self.period)
            if most < forward * (1.0 - 1e-6):
                return slowed * size * most / forward
        return fastest
