"""How a walk on ground that is only believed differs from one on known ground: it feels its way.

Feet that strike an edge are lifted over it, late ones are sent down faster, and the gait waits for a foot
that has not found the ground while all others stand: a trot that lifted two more would have one foot left.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait
from surefoot.control.controller import RobotState
from surefoot.control.landing import LandingWatch
from surefoot.control.stumble import sort_touches
from surefoot.control.terrain_knowledge import GroundBelief
from surefoot.control.walking_feet import Feet
from surefoot.spatial import GRAVITY, base_velocity, heading_of
from surefoot.terrain import Terrain

LONGEST_WAIT, WAIT_CAREFUL = 1.5, 3.0
"""Longest time that the gait waits for a foot, over sqrt(h / g), and where it goes carefully."""
SLOWING = 1.3
"""Deceleration of late feet that should go on more slowly, as a share of g."""
LEAD_TIME = 0.03
"""Time in which such feet gain the body's speed [s]."""


class GroundSense:
    """Feeds a belief about the ground, and reacts to what contradicts it.

    Parameters
    ----------
    belief
        The ground that the controller plans on.
    weight, height
        m g [N], and of the centre of mass [m].
    dt
        Time between steps [s].
    """

    def __init__(self, belief: GroundBelief, weight: float, height: float, dt: float) -> None:
        self.belief, self.dt = belief, dt
        self._weight, self._height = weight, height
        self._fall = math.sqrt(height / GRAVITY)
        self._root = math.sqrt(GRAVITY * height)
        self._waited = self._lead = 0.0

    def begin(self, state: RobotState, centres: FloatArray, radii: FloatArray) -> None:
        """Start a walk with feet of `radii` (n,) at (n, 3) `centres` [m]."""
        self._waited = 0.0
        self._landings = LandingWatch(len(radii), self.dt)
        self.belief.radius = float(radii.mean())
        self.belief.begin(state, centres - np.outer(radii, [0.0, 0.0, 1.0]), self._height)

    def feel(
        self,
        state: RobotState,
        feet: Feet,
        sensed: BoolArray,
        clock: float,
        centres: FloatArray,
        twists: FloatArray,
    ) -> BoolArray:
        """Return which feet feel the ground, (n,); those that have struck an edge begin their swing anew.

        Parameters
        ----------
        state, feet
            At this step.
        sensed
            (n,) which feet feel anything.
        clock
            On the schedule [s].
        centres, twists
            (n, 3), (n, 6) where the feet are and how they move, world axes [m], [m/s, rad/s].
        """
        fastest = self.belief.search_speed * self._root
        if feet.fastest is None or not self.belief.careful:
            feet.fastest, self._lead = fastest, 0.0
        else:
            slower = max(fastest, feet.fastest - SLOWING * GRAVITY * self.dt)
            change = self.dt / LEAD_TIME
            self._lead += min(max(self.belief.lead - self._lead, -change), change)
            flow = base_velocity(state.q, state.v)
            feet.slow_search(clock, slower, self._lead * self.dt * flow[:2])
        feet.heading, feet.careful = heading_of(state.q[3:7]), self.belief.careful
        if isinstance(feet.schedule, AdaptiveGait):
            if not self.belief.standing:
                feet.schedule.held, feet.schedule.leading = False, self.belief.leading
            elif clock >= 0.0:
                feet.schedule.hold(clock)
        if state.forces is None:
            return sensed
        soles = centres - feet.radii[:, None] * feet.frames[:, :, 2]
        ground = sensed
        if not feet.carrying.all():
            speeds = feet.motions(clock)[:, 1]
            ground, struck = sort_touches(feet, sensed, state.forces, speeds, twists[:, :3], self._weight)
            for k in np.flatnonzero(struck).tolist():
                if self.belief.may_strike(soles[k], speeds[k]):
                    self.belief.stumbled(state.time)
                    feet.interrupt(k, clock, centres[k])
        above = self.belief.above(soles, ground & ~feet.carrying)
        ground = self._landings.believe(ground, feet.carrying, above)
        for k in np.flatnonzero(self._landings.taken_back(feet.carrying)).tolist():
            feet.take_back(k, centres[k])
        return ground

    def learn(self, state: RobotState, feet: Feet, centres: FloatArray) -> None:
        """Tell the belief where the feet are, and hold the gait while one of them looks for the ground.

        `centres` (n, 3) is where the feet are [m].
        """
        soles = centres - feet.radii[:, None] * feet.frames[:, :, 2]
        sought = feet.late & ~feet.carrying
        self.belief.observe(state, feet.ground, feet.carrying, sought, soles)
        if self.belief.careful:  # the body comes down with its feet
            feet.ground[sought] = soles[sought]
        overdue = feet.overdue()
        if not overdue.any():
            self._waited = 0.0
        elif self._waited < self._longest() and (feet.carrying | overdue).all():
            self._waited += self.dt
            feet.wait += self.dt

    def _longest(self) -> float:
        """Return the longest time that the gait waits for a foot [s]."""
        return self._fall * (LONGEST_WAIT if not self.belief.careful else WAIT_CAREFUL)


def ground_sense(
    terrain: Terrain, weight: float, height: float, dt: float, notes: list[str]
) -> GroundSense | None:
    """Return what feeds a terrain that learns, None for one that is known; parameters of `GroundSense`.

    What the belief has to say of the command goes to `notes`.
    """
    if not terrain.learns:
        return None
    belief = cast(GroundBelief, terrain)
    belief.notes = notes
    return GroundSense(belief, weight, height, dt)
