"""One tick of a walk: from a robot's state to its torques, on point feet and on flat ones.

    sense -> ground -> behaviours propose -> arbiter merges
          -> plan (body, footholds, swing, forces) -> torques

What differs between point feet (`surefoot.control.walking`) and flat ones (`surefoot.control.biped.walking`)
is how feet touch the ground, where they go, and what is planned over them.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array
from surefoot.control.behaviours.arbiter import Arbiter
from surefoot.control.behaviours.behaviour import Request, View, Walk
from surefoot.control.biped.settings import BipedSettings
from surefoot.control.contact_schedule import ContactSchedule
from surefoot.control.controller import Controller, RobotState
from surefoot.control.damping import computable
from surefoot.control.load_adaptation import LoadAdaptation
from surefoot.control.mpc import ConvexMpc
from surefoot.control.walking_body import BodyPlan, VelocityCommand
from surefoot.control.walking_feet import Feet
from surefoot.control.walking_settings import WalkCommand, WalkSettings, damping_command
from surefoot.control.whole_body import WholeBodyCommand, WholeBodyController
from surefoot.control.whole_body_tasks import Kinematics, Tasks
from surefoot.log.channels import CHANNELS
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.terrain import Terrain


class Walker(Controller):
    """A controller that walks a robot.

    Attributes
    ----------
    robot, settings, schedule, terrain
        As they were given.
    command
        Wanted velocity over time, after limits.
    notes
        What was changed in the command, one line each.
    body, feet
        The motion of the body that is wanted; where the feet stand and go, None before the first step.
    arbiter
        What the behaviours have asked for.
    """

    channels = tuple(CHANNELS[name] for name in ("planned", "command", "asked_by"))
    robot: Robot
    dt: float
    settings: WalkSettings | BipedSettings
    schedule: ContactSchedule
    terrain: Terrain
    command: VelocityCommand
    notes: list[str]
    body: BodyPlan
    feet: Feet | None
    load: LoadAdaptation
    arbiter: Arbiter
    _limit: Callable[[VelocityCommand], VelocityCommand]
    _start: float
    _height: float
    _last: WalkCommand | None

    def step(self, state: RobotState) -> WalkCommand:
        """Return the command for a state; where no foot senses, the gait's plan is taken for the contacts.

        Never raises on a hard instance; see `WholeBodyCommand.feasible`. A state that is not finite, or too
        large to compute with, gets a command that slows the joints, and changes nothing else.
        """
        if not computable(state.q, state.v):
            return self._damped(state.v)
        # sense: what the robot carries, where it is, which feet stand
        self._adapt(state)
        now = self.whole_body.update(state.q, state.v)
        feet = self._begin(now, state) if self.feet is None else self.feet
        clock = state.time - self._start - feet.wait
        sensed = feet.planned.copy() if state.contact is None else state.contact
        standing = self._sort_touches(state, now, sensed, clock)
        changed = clock >= 0.0 and self._move_feet(now, standing, clock)
        # ground: what the feet have found
        self._learn(state, now, clock)
        # behaviours propose, the arbiter merges
        request = self.arbiter.merge(self._view(state, now, feet, clock))
        # plan: body, and footholds, swing and forces as they fall due
        self._move_body(request, now)
        self._plan(state, now, request, clock, standing, changed)
        # torques
        body = self.whole_body.solve(self._tasks(state, now, clock))
        self.load.acted(state.time, body.torques, feet.carrying)
        return self._commanded(body, feet)

    def _view(self, state: RobotState, now: Kinematics, feet: Feet, clock: float) -> View:
        """Return what behaviours may read."""
        return View(
            state.time, clock, state, now, self.command.at(max(clock, 0.0)), self.body.velocity,
            self.body.position, feet.carrying, feet.ground, feet.frames, self._fits, self._waiting,
        )  # fmt: skip

    _fits, _waiting = True, False  # of gaits that do not follow the speed

    @abstractmethod
    def _adapt(self, state: RobotState) -> None:
        """Learn what the robot carries, and let the models know in a step that has time for it."""

    @abstractmethod
    def _begin(self, now: Kinematics, state: RobotState) -> Feet:
        """Start from where the robot stands."""

    @abstractmethod
    def _sort_touches(self, state: RobotState, now: Kinematics, sensed: BoolArray, clock: float) -> BoolArray:
        """Return which feet stand on the ground of those that sense anything, (n,)."""

    @abstractmethod
    def _move_feet(self, now: Kinematics, standing: BoolArray, clock: float) -> bool:
        """Bring the feet up to the clock; return whether one has lifted or landed."""

    @abstractmethod
    def _learn(self, state: RobotState, now: Kinematics, clock: float) -> None:
        """Learn what the feet have found of the ground."""

    @abstractmethod
    def _move_body(self, request: Request, now: Kinematics) -> None:
        """Move the wanted body by one step, as is asked for."""

    @abstractmethod
    def _plan(
        self, state: RobotState, now: Kinematics, request: Request, clock: float, standing: BoolArray,
        changed: bool,
    ) -> None:  # fmt: skip
        """Plan footholds, swings and forces, if they are due or a foot has lifted or landed."""

    @abstractmethod
    def _tasks(self, state: RobotState, now: Kinematics, clock: float) -> Tasks:
        """Return what the whole body should do now."""

    def steer(self, velocity: ArrayLike) -> FloatArray:
        """Take another velocity from now on, limited and ramped as any, and return what is left of it.

        Parameters
        ----------
        velocity
            (3,) forward, left [m/s], yaw rate [rad/s].

        Returns
        -------
        FloatArray
            (3,) the same after limits [m/s, rad/s].

        Raises
        ------
        ProblemError
            For what is no three finite numbers.
        """
        wanted = finite_array("velocity", velocity, (3,))
        self.command = self._limit(VelocityCommand.constant(*wanted.tolist()))
        return self.command.at(0.0)

    def _set_controllers(
        self, inertia: FloatArray, step: float, pendulum: float, baumgarte: tuple[float, float],
        sole_damping: tuple[float, float] | None = None,
    ) -> tuple[float, float]:  # fmt: skip
        """Make the MPC and the whole-body controller, and return least and largest normal force of a point.

        Parameters
        ----------
        inertia
            (3, 3) of the robot about its centre of mass, in the axes that the MPC turns [kg m²].
        step
            Of the MPC [s].
        pendulum
            sqrt(g / h) [rad/s].
        baumgarte, sole_damping
            See `WholeBodyController`.
        """
        s, robot, weight = self.settings, self.robot, self.robot.mass * GRAVITY
        mu, low, high = s.mu * s.friction_share, s.normal_min * weight, s.normal_max * weight
        points = len(robot.contact_points)
        self.mpc = ConvexMpc(robot.mass, inertia, points, s.horizon, step, mu, low, high, s.mpc)
        self.whole_body = WholeBodyController(
            robot, mu, low, high, s.whole_body, baumgarte, None, s.actuators, sole_damping
        )
        self._body_gain, self._swing_gain = (
            ((share * pendulum) ** 2, 2.0 * share * pendulum)
            for share in (s.body_stiffness, s.swing_stiffness)
        )
        return low, high

    def _set_behaviours(self, radii: FloatArray, radius: float, watch_friction: bool) -> None:
        """Make the behaviours: feet of `radii` (n,) stand `radius` from the middle [m]."""
        s, weight = self.settings, self.robot.mass * GRAVITY
        walk = Walk(
            self.terrain, self.schedule, radii, self._height, radius, weight, s.mu, self.dt, watch_friction,
            s.friction_share,
        )  # fmt: skip
        made = [behaviour for make in s.behaviours if (behaviour := make(walk)) is not None]
        self.arbiter = Arbiter(made, radius, self.notes)
        self.facts = {
            "kind": "walk", "normal_min": s.normal_min * weight, "normal_max": s.normal_max * weight,
            "mu_controller": s.mu, "gait": self.schedule.name, "notes": self.notes,
            "behaviours": [behaviour.name for behaviour in made],
        }  # fmt: skip

    def _commanded(self, body: WholeBodyCommand, feet: Feet) -> WalkCommand:
        """Return the command that says what the parts have decided."""
        self._last = WalkCommand(
            body.torques, body.forces, feet.carrying[self.whole_body.point_foot], body.feasible, body.status,
            feet.planned.copy(), feet.frames.copy(), self.body.velocity.copy(), feet.target.copy(),
            accelerations=body.accelerations, load=self.load.rows, asked_by=self.arbiter.asked_by,
        )  # fmt: skip
        return self._last

    def _damped(self, v: FloatArray) -> WalkCommand:
        """Return the command for a state that is not finite."""
        body = self.whole_body.damping(v)
        return damping_command(body, self._last, len(self.robot.feet), self.load.rows)
