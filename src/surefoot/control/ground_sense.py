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
from surefoot.control.walking_feet import Feet, FootProbe
from surefoot.control.whole_body import Kinematics
from surefoot.spatial import GRAVITY, base_velocity, heading_of
from surefoot.terrain import Terrain

LONGEST_WAIT, WAIT_CAREFUL = 1.5, 3.0
"""Longest time that the gait waits for a foot, over sqrt(h / g), and where it goes carefully."""
SLOWING = 1.3
"""Deceleration of late feet that should go on more slowly, as a share of g."""
AT_ONCE = 3.0
"""A foot that lifts after no more than so many steps lifts now."""
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
    clearance
        Of a swing over known ground [m].
    dt
        Time between steps [s].
    """

    def __init__(
        self, belief: GroundBelief, weight: float, height: float, clearance: float, dt: float
    ) -> None:
        self.belief, self.dt = belief, dt
        self._weight, self._height, self._clearance = weight, height, clearance
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
        if self.belief.probe is not None:
            sensed = self._let_probe(self.belief.probe, feet, sensed, clock)
        feet.probe, feet.lower = self.belief.probe, self.belief.lower
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

    @staticmethod
    def _let_probe(probe: FootProbe, feet: Feet, sensed: BoolArray, clock: float) -> BoolArray:
        """Let one foot be in the air while the others are held; return which feet may have landed, (n,)."""
        if isinstance(feet.schedule, AdaptiveGait):
            (feet.schedule.land_alone if probe.down else feet.schedule.lift_alone)(probe.foot, clock)
        landed = sensed.copy()
        landed[probe.foot] &= probe.down
        return landed

    def learn(self, state: RobotState, feet: Feet, now: Kinematics, clock: float) -> None:
        """Tell the belief where the feet are, and hold the gait while one of them looks for the ground.

        `now` is where the robot is, `clock` the time on the schedule [s].
        """
        soles = now.centres - feet.radii[:, None] * feet.frames[:, :, 2]
        self.belief.com = now.com
        sought = feet.late & ~feet.carrying
        self.belief.observe(state, feet.ground, feet.carrying, sought, soles)
        if self.belief.careful:  # the body comes down with its feet
            feet.ground[sought] = soles[sought]
        feet.clearance = self._clearance + self.belief.lift
        overdue = feet.overdue()
        if not overdue.any():
            self._waited = 0.0
        elif self._waited < self._longest() and (
            (feet.carrying | overdue).all() or self._lifts_next(feet, clock)
        ):
            self._waited += self.dt
            feet.wait += self.dt

    def _lifts_next(self, feet: Feet, clock: float) -> bool:
        """Return whether another foot would lift now, where care is taken not to stand on too few."""
        if not self.belief.careful:
            return False
        phases = feet.schedule.phases(clock)
        return bool(
            (feet.carrying & (phases[:, 0] > 0.0) & (phases[:, 2] <= clock + AT_ONCE * self.dt)).any()
        )

    def _longest(self) -> float:
        """Return the longest time that the gait waits for a foot [s]."""
        return self._fall * (LONGEST_WAIT if not self.belief.careful else WAIT_CAREFUL)


def ground_sense(
    terrain: Terrain, weight: float, height: float, clearance: float, dt: float, notes: list[str]
) -> GroundSense | None:
    """Return what feeds a terrain that learns, None for one that is known; parameters of `GroundSense`.

    What the belief has to say of the command goes to `notes`.
    """
    if not terrain.learns:
        return None
    belief = cast(GroundBelief, terrain)
    belief.notes = notes
    return GroundSense(belief, weight, height, clearance, dt)
