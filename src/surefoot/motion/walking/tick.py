"""One tick of a walk: from a robot's state to its torques, on point feet and on flat ones.

    sense -> ground -> behaviours propose -> arbiter merges
          -> plan (body, footholds, swing, forces) -> torques

What differs between point feet (`walking.walking_controller`) and flat ones (`biped.walking`)
is how feet touch the ground, where they go, and what is planned over them.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import partial

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.motion.control.controller import Controller, RobotState
from surefoot.motion.control.damping import computable
from surefoot.motion.control.whole_body import WholeBodyCommand, WholeBodyController
from surefoot.motion.control.whole_body_tasks import Kinematics, Tasks
from surefoot.motion.walking.behaviours.arbiter import Arbiter
from surefoot.motion.walking.behaviours.behaviour import Request, WalkView
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand, take_posture
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
    command
        Wanted velocity over time, after limits.
    body, feet
        The motion of the body that is wanted; where the feet stand and go, None before the first step.
    arbiter
        What the behaviours have asked for.
    load, whole_body
        What is made of an unknown load, None for nothing, and what gives the torques.
    """

    command: VelocityCommand
    body: BodyPlan
    feet: Feet | None
    load: LoadAdaptation | None
    arbiter: Arbiter
    whole_body: WholeBodyController
    start: float
    dt: float
    answers_first = False
    _outstanding: Callable[[], None] | None = None

    def step(self, state: RobotState) -> WalkCommand:
        """Return the command for a state; where no foot senses, the gait's plan is taken for the contacts.

        Never raises on a hard instance; see `WholeBodyCommand.feasible`. A state that is not finite, or too
        large to compute with, gets a command that slows the joints, and changes nothing else.
        """
        self.plan_ahead()  # if nobody has
        if not computable(state.q, state.v):
            return self._damped(state.v)
        # sense: what the robot carries, where it is, which feet stand
        self._adapt(state)
        now = self.whole_body.update(state.q, state.v)
        begins = self.feet is None
        feet = self._begin(now, state) if self.feet is None else self.feet
        clock = state.time - self.start - feet.wait
        sensed = feet.planned.copy() if state.contact is None else state.contact
        standing = self._sort_touches(state, now, sensed, clock)
        changed = clock >= 0.0 and self._move_feet(now, standing, clock)
        # ground: what the feet have found
        self._learn(state, now, clock)
        # behaviours propose, the arbiter merges
        request = self.arbiter.merge(self._view(state, now, feet, clock))
        take_posture(self.body, self.command.posture_at(max(clock, 0.0)), self.dt)
        # plan: body, and footholds, swing and forces as they fall due
        self._move_body(request, now, clock)
        self._bound_forces(state, now, clock, standing)
        if begins or not self.answers_first:
            self._plan(now, request, clock, state.time, changed)
        else:
            self._outstanding = partial(self._plan, now, request, clock, state.time, changed)
        # torques
        body = self.whole_body.solve(self._tasks(state, now, clock))
        if self.load is not None:
            self.load.acted(state.time, body.torques, feet.stance)
        return self._commanded(body, feet)

    def plan_ahead(self) -> None:
        """Make the plan that the last step has left to this; see `answers_first`."""
        plan, self._outstanding = self._outstanding, None
        if plan is not None:
            plan()

    def _view(self, state: RobotState, now: Kinematics, feet: Feet, clock: float) -> WalkView:
        """Return what behaviours may read."""
        return WalkView(
            state.time, clock, state, now, self.command.at(max(clock, 0.0)), self.body.velocity,
            self.body.position, feet.stance, feet.ground, feet.frames, self._fits, self._waiting,
        )  # fmt: skip

    _fits, _waiting = True, False  # of gaits that do not follow the speed

    def _adapt(self, state: RobotState) -> None:
        """Learn what the robot carries, if that is observed."""

    @abstractmethod
    def _begin(self, now: Kinematics, state: RobotState) -> Feet:
        """Start from where the robot stands."""

    def _sort_touches(self, state: RobotState, now: Kinematics, sensed: BoolArray, clock: float) -> BoolArray:
        """Return which feet stand on the ground of those that sense anything, (n,): all."""
        return sensed

    @abstractmethod
    def _move_feet(self, now: Kinematics, standing: BoolArray, clock: float) -> bool:
        """Bring the feet up to the clock; return whether one has lifted or landed."""

    def _learn(self, state: RobotState, now: Kinematics, clock: float) -> None:
        """Learn what the feet have found of the ground, where it is not known."""

    @abstractmethod
    def _move_body(self, request: Request, now: Kinematics, clock: float) -> None:
        """Move the wanted body by one step, as is asked for."""

    @abstractmethod
    def _bound_forces(self, state: RobotState, now: Kinematics, clock: float, standing: BoolArray) -> None:
        """Bound the forces by what the feet do now, and tell the torques of the load."""

    @abstractmethod
    def _plan(self, now: Kinematics, request: Request, clock: float, time: float, changed: bool) -> None:
        """Plan footholds, swings and forces, if they are due or a foot has lifted or landed."""

    @abstractmethod
    def _damped(self, v: FloatArray) -> WalkCommand:
        """Return the command for a state that is not finite, whose joints move with (nv,) v."""

    @abstractmethod
    def _commanded(self, body: WholeBodyCommand, feet: Feet) -> WalkCommand:
        """Return the command that says what the parts have decided."""

    @abstractmethod
    def _tasks(self, state: RobotState, now: Kinematics, clock: float) -> Tasks:
        """Return what the whole body should do now."""
