"""Going at the commanded velocity: as fast as the gait is fit for, and as the ground allows once it is known.

Limits of a command on known ground are set before the walk (`command_limits`). A slope that feet have found
and stairs that come into view take the same: friction's margin on the slope, the speeds at which steps are
taken in step with their treads.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.control.behaviours.behaviour import NOTHING, Request, View, Walk
from surefoot.control.command_limits import slope_speed, step_speed
from surefoot.control.stair_gait import speed_in_step
from surefoot.estimation.ground_belief import GroundBelief, believed
from surefoot.stance.gait_library import named_gait

SLACK = 1.08
"""What is believed may be off by so much: a command at the limit should not be slowed by it."""
FOLLOW = 0.5
"""Time constant with which the slope of the plane under the feet is followed [s]."""


class Cruise:
    """Keeps the speed to what gait and ground allow.

    Parameters
    ----------
    walk
        What it is for; a trot that follows the speed walks in step with stairs.
    """

    name = "cruise"

    def __init__(self, walk: Walk) -> None:
        self._belief = believed(walk.terrain)
        self._mu, self._height, self._radius = walk.friction_share * walk.mu, walk.height, walk.radius
        in_step = walk.schedule.adapts and walk.schedule.name == "trot" and walk.schedule.feet == 4
        self._period = named_gait("trot", 4, walk.height).period if in_step else 0.0
        self._share = 1.0 - math.exp(-walk.dt / FOLLOW)
        self.reset()

    def reset(self) -> None:
        """Forget what has been learned of the slope."""
        self._slope, self._begun = np.zeros(2), False

    def propose(self, view: View) -> Request:
        """Ask for no more speed than the ground allows, and the gait is fit for."""
        at_most = None if view.fits else view.velocity
        if self._belief is not None:
            return Request(speed_cap=self._allowed(self._belief, view), at_most=at_most)
        return NOTHING if at_most is None else Request(at_most=at_most)

    def _allowed(self, belief: GroundBelief, view: View) -> float:
        """Return how fast the ground can be walked on by what is believed of it now [m/s]."""
        # from the slope of the stance at the start the one that feet find is followed
        self._slope += (self._share if self._begun else 1.0) * (belief.slope - self._slope)
        self._begun = True
        if belief.highest_step == 0.0:
            steepness = math.hypot(self._slope[0], self._slope[1])
            return SLACK * slope_speed(steepness, self._mu, self._height)
        fastest = SLACK * step_speed(belief, self._height)
        x, y, turn = (float(part) for part in view.command)
        size = math.hypot(x, y) + abs(turn) * self._radius
        slowed = min(1.0, fastest / size) if size > 0.0 else 1.0
        forward = slowed * abs(x)
        if self._period > 0.0 and forward > 0.0:
            most = speed_in_step(belief, forward, self._height, self._period)
            if most < forward * (1.0 - 1e-6):
                return slowed * size * most / forward
        return fastest
