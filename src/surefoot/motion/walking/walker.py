"""What controllers that walk share, on point feet and on flat ones: what gives the forces, and commands."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind
from surefoot.base.spatial import GRAVITY, heading_of
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.control.whole_body import Kinematics, WholeBodyCommand, WholeBodyController
from surefoot.motion.estimation.wrench_observer import BLOCK
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.behaviours.arbiter import Arbiter
from surefoot.motion.walking.behaviours.behaviour import WalkFacts
from surefoot.motion.walking.biped.settings import BipedSettings
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.tick import Tick
from surefoot.motion.walking.walk_state import WalkState
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_feet import FeetModel
from surefoot.motion.walking.walking_settings import WalkCommand, WalkSettings
from surefoot.records import CHANNELS, Channel

IMAGINED, THROWN_FOR, THROWN = 0.005, 0.1, 1.5
"""Steps of most of the walk that warms up, its last part in which the body is thrown [s], and how fast, every
degree of freedom [m/s, rad/s]: fast enough that torques meet their limits."""


def check_walk(command: Any, terrain: Any, settings: Any, kind: type) -> None:
    """Refuse what is no command, terrain or settings of a kind; the last two may be None."""
    of_kind("command", command, VelocityCommand)
    if terrain is not None:
        of_kind("terrain", terrain, Terrain)
    if settings is not None:
        of_kind("settings", settings, kind)


class Walker(Tick):
    """A controller that walks a robot.

    Attributes
    ----------
    robot, settings, schedule, terrain
        As they were given.
    notes
        What was changed in the command, one line each.
    granted
        Least share of a velocity asked for that is left of it.
    """

    robot: Robot
    settings: WalkSettings | BipedSettings
    schedule: ContactSchedule
    terrain: Terrain
    notes: list[str]
    granted: float
    _feet_model: FeetModel
    height: float

    @abstractmethod
    def _limit(self, wanted: VelocityCommand) -> VelocityCommand:
        """Return a command slowed to what is possible, and ready the gait for its speeds."""

    def steer(self, velocity: ArrayLike, posture: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
        """Take another velocity from now on, limited and ramped as any, and return what is left of it.

        Parameters
        ----------
        velocity
            (3,) forward, left [m/s], yaw rate [rad/s].
        posture
            (3,) height and clearance over the usual [m], and pitch [rad], see `VelocityCommand`.

        Returns
        -------
        FloatArray
            (3,) the same after limits [m/s, rad/s].

        Raises
        ------
        ProblemError
            For what is not three finite numbers each, or too steep a pitch.
        """
        wanted, pose = finite_array("velocity", velocity, (3,)), finite_array("posture", posture, (3,))
        self.command = self._limit(VelocityCommand(np.zeros(1), wanted[None], pose[None]))
        return self.command.at(0.0)

    def warm_up(self, state: RobotState) -> None:
        """Walk in imagination: the robot stays at a state, lifts its feet, is thrown, and nothing is kept.

        So every kernel that `step` may call is compiled or loaded, those of torque limits as well.
        """
        weight = np.tile([0.0, 0.0, self.robot.mass * GRAVITY], (len(self.robot.feet), 1))
        still = state._replace(v=np.zeros_like(state.v), contact=None, scan=None, forces=weight)
        thrown = still._replace(v=np.full_like(state.v, THROWN), torques=None)
        cycle = 1.5 * min(self.schedule.period or 1.0, 1.0)  # in which every foot lifts once
        end, block = self.start + cycle + THROWN_FOR, BLOCK + 2.0 * self.dt  # a load is looked for once
        times = np.concatenate([np.arange(0.0, block, self.dt), np.arange(block, end, IMAGINED)])
        for k, time in enumerate(times):
            self.step((thrown if time > end - THROWN_FOR and k % 2 else still)._replace(time=float(time)))
        model, clock = self._feet_model, GaitClock(end)
        centres = self.whole_body.update(state.q, state.v).centres
        model.motions(model.leap(model.standing(centres), clock, 0.1, centres), clock)
        self.whole_body.warm_up()
        self.reset()

    def _set_controllers(
        self, inertia: FloatArray, step: float, baumgarte: tuple[float, float],
        sole_damping: tuple[float, float] | None = None,
    ) -> None:  # fmt: skip
        """Make the MPC and the whole-body controller.

        Parameters
        ----------
        inertia
            (3, 3) of the robot about its centre of mass, in the axes that the MPC turns [kg m²].
        step
            Of the MPC [s].
        baumgarte, sole_damping
            See `WholeBodyController`.
        """
        s, robot, (low, high) = self.settings, self.robot, self._normals
        mu = s.mu * s.friction_share
        points = len(robot.contact_points)
        self.mpc = ConvexMpc(robot.mass, inertia, points, s.horizon, step, mu, low, high, s.mpc)
        self.whole_body = WholeBodyController(
            robot, mu, low, high, s.whole_body, baumgarte, None, s.actuators, sole_damping
        )

    @cached_property
    def _normals(self) -> tuple[float, float]:
        """Least and largest normal force of a contact point [N]."""
        weight = self.robot.mass * GRAVITY
        return self.settings.normal_min * weight, self.settings.normal_max * weight

    @cached_property
    def _pendulum(self) -> float:
        """sqrt(g / h) [rad/s]."""
        return math.sqrt(GRAVITY / self.height)

    @staticmethod
    def _swerve(now: Kinematics, state: RobotState, yaw: float) -> FloatArray:
        """Return the (3,) velocity of the centre of mass about a base that turns by 1 rad/s, heading axes."""
        x, y = (now.com - state.q[:3])[:2].tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([s * x - c * y, c * x + s * y, 0.0])

    @cached_property
    def _gains(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Stiffness [1/s²] and damping [1/s] of the feedback on the body and on feet in the air."""
        return self._gain(self.settings.body_stiffness), self._gain(self.settings.swing_stiffness)

    def _gain(self, share: float) -> tuple[float, float]:
        """Return stiffness [1/s²] and critical damping [1/s] at a multiple of the pendulum's rate."""
        rate = share * self._pendulum
        return rate**2, 2.0 * rate

    def _set_behaviours(self, radii: FloatArray, radius: float, watch_friction: bool) -> None:
        """Make the behaviours: feet of `radii` (n,) stand `radius` from the middle [m]."""
        s, weight = self.settings, self.robot.mass * GRAVITY
        walk = WalkFacts(
            self.terrain, self.schedule, radii, self.height, radius, weight, s.mu, self.dt, watch_friction,
            s.friction_share, s.behaviour_settings,
        )  # fmt: skip
        made = [behaviour for make in s.behaviours if (behaviour := make(walk)) is not None]
        self.arbiter = Arbiter(made, radius, self.notes, self._honoured())

    @abstractmethod
    def _honoured(self) -> frozenset[str]:
        """Return the quantities of a `Request` that this walk can do something about."""

    @property
    def facts(self) -> dict[str, Any]:  # type: ignore[override]
        """What the log should say about it."""
        low, high = self._normals
        x, y = heading_of(self.robot.nominal[3:7])
        return ({} if x == 1.0 else {"ahead": -math.atan2(y, x)}) | {
            "kind": "walk", "normal_min": low, "normal_max": high, "mu_controller": self.settings.mu,
            "gait": self.schedule.name, "notes": self.notes, "granted_share": self.granted,
            "behaviours": [behaviour.name for behaviour in self.arbiter.behaviours],
        }  # fmt: skip

    @property
    def channels(self) -> tuple[Channel, ...]:  # type: ignore[override]
        """What it adds to the log: what it wants, who asked for it, and what it has learned of the load."""
        return tuple(CHANNELS[name] for name in ("planned", "command", "asked_by", *self._load_rows))

    @property
    def _load_rows(self) -> dict[str, FloatArray]:
        """What is said of the load."""
        return {} if self.load is None else self.load.rows

    def _commanded(self, body: WholeBodyCommand, s: WalkState, possible: bool) -> WalkCommand:
        """Return the command that says what the parts have decided."""
        feet = s.feet
        return WalkCommand(
            body.torques, body.forces, feet.stance[self.whole_body.point_foot], body.feasible and possible,
            body.distribution, body.accelerations, planned=feet.planned, frames=feet.frames,
            wanted=s.body.base_velocity, targets=feet.target, load=self._load_rows,
            asked_by=self.arbiter.asked_by,
        )  # fmt: skip

    def _damped(self, v: FloatArray) -> WalkCommand:
        """Return the command for a state that is not finite, whose joints move with (nv,) v."""
        body = self.whole_body.damping(v)
        if self._walk is not None:
            return replace(self._commanded(body, self._walk, False), accelerations=None)
        n = len(self.robot.feet)
        return WalkCommand(
            body.torques, body.forces, np.ones(len(body.forces), dtype=bool), False, body.distribution,
            planned=np.ones(n, dtype=bool), frames=np.tile(np.eye(3), (n, 1, 1)), wanted=np.zeros(3),
            targets=np.zeros((n, 3)),
            load=self._load_rows,
        )  # fmt: skip
