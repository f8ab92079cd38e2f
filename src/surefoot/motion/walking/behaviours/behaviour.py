"""What a behaviour is: it reads a frozen view of the walk and asks for something; it writes nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeAlias

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.mechanics import Terrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.behaviours.behaviour_settings import BehaviourSettings

FootGoals: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
"""From the nominal place (2,) of a foot [m] and where it lifted (>= 2,) [m] to the (2,) place where it should
land [m]."""


class FootSearch(NamedTuple):
    """How feet go on down that have not found the ground where they should.

    Attributes
    ----------
    speed
        The largest, as a share of sqrt(g h).
    lead
        Speed with which they go along with the body, over the body's.
    careful
        Whether they slow down on their way, and the gait and the body wait for them.
    """

    speed: float
    lead: float = 0.0
    careful: bool = False


class Recovery(NamedTuple):
    """How a body that was pushed is caught.

    Attributes
    ----------
    rate
        How many times as fast as by its own clock the gait goes.
    velocity
        (3,) that is wanted now, from one moment to the next: forward, left [m/s], turn [rad/s].
    acceleration
        With which it comes back to the commanded one [m/s²].
    leaps
        Whether all feet leave the ground and meet it together, whatever the gait.
    """

    rate: float
    velocity: FloatArray
    acceleration: float
    leaps: bool = False


class WalkFacts(NamedTuple):
    """What a behaviour is made for; the numbers do not change in a walk.

    Attributes
    ----------
    terrain, schedule
        The ground that is believed in, and when feet carry.
    radii
        (n,) of the feet [m].
    height, radius
        Of the centre of mass above the ground; distance of the feet from the middle [m].
    weight, mu
        m g [N]; friction that is believed in at the start [-].
    dt
        Time between steps [s].
    watch_friction
        Whether less friction is believed in where feet slide.
    friction_share
        Share of the friction that commanded forces may use.
    settings
        Of all behaviours.
    """

    terrain: Terrain
    schedule: ContactSchedule
    radii: FloatArray
    height: float
    radius: float
    weight: float
    mu: float
    dt: float
    watch_friction: bool = False
    friction_share: float = 1.0
    settings: BehaviourSettings = BehaviourSettings()


class WalkView(NamedTuple):
    """What may be read in a step.

    Attributes
    ----------
    time, clock
        Since the run began, and on the schedule, negative before the gait begins [s].
    state, now
        What is sensed, and where the robot is: arrays that the next step overwrites, to be copied if kept.
    command, velocity
        (3,) velocity that is commanded, and the body's wanted one now: forward, left [m/s], turn [rad/s].
    position
        (3,) wanted centre of mass [m].
    stance
        (n,) which feet stand.
    ground, frames
        (n, 3) where they stand or last stood [m], (n, 3, 3) rotation_world_contact there.
    fits
        Whether the gait is fit for a little more than the body's speed.
    waiting
        Whether the body waits for the phase in which to set off onto steps.
    """

    time: float
    clock: float
    state: RobotState
    now: Kinematics
    command: FloatArray
    velocity: FloatArray
    position: FloatArray
    stance: BoolArray
    ground: FloatArray
    frames: FloatArray
    fits: bool
    waiting: bool


class Request(NamedTuple):
    """What a behaviour asks for; how several are merged is said in `behaviours.arbiter`.

    Attributes
    ----------
    speed_cap
        Largest speed, turning counted at the feet [m/s].
    velocity
        (3,) in place of the commanded one [m/s, m/s, rad/s]; None to leave it.
    at_most
        (3,) velocity that is not to be passed yet, likewise.
    pace
        Share of the velocity that is gone at.
    step_times
        (3,) velocity that the steps of a body at rest should suit, likewise.
    hold
        Whether all feet that stand should stay on the ground.
    clearance
        By how much more than the gait asks for feet are lifted [m].
    foot_goals
        Where feet land instead of their nominal places.
    search
        How late feet look for the ground.
    recovery
        How a body that was pushed is caught; feet then land where they catch it.
    mu, acceleration
        Friction to count on [-], and the largest change of the wanted velocity [m/s²].
    height
        The highest that the centre of mass may be above the ground [m].
    note
        A line for the walk's notes, once.
    """

    speed_cap: float = math.inf
    velocity: FloatArray | None = None
    at_most: FloatArray | None = None
    pace: float = 1.0
    step_times: FloatArray | None = None
    hold: bool = False
    clearance: float = 0.0
    foot_goals: FootGoals | None = None
    search: FootSearch | None = None
    recovery: Recovery | None = None
    mu: float = math.inf
    acceleration: float = math.inf
    height: float = math.inf
    note: str = ""


NOTHING = Request()
"""Of a behaviour that asks for nothing."""


class Behaviour(Protocol):
    """Something that a walk does of its own accord.

    Attributes
    ----------
    name
        By which the log calls it.
    """

    name: str

    def propose(self, view: WalkView) -> Request:
        """Return what is asked for in a step; called in each, in order."""
        ...

    def reset(self) -> None:
        """Forget the past."""
        ...


MakeBehaviour: TypeAlias = Callable[[WalkFacts], Behaviour | None]
"""Makes a behaviour for a walk, or None for a walk that it has nothing to say to."""
