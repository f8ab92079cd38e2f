"""One tick of a walk: from a robot's state to its torques, on point feet and on flat ones.

    sense -> ground -> behaviours propose -> arbiter merges
          -> plan (body, footholds, swing, forces) -> torques

What differs between point feet (`walking.walking_controller`) and flat ones (`biped.walking`)
is how feet touch the ground, where they go, and what is planned over them.
"""

from __future__ import annotations

import copy
from abc import abstractmethod

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Memory, Remembering
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Controller, RobotState
from surefoot.motion.control.damping import FALLEN, computable_pose
from surefoot.motion.control.whole_body import ForceLimits, WholeBodyCommand, WholeBodyController
from surefoot.motion.control.whole_body_tasks import Kinematics, Tasks
from surefoot.motion.walking.behaviours.arbiter import Arbiter
from surefoot.motion.walking.behaviours.behaviour import Request, WalkView
from surefoot.motion.walking.foot_phases import FeetContact
from surefoot.motion.walking.force_planner import Ramps
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.touchdown_detection import TouchMemory
from surefoot.motion.walking.walk_state import BipedState, GaitState, PlanTimes, StepInput, WalkState
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand
from surefoot.motion.walking.walking_feet import Feet
from surefoot.motion.walking.walking_settings import WalkCommand


class Tick(Controller):
    """What a walking controller does in a step.

    Attributes
    ----------
    start, dt
        Time at which the gait begins, and of a step [s].
    answers_first
        Whether plans wait until a command is given, and count from the next on; False until it is set.
    robot
        Who walks.
    command
        Wanted velocity over time, after limits.
    arbiter
        What the behaviours have asked for.
    load, whole_body
        What is made of an unknown load, None for nothing, and what gives the torques.
    """

    robot: Robot
    command: VelocityCommand
    load: LoadAdaptation | None
    arbiter: Arbiter
    whole_body: WholeBodyController
    start: float
    dt: float
    answers_first = False
    _walk: WalkState | None = None
    _outstanding: StepInput | None = None

    def step(self, state: RobotState) -> WalkCommand:
        """Return the command for a state; where no foot senses, the gait's plan is taken for the contacts.

        Never raises on a hard instance; see `WholeBodyCommand.feasible`. A state that is not finite, or too
        large to compute with, gets a command that slows the joints, and changes nothing else.
        """
        self.plan_ahead()  # if nobody has
        measured = state.fitting(self.robot)
        if not computable_pose(measured.q, measured.v):
            return self._damped(measured.v)
        # sense: what the robot carries, where it is, which feet stand
        self._observe_load(measured)
        now = self.whole_body.update(measured.q, measured.v)
        begins = self._walk is None
        s = self._begin(now, measured) if self._walk is None else self._walk
        clock = s.clock.at(measured.time - self.start)
        touch, feet, contact = self._classify_contact(s, measured, now, clock)
        feet, biped, changed = self._advance_feet(s, feet, contact, now, clock)
        # ground: what the feet have found
        touch, feet, waits = self._learn_ground(s, touch, feet, measured, now, clock)
        # behaviours propose, the arbiter merges
        request = self.arbiter.merge(self._view(s, feet, measured, now, clock))
        # plan: body, then footholds and forces as they fall due
        s.body.take_posture(self.command.posture_at(max(clock.time, 0.0)), self.dt)
        clock, gait, feet, times = self._move(s, feet, request, now, clock, waits)
        ramps, limits = self._limit_forces(s.ramps, gait, clock, feet, request, measured, now, contact)
        s = WalkState(
            clock, gait, feet, s.body, ramps, None if touch is None else touch.asked(request), s.plan,
            s.horizon, times, s.swing, biped,
        )  # fmt: skip
        given = StepInput(now, request, measured.time, changed)
        if begins or not self.answers_first:
            s = self._plan(s, given)
        else:
            self._outstanding = given
        # torques
        body = self.whole_body.solve(self._tasks(s, measured, now), limits)
        if self.load is not None:
            self.load.acted(measured.time, body.torques, s.feet.stance)
        self._walk = s
        return self._commanded(body, s, holds_up(measured, now, s.feet, begins))

    def plan_ahead(self) -> None:
        """Make the plan that the last step has left to this; see `answers_first`."""
        given, self._outstanding = self._outstanding, None
        if given is not None and self._walk is not None:
            self._walk = self._plan(self._walk, given)

    @property
    def feet(self) -> Feet | None:
        """Where the feet stand and go; None before the first step."""
        return None if self._walk is None else self._walk.feet

    @property
    def body(self) -> BodyPlan:
        """The motion of the body that is wanted, after the first step."""
        if self._walk is None:
            raise ProblemError("the walk has not begun: its body is there after the first step")
        return self._walk.body

    @abstractmethod
    def _parts(self) -> dict[str, Remembering | None]:
        """Return the parts of the controller that remember something, in the order in which they resume."""

    @property
    def state(self) -> WalkState | None:
        """A copy of all that lasts from one step to the next, for `resume`; None before the first.

        A plan that has been left to `plan_ahead` is made first.
        """
        self.plan_ahead()
        if self._walk is None:
            return None
        parts: Memory = {name: part.remembered() for name, part in self._parts().items() if part is not None}
        parts["command"] = copy.deepcopy(self.command)
        return copy.deepcopy(self._walk)._replace(parts=parts)

    def resume(self, state: WalkState | None) -> None:
        """Go on from a state of a controller that was made in the same way; None is the beginning.

        Raises
        ------
        ProblemError
            For a state of another kind of walk or robot; the walk stays where it is.
        """
        self.plan_ahead()
        if state is None:
            self.reset()
            return
        state = copy.deepcopy(state)
        own = {name: part for name, part in self._parts().items() if part is not None}
        kept = {} if state.parts is None else state.parts
        if kept.keys() != {*own, "command"} or len(state.feet.foot) != len(self.robot.feet):
            raise ProblemError(
                f"the state is of another walk: it has {len(state.feet.foot)} feet and the parts "
                f"{', '.join(kept) or 'none'}, not {len(self.robot.feet)} and {', '.join(own)}, command"
            )
        before, walk = {name: part.remembered() for name, part in own.items()}, self._walk
        self.reset()
        try:
            for name, part in own.items():
                part.resume(kept[name])
        except ProblemError:
            for name, part in own.items():
                part.resume(before[name])
            self._walk = walk
            raise
        self.command = kept["command"]
        self._walk = state._replace(parts=None)

    def _view(
        self, s: WalkState, feet: Feet, measured: RobotState, now: Kinematics, clock: GaitClock
    ) -> WalkView:
        """Return what behaviours may read."""
        return WalkView(
            measured.time, clock.time, measured, now, self.command.at(max(clock.time, 0.0)), s.body.velocity,
            s.body.position, feet.stance, feet.ground, feet.frames, s.gait.fits, self._waiting,
        )  # fmt: skip

    _waiting = False  # of gaits that do not get in step with the ground

    def _observe_load(self, measured: RobotState) -> None:
        """Learn what the robot carries, if that is observed."""

    @abstractmethod
    def _begin(self, now: Kinematics, measured: RobotState) -> WalkState:
        """Return the state of a walk that begins where the robot stands."""

    def _classify_contact(
        self, s: WalkState, measured: RobotState, now: Kinematics, clock: GaitClock
    ) -> tuple[TouchMemory | None, Feet, FeetContact]:
        """Return what is kept of touch, the feet, and which of them touch the ground: all that sense any."""
        sensed = s.feet.planned if measured.contact is None else measured.contact
        return s.touch, s.feet, FeetContact.of(sensed)

    @abstractmethod
    def _advance_feet(
        self, s: WalkState, feet: Feet, contact: FeetContact, now: Kinematics, clock: GaitClock
    ) -> tuple[Feet, BipedState | None, bool]:
        """Return the feet at the time of the clock, and whether one has lifted, landed or lost the ground."""

    def _learn_ground(
        self, s: WalkState, touch: TouchMemory | None, feet: Feet, measured: RobotState, now: Kinematics,
        clock: GaitClock,
    ) -> tuple[TouchMemory | None, Feet, bool]:  # fmt: skip
        """Learn what the feet have found of the ground; return whether the gait waits for one of them."""
        return touch, feet, False

    @abstractmethod
    def _move(
        self, s: WalkState, feet: Feet, request: Request, now: Kinematics, clock: GaitClock, waits: bool
    ) -> tuple[GaitClock, GaitState, Feet, PlanTimes]:
        """Move the body by one step, as is asked for; return clock, gait, feet, and what is to be planned."""

    @abstractmethod
    def _limit_forces(
        self, ramps: Ramps, gait: GaitState, clock: GaitClock, feet: Feet, request: Request,
        measured: RobotState, now: Kinematics, contact: FeetContact,
    ) -> tuple[Ramps, ForceLimits]:  # fmt: skip
        """Return the ramps of the normal forces, and the limits of the contact forces of this step."""

    @abstractmethod
    def _plan(self, s: WalkState, given: StepInput) -> WalkState:
        """Return the state with footholds, swings and forces planned, as far as they are due."""

    @abstractmethod
    def _tasks(self, s: WalkState, measured: RobotState, now: Kinematics) -> Tasks:
        """Return what the whole body should do now."""

    @abstractmethod
    def _damped(self, v: FloatArray) -> WalkCommand:
        """Return the command for a state that is not finite, whose joints move with (nv,) v."""

    @abstractmethod
    def _commanded(self, body: WholeBodyCommand, s: WalkState, possible: bool) -> WalkCommand:
        """Return the command that says what the parts have decided; `possible` as of `holds_up`."""


def holds_up(measured: RobotState, now: Kinematics, feet: Feet, begins: bool) -> bool:
    """Return whether a robot stands over its feet, so that what a walk wants of it can be had at all.

    Not if it has fallen over (as runs count it, 60 degrees from upright), nor while no foot touches though
    the gait wants one on the ground: forces in cones then say nothing of it. In the tick in which a walk
    begins no world has had forces yet that would show a touch.
    """
    if now.rotation[2, 2] < FALLEN:
        return False
    touches = feet.stance if measured.contact is None or begins else measured.contact
    return bool(touches.any() or not feet.planned.any())
