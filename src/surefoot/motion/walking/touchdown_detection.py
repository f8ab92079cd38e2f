"""Walking on ground that is only believed: which touches are landings, and what the belief learns of them.

Feet that strike an edge swing anew, late ones are sent down faster, and the gait waits for a foot
that has not found the ground while all others stand: a trot that lifted two more would have one foot left.

Edges are distinguished from landings by the direction of the force. Ground pushes up, within its friction; an
edge pushes back: a foot in the air that is pushed sideways more than upwards, and does not get on, has struck
something, and is lifted over it [1]_. A leg that brakes, or a jolt of the body, looks like a push, but its
foot goes on.

Some landings are none. What is measured of the ground is a force at the foot by the torques of its leg. An
edge that touches the shin gives such a force as well, and so does a leg whose mass is not quite what is
believed. A foot that is taken to stand then is loaded in the air, and strikes the ground within some
hundredths of a second. So a touch well above ground that is known counts only once it has lasted, and a foot
that feels nothing more right after its landing has not landed: contact is judged by height and force together
[2]_.

References
----------
.. [1] M. Focchi et al., "Heuristic planning for rough terrain locomotion in presence of external disturbances
   and variable perception quality", in Advances in Robotics Research, Springer 2020 (a step reflex like it).
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY, base_velocity, heading_of
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.walking.behaviours.behaviour import NOTHING, FootSearch, Request
from surefoot.motion.walking.walking_feet import SEARCH_SPEED, Feet

LONGEST_WAIT, WAIT_CAREFUL = 1.5, 3.0
"""Longest time that the gait waits for a foot, over sqrt(h / g), and where it goes carefully."""
SLOWING = 1.3
"""Deceleration of late feet that should go on more slowly, as a share of g."""
AT_ONCE = 3.0
"""A foot that lifts after no more than so many steps lifts now."""
LEAD_TIME = 0.03
"""Time in which late feet gain the body's speed [s]."""
USUAL = FootSearch(SEARCH_SPEED)
"""How late feet look for ground that nothing is known of."""
STRUCK = 0.1
"""Force against its motion from which a foot has struck something, as a share of m g."""
STEEP = 1.0
"""Ground gives no more force sideways than this times that along its normal."""
SENSED = 0.06
"""Force along the normal below which a foot in the air has not found the ground, likewise: what is estimated
of the force on a leg that is braked in the air is not zero."""
STOPPED = 0.5
"""A foot that has struck something has less than this share of the speed that it should have, along it."""
SOONEST, LATEST = 0.15, 1.0
"""Shares of its swing between which a foot can strike something: lift-off drags."""
LASTING, LASTING_FAR = 0.02, 0.1
"""How long a force must last that is measured above the ground, and far above it [s]."""
FAR = 3.0
"""How far above the ground is far, over what may be noise."""
YOUNG, SILENT = 0.04, 0.008
"""So long after a landing it may be taken back [s], if nothing has touched the foot for this long [s]."""


class TouchSense:
    """Feeds a belief about the ground, and reacts to what contradicts it.

    Parameters
    ----------
    belief
        The ground that the controller plans on.
    weight, height
        m g [N], and of the centre of mass [m].
    dt
        Time between steps [s].

    Attributes
    ----------
    asked
        What behaviours agreed on in the last step.
    """

    def __init__(self, belief: BeliefTerrain, weight: float, height: float, dt: float) -> None:
        self.belief, self.dt = belief, dt
        self._weight, self.height = weight, height
        self._fall, self._root = math.sqrt(height / GRAVITY), math.sqrt(GRAVITY * height)
        self._waited = self._lead = 0.0
        self.asked: Request = NOTHING

    def begin(self, state: RobotState, centres: FloatArray, radii: FloatArray) -> None:
        """Start a walk with feet of `radii` (n,) at (n, 3) `centres` [m]."""
        self._waited, self.asked = 0.0, NOTHING
        self._landings = LandingWatch(len(radii), self.dt)
        self.belief.radius = float(radii.mean())
        self.belief.begin(state, centres - np.outer(radii, [0.0, 0.0, 1.0]), self.height)

    def sort(
        self, state: RobotState, feet: Feet, sensed: BoolArray, clock: float, now: Kinematics
    ) -> BoolArray:
        """Return which feet stand on the ground, (n,); those that have struck an edge begin their swing anew.

        Parameters
        ----------
        state, feet
            At this step.
        sensed
            (n,) which feet touch anything.
        clock
            On the schedule [s].
        now
            Where the robot is.
        """
        self._seek(state, feet, clock, self.asked.search or USUAL)
        if not self.asked.hold:
            feet.schedule.release()
        elif clock >= 0.0:
            feet.schedule.hold(clock)
        if state.forces is None:
            return sensed
        soles = now.centres - feet.radii[:, None] * feet.frames[:, :, 2]
        ground = sensed
        if not feet.stance.all():
            speeds = feet.motions(clock)[:, 1]
            moving = now.twists[:, :3]
            ground, struck = sort_touches(feet, sensed, state.forces, speeds, moving, self._weight)
            for k in np.flatnonzero(struck).tolist():
                if self.belief.may_strike(soles[k], speeds[k]):
                    self.belief.stumbled(state.time)
                    feet.interrupt(k, clock, now.centres[k])
        above = self.belief.above(soles, ground & ~feet.stance)
        ground = self._landings.believe(ground, feet.stance, above)
        for k in np.flatnonzero(self._landings.taken_back(feet.stance)).tolist():
            feet.take_back(k, now.centres[k])
        return ground

    def _seek(self, state: RobotState, feet: Feet, clock: float, search: FootSearch) -> None:
        """Send late feet down as is asked for."""
        fastest = search.speed * self._root
        if feet.fastest is None or not search.careful:
            feet.fastest, self._lead = fastest, 0.0
        else:
            slower = max(fastest, feet.fastest - SLOWING * GRAVITY * self.dt)
            change = self.dt / LEAD_TIME
            self._lead += min(max(search.lead - self._lead, -change), change)
            flow = base_velocity(state.q, state.v)
            feet.slow_search(clock, slower, self._lead * self.dt * flow[:2])
        feet.heading, feet.careful = heading_of(state.q[3:7]), search.careful

    def learn(self, state: RobotState, feet: Feet, now: Kinematics, clock: float) -> None:
        """Let the belief learn where the feet are, and hold the gait while one looks for the ground.

        Parameters
        ----------
        state, feet, clock, now
            As for `sort`.
        """
        soles = now.centres - feet.radii[:, None] * feet.frames[:, :, 2]
        sought = feet.late & ~feet.stance
        self.belief.observe(state, feet.ground, feet.stance, sought, soles)
        if feet.careful:  # the body comes down with its feet
            feet.ground[sought] = soles[sought]
        overdue = feet.overdue()
        if not overdue.any():
            self._waited = 0.0
        elif self._waited < self._fall * (WAIT_CAREFUL if feet.careful else LONGEST_WAIT) and (
            (feet.stance | overdue).all() or self._lifts_next(feet, clock)
        ):
            self._waited += self.dt
            feet.wait += self.dt

    def _lifts_next(self, feet: Feet, clock: float) -> bool:
        """Return whether another foot would lift now, where care is taken not to stand on too few."""
        if not feet.careful:
            return False
        phases = feet.schedule.phases(clock)
        lifting = (phases[:, 0] > 0.0) & (phases[:, 2] <= clock + AT_ONCE * self.dt)
        return bool((feet.stance & lifting).any())


def sort_touches(
    feet: Feet, sensed: BoolArray, forces: FloatArray, speeds: FloatArray, moving: FloatArray, weight: float
) -> tuple[BoolArray, BoolArray]:
    """Return which feet feel the ground, and which have struck an edge in the air: (n,) each.

    Parameters
    ----------
    feet
        The feet.
    sensed
        (n,) which feet feel anything.
    forces
        (n, 3) on the feet, world axes [N].
    speeds
        (n, 3) of the feet, as wanted, world axes [m/s].
    moving
        (n, 3) of the feet, as they are, likewise.
    weight
        m g [N].
    """
    normals = feet.frames[:, :, 2]
    along = (forces * normals).sum(axis=1)
    sideways = forces - along[:, None] * normals
    size = np.linalg.norm(sideways, axis=1)
    struck = ~feet.stance & (size > STRUCK * weight) & (size > STEEP * along)
    against = (sideways[:, :2] * speeds[:, :2]).sum(axis=1) < 0.0
    stopped = (moving[:, :2] * speeds[:, :2]).sum(axis=1) < STOPPED * (speeds[:, :2] ** 2).sum(axis=1)
    swinging = ~feet.late & ~feet.again & (feet.share > SOONEST) & (feet.share < LATEST)
    light = ~feet.stance & (along < SENSED * weight)
    return sensed & ~struck & ~light, struck & against & stopped & swinging


class LandingWatch:
    """Doubts landings.

    Parameters
    ----------
    feet
        Number of them.
    dt
        Time between steps [s].
    """

    def __init__(self, feet: int, dt: float) -> None:
        self.dt = dt
        self._sensed, self._silent = np.zeros((2, feet))
        self._stood = np.full(feet, np.inf)

    def believe(self, sensed: BoolArray, stance: BoolArray, above: FloatArray) -> BoolArray:
        """Return which feet have landed of those that feel the ground: (n,).

        Parameters
        ----------
        sensed, stance
            (n,) which feet feel it, and which are taken to stand on it.
        above
            (n,) how far above the ground they are by what is known of it, over what may be noise [-].
        """
        self._sensed = np.where(sensed, self._sensed + self.dt, 0.0)
        self._silent = np.where(sensed, 0.0, self._silent + self.dt)
        lasting = np.where(above > FAR, LASTING_FAR, np.where(above > 1.0, LASTING, 0.0))
        return sensed & (stance | (self._sensed >= lasting))

    def taken_back(self, stance: BoolArray) -> BoolArray:
        """Return which feet that carry have not landed after all: (n,); to be called at each step."""
        self._stood = np.where(stance, self._stood + self.dt, 0.0)
        return stance & (self._stood < YOUNG) & (self._silent >= SILENT)
