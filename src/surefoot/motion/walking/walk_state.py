"""All that lasts of a walk from one step to the next, as one value."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Arrays, Memory, alike, read_state, write_down
from surefoot.motion.control.body_motion import BodyReference
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.estimation.wrench_observer import Load
from surefoot.motion.gaits.adaptive_gait import Pace, Stride
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.ground.stair_detection import StairFlight
from surefoot.motion.ground.stair_fit import StairFit, StairSteps
from surefoot.motion.ground.touched_ground import Ledge
from surefoot.motion.walking.behaviours.behaviour import FootSearch, Request
from surefoot.motion.walking.command_limits import Limited
from surefoot.motion.walking.force_planner import ForceHorizon, ForcePlan, Ramps
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.touchdown_detection import TouchMemory
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand
from surefoot.motion.walking.walking_feet import Feet, SwingRequest


class GaitState(NamedTuple):
    """The gait of a walk now.

    Attributes
    ----------
    stance_time
        Length of the coming stances of the walk's own schedule [s].
    leap
        The schedule by which all feet leave the ground and meet it together; None while they follow the
        walk's own.
    fits
        Whether the gait is fit for a little more than the body's speed.
    unease
        How far the body is from its plan, from 0 to 1: feet are lifted in full at 1.
    """

    stance_time: float
    leap: Gait | None = None
    fits: bool = True
    unease: float = 1.0

    @property
    def coming_stance(self) -> float:
        """Length of the feet's coming stances [s]."""
        return self.stance_time if self.leap is None else self.leap.stance_time


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
    """

    corners: FloatArray
    predicted: FloatArray = np.zeros((2, 1, 3))
    offsets: FloatArray = np.zeros((2, 2))
    leg_spin: FloatArray = np.zeros((1, 3))

    def divergence(self, after: float, omega: float) -> FloatArray:
        """Return the divergent motion that is predicted for a time after the plan: (2,) [m].

        Parameters
        ----------
        after
            The time, in steps of the plan [-].
        omega
            Rate of the pendulum [1/s].
        """
        places, speeds = self.predicted
        last = len(places) - 1
        at = min(max(after, 0.0), float(last))
        i = min(int(at), last - 1)
        share = at - i
        place = (1.0 - share) * places[i] + share * places[i + 1]
        speed = (1.0 - share) * speeds[i] + share * speeds[i + 1]
        return np.asarray((place + speed / omega)[:2])


class WalkState(NamedTuple):
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
    parts
        Memories of the parts of the controller by name, see `Remembering`; None in the state that a
        controller works on itself.

    Examples
    --------
    >>> from surefoot.motion.walking.walking_feet import FeetModel
    >>> from surefoot.mechanics.terrain import FlatTerrain
    >>> feet = FeetModel(FlatTerrain(), np.full(4, 0.02), 0.06, 0.1).standing(np.zeros((4, 3)))
    >>> body = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0)
    >>> state = WalkState(GaitClock(0.0), GaitState(0.2), feet, body, Ramps.of(4))
    >>> WalkState.from_arrays(*state.to_arrays()) == state
    True
    """

    clock: GaitClock
    gait: GaitState
    feet: Feet
    body: BodyPlan
    ramps: Ramps
    touch: TouchMemory | None = None
    plan: ForcePlan | None = None
    horizon: ForceHorizon | None = None
    times: PlanTimes = PlanTimes()
    swing: SwingRequest | None = None
    biped: BipedState | None = None
    parts: Memory | None = None

    def __eq__(self, other: object) -> bool:
        """Return whether another state is the same to the last bit."""
        return isinstance(other, WalkState) and alike(self, other)

    def __ne__(self, other: object) -> bool:
        """Return whether another state differs in any bit; a tuple's own would compare arrays."""
        return not self == other

    def __hash__(self) -> int:
        """Refuse: a state holds arrays."""
        raise TypeError("a WalkState has no hash")

    def to_arrays(self) -> tuple[Arrays, Any]:
        """Return the state as plain arrays by path, and facts that JSON can hold."""
        return write_down(self, KINDS)

    @staticmethod
    def from_arrays(arrays: Arrays, facts: Any) -> WalkState:
        """Return the state that `to_arrays` has written down.

        Raises
        ------
        ProblemError
            For arrays and facts that are no such state.
        """
        return read_state(WalkState, "a walk", arrays, facts, KINDS)


KINDS: dict[str, type] = {
    kind.__name__: kind
    for kind in (
        WalkState, GaitClock, GaitState, Feet, BodyPlan, Ramps, TouchMemory, ForcePlan, ForceHorizon,
        PlanTimes, SwingRequest, BipedState, FootSearch, BodyReference, VelocityCommand, Limited, Gait,
        Stride, Pace, Load, Ledge, StairSteps, StairFlight, StairFit,
    )
}  # fmt: skip
"""Classes of what a state consists of, by the names that they are written down with."""
