"""What controllers that walk share, on point feet and on flat ones: what gives the forces, and commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array
from surefoot.control.biped.settings import BipedSettings
from surefoot.control.controller import Controller
from surefoot.control.gait import ContactSchedule
from surefoot.control.mpc import ConvexMpc
from surefoot.control.walking_body import BodyPlan, VelocityCommand
from surefoot.control.walking_feet import Feet
from surefoot.control.walking_settings import WalkCommand, WalkSettings, damping_command
from surefoot.control.whole_body import WholeBodyCommand, WholeBodyController
from surefoot.log.channels import CHANNELS
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY


class Walker(Controller):
    """A controller that walks a robot.

    Attributes
    ----------
    robot, settings, schedule
        As they were given.
    command
        Wanted velocity over time, after limits.
    notes
        What was changed in the command, one line each.
    body
        The motion of the body that is wanted.
    """

    channels = tuple(CHANNELS[name] for name in ("planned", "command"))
    robot: Robot
    settings: WalkSettings | BipedSettings
    schedule: ContactSchedule
    command: VelocityCommand
    notes: list[str]
    body: BodyPlan
    _limit: Callable[[VelocityCommand], VelocityCommand]
    _last: WalkCommand | None

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
        self.facts = {
            "kind": "walk", "normal_min": low, "normal_max": high, "mu_controller": s.mu,
            "gait": getattr(self.schedule, "name", "schedule"), "notes": self.notes,
        }  # fmt: skip
        return low, high

    def _commanded(
        self, body: WholeBodyCommand, feet: Feet, load: Mapping[str, FloatArray] | None = None
    ) -> WalkCommand:
        """Return the command that tells what the parts have decided."""
        self._last = WalkCommand(
            body.torques, body.forces, feet.carrying[self.whole_body.point_foot], body.feasible, body.status,
            feet.planned.copy(), feet.frames.copy(), self.body.velocity.copy(), feet.target.copy(),
            accelerations=body.accelerations, load=load or {},
        )  # fmt: skip
        return self._last

    def _blind(self, v: FloatArray, load: Mapping[str, FloatArray] | None = None) -> WalkCommand:
        """Return the command for a state that is not finite."""
        return damping_command(self.whole_body.damping(v), self._last, len(self.robot.feet), load or {})
