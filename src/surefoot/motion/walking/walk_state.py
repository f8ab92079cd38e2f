"""All that lasts of a walk from one step to the next, as one value."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.behaviours.behaviour import Request
from surefoot.motion.walking.force_planner import ForcePlan, Horizon, Ramps
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.touchdown_detection import TouchMemory
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet, SwingRequest


class GaitState(NamedTuple):
    """The gait of a walk now.

    Attributes
    ----------
    schedule
        When feet should stand: the walk's own schedule, or that of a leap.
    stance_time
        Length of the coming stances of the walk's own schedule [s].
    leaps
        Whether all feet leave the ground and meet it together, by a schedule of their own.
    fits
        Whether the gait is fit for a little more than the body's speed.
    unease
        How far the body is from its plan, from 0 to 1: feet are lifted in full at 1.
    """

    schedule: ContactSchedule
    stance_time: float
    leaps: bool = False
    fits: bool = True
    unease: float = 1.0

    @property
    def coming_stance(self) -> float:
        """Length of the feet's coming stances [s]."""
        return self.schedule.stance_time if self.leaps else self.stance_time


class PlanTimes(NamedTuple):
    """When what is planned was planned last.

    Attributes
    ----------
    begun
        Time at which the last horizon was set up [s].
    aimed_at
        Time at which footholds were last chosen [s].
    aimless
        Whether a foot has just lifted, whose foothold is still to be chosen.
    load_waits
        Whether something has been learned of the load since the models were brought up.
    """

    begun: float = -math.inf
    aimed_at: float = -math.inf
    aimless: bool = False
    load_waits: bool = True


class StepInput(NamedTuple):
    """What a step plans from; its arrays hold until the next step.

    Attributes
    ----------
    now, request
        Where the robot is, and what behaviours have agreed on.
    time
        Of the step [s].
    changed
        Whether a foot has lifted, landed or lost the ground in it.
    """

    now: Kinematics
    request: Request
    time: float
    changed: bool


class BipedState(NamedTuple):
    """What a walk on two flat feet keeps beside.

    Attributes
    ----------
    corners
        (p, 3) where the corners of the soles touched the ground last [m].
    predicted
        (2, N + 1, 3) places of the centre of mass and its velocities by the last plan [m], [m/s].
    offsets
        (2, 2) where the divergent motion is over the next landing of each foot, when it lands [m].
    leg_spin
        (N + 1, 3) spin that the angular momentum of the legs is put down to [rad/s].
    laden
        Whether the robot carries a load from its first step on.
    """

    corners: FloatArray
    predicted: FloatArray = np.zeros((2, 1, 3))
    offsets: FloatArray = np.zeros((2, 2))
    leg_spin: FloatArray = np.zeros((1, 3))
    laden: bool = False


@dataclass(slots=True)
class WalkState:
    """All that lasts from one step to the next.

    Attributes
    ----------
    clock, gait
        Time on the schedule; the schedule.
    feet, touch
        Of the feet; None where no touch is sorted.
    body
        Where the body should be.
    ramps, plan, horizon, times
        Ramps of the normal forces; the last plan of the forces, None before the first; the one that is set
        up and has still to be solved; when what was planned.
    swing
        How the swings of feet were last asked to go.
    biped
        Of a walk on two flat feet.
    """

    clock: GaitClock
    gait: GaitState
    feet: Feet
    body: BodyPlan
    ramps: Ramps
    touch: TouchMemory | None = None
    plan: ForcePlan | None = None
    horizon: Horizon | None = None
    times: PlanTimes = PlanTimes()
    swing: SwingRequest | None = None
    biped: BipedState | None = None
