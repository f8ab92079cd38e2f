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
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY, base_velocity, heading_of
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.walking.behaviours.behaviour import FootSearch, Request
from surefoot.motion.walking.feet_settings import FEET, TOUCHDOWN
from surefoot.motion.walking.foot_phases import SWING, FeetContact
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walking_feet import Feet, FeetModel

USUAL = FootSearch(FEET.search_speed)
"""How late feet look for ground that nothing is known of."""


class TouchMemory(NamedTuple):
    """What the sense of touch keeps from one step to the next.

    Attributes
    ----------
    felt, silent, stood
        (n,) for how long each foot has felt something, has felt nothing, and has been taken to stand [s].
    search
        How searching feet go down in this step.
    fastest, lead
        Largest speed of the search now [m/s], and the speed along with the body over the body's [-], as far
        as they have come to those of `search`.
    waited
        For how long the gait has waited for feet [s].
    hold
        Whether feet that stand should stay on the ground in this step.
    heading
        (2,) where the body points along the level in this step.
    """

    felt: FloatArray
    silent: FloatArray
    stood: FloatArray
    search: FootSearch = USUAL
    fastest: float | None = None
    lead: float = 0.0
    waited: float = 0.0
    hold: bool = False
    heading: FloatArray = np.array([1.0, 0.0])

    @staticmethod
    def of(feet: int) -> TouchMemory:
        """Return the memory of a walk that begins on so many feet."""
        return TouchMemory(np.zeros(feet), np.zeros(feet), np.full(feet, np.inf))

    def asked(self, request: Request) -> TouchMemory:
        """Return the memory with what behaviours ask for the next step."""
        return self._replace(search=request.search or USUAL, hold=request.hold)


class TouchSense:
    """Tells landings from other touches, and decides when the gait waits.

    Parameters
    ----------
    belief
        The ground that the controller plans on.
    weight, height
        m g [N], and of the centre of mass [m].
    feet
        What does not change about the feet.
    dt
        Time between steps [s].
    """

    def __init__(
        self, belief: BeliefTerrain, weight: float, height: float, feet: FeetModel, dt: float
    ) -> None:
        self.belief, self.feet, self.dt = belief, feet, dt
        self._weight, self.height = weight, height
        self._fall, self._root = math.sqrt(height / GRAVITY), math.sqrt(GRAVITY * height)

    def begin(self, state: RobotState, centres: FloatArray) -> TouchMemory:
        """Start a walk with feet at (n, 3) `centres` [m]."""
        radii = self.feet.radii
        self.belief.start(state, centres - np.outer(radii, [0.0, 0.0, 1.0]), self.height, float(radii.mean()))
        return TouchMemory.of(len(radii))

    def seek(
        self, memory: TouchMemory, state: RobotState, feet: Feet, clock: GaitClock
    ) -> tuple[TouchMemory, Feet]:
        """Return the memory, and the feet of which those that search are sent down as is asked for."""
        search, fastest = memory.search, memory.search.speed * self._root
        memory = memory._replace(heading=heading_of(state.q[3:7]))
        if memory.fastest is None or not search.careful:
            return memory._replace(fastest=fastest, lead=0.0), feet
        slower = max(fastest, memory.fastest - TOUCHDOWN.slowing * GRAVITY * self.dt)
        change = self.dt / TOUCHDOWN.lead_time
        lead = memory.lead + min(max(search.lead - memory.lead, -change), change)
        flow = base_velocity(state.q, state.v)
        feet = self.feet.slow_search(feet, clock, memory.fastest, slower, lead * self.dt * flow[:2])
        return memory._replace(fastest=slower, lead=lead), feet

    def classify(
        self, memory: TouchMemory, state: RobotState, feet: Feet, sensed: BoolArray, clock: GaitClock,
        now: Kinematics,
    ) -> tuple[TouchMemory, FeetContact]:  # fmt: skip
        """Return the memory, and which feet touch the ground, have struck an edge, or have not landed.

        Parameters
        ----------
        memory
            Of the step before.
        state, feet, clock
            At this step.
        sensed
            (n,) which feet touch anything.
        now
            Where the robot is.
        """
        if state.forces is None:
            return memory, FeetContact.of(sensed)
        soles, stance = self.feet.soles(feet, now.centres), feet.stance
        ground, struck = sensed, np.zeros(len(sensed), dtype=bool)
        if not stance.all():
            speeds = self.feet.motions(feet, clock, memory.fastest)[:, 1]
            moving = now.twists[:, :3]
            ground, struck = sort_touches(feet, sensed, state.forces, speeds, moving, self._weight)
            for k in np.flatnonzero(struck).tolist():
                struck[k] = self.belief.may_strike(soles[k], speeds[k])
                if struck[k]:
                    self.belief.stumbled(state.time)
        above = self.belief.above(soles, ground & ~stance)
        memory, ground = accept_landings(memory, ground, stance, above, self.dt)
        memory, false = false_landings(memory, stance, self.dt)
        return memory, FeetContact(np.ascontiguousarray(ground), struck, false)

    def learn(
        self, memory: TouchMemory, state: RobotState, feet: Feet, schedule: ContactSchedule,
        clock: GaitClock, now: Kinematics,
    ) -> tuple[TouchMemory, Feet, bool]:  # fmt: skip
        """Let the belief learn where the feet are; return memory, feet, and whether the gait waits for one.

        Parameters
        ----------
        memory, state, feet, clock, now
            As for `classify`.
        schedule
            When feet should stand.
        """
        soles, sought = self.feet.soles(feet, now.centres), feet.searching
        careful = memory.search.careful
        self.belief.observe(state, feet.ground, feet.stance, sought, soles)
        if careful:  # the body comes down with its feet
            feet = self.feet.lowered(feet, sought, soles)
        overdue = feet.overdue
        if not overdue.any():
            return memory._replace(waited=0.0), feet, False
        if memory.waited < self._fall * (TOUCHDOWN.careful_wait if careful else TOUCHDOWN.longest_wait) and (
            (feet.stance | overdue).all() or (careful and self._lifts_next(feet, schedule, clock))
        ):
            return memory._replace(waited=memory.waited + self.dt), feet, True
        return memory, feet, False

    def _lifts_next(self, feet: Feet, schedule: ContactSchedule, clock: GaitClock) -> bool:
        """Return whether another foot would lift now: careful gaits do not stand on too few."""
        phases = schedule.phases(clock.time)
        lifting = (phases[:, 0] > 0.0) & (phases[:, 2] <= clock.time + TOUCHDOWN.at_once * self.dt)
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
    foot, stance = feet.foot, feet.stance
    normals = feet.frames[:, :, 2]
    along = (forces * normals).sum(axis=1)
    sideways = forces - along[:, None] * normals
    size = np.linalg.norm(sideways, axis=1)
    struck = ~stance & (size > TOUCHDOWN.struck * weight) & (size > TOUCHDOWN.steep * along)
    against = (sideways[:, :2] * speeds[:, :2]).sum(axis=1) < 0.0
    stopped = (moving[:, :2] * speeds[:, :2]).sum(axis=1) < TOUCHDOWN.stopped * (speeds[:, :2] ** 2).sum(
        axis=1
    )
    once = (foot["phase"] == SWING) & (foot["restart"][:, 1] == -np.inf)
    swinging = once & (foot["share"] > TOUCHDOWN.strikes_from) & (foot["share"] < TOUCHDOWN.strikes_until)
    light = ~stance & (along < TOUCHDOWN.sensed * weight)
    return sensed & ~struck & ~light, struck & against & stopped & swinging


def accept_landings(
    memory: TouchMemory, sensed: BoolArray, stance: BoolArray, above: FloatArray, dt: float
) -> tuple[TouchMemory, BoolArray]:
    """Return the memory, and which feet have landed of those that feel the ground: (n,).

    Parameters
    ----------
    memory
        Of the step before, a step of `dt` [s] ago.
    sensed, stance
        (n,) which feet feel the ground, and which are taken to stand on it.
    above
        (n,) height above the ground by what is known of it, over what may be noise [-].
    dt
        Time between steps [s].
    """
    felt = np.where(sensed, memory.felt + dt, 0.0)
    silent = np.where(sensed, 0.0, memory.silent + dt)
    lasting = np.where(
        above > TOUCHDOWN.far, TOUCHDOWN.lasting_far, np.where(above > 1.0, TOUCHDOWN.lasting, 0.0)
    )
    return memory._replace(felt=felt, silent=silent), sensed & (stance | (felt >= lasting))


def false_landings(memory: TouchMemory, stance: BoolArray, dt: float) -> tuple[TouchMemory, BoolArray]:
    """Return the memory, and which of the (n,) feet in stance have not landed; once a step of dt [s]."""
    stood = np.where(stance, memory.stood + dt, 0.0)
    return memory._replace(stood=stood), stance & (stood < TOUCHDOWN.young) & (
        memory.silent >= TOUCHDOWN.silent
    )
