"""Commands as joints' own controllers take them: target, gains and feed-forward torque.

The drives of the Go2 and the G1 close a loop of their own at the joint, faster than any bus,

    τ = τ_ff + kp (q_des - q) + kd (v_des - v),

so that between two commands, and while one is late, a joint follows its plan instead of a torque that has
become wrong. The targets come from the accelerations of the whole-body controller, integrated

    v_des ← v_des + a dt + (v - v_des) dt / T,     q_des ← q_des + v_des dt + (q - q_des) dt / T,

which forgets what the joints did not follow in the time T: the feet's forces stay with the feed-forward
torques, and a leg that is held back is not pushed ever harder. Legs that carry get a share of the gains: what
their joints miss after a push would otherwise slide the feet.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.arrays import FloatArray, real_number
from surefoot.control.controller import Command, Controller, JointTargets, RobotState, Wrapper
from surefoot.control.damping import computable
from surefoot.errors import ProblemError
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY

STIFFNESS = 0.5
"""kp over m g h, h the height of the base [1/rad]."""
DAMPING = 0.7
"""Ratio of the damping of a joint alone with its inertia and kp."""
MEMORY = 0.01
"""Time T in which a target forgets what was not followed [s]."""
CARRYING = 0.3
"""Share of both gains in legs that carry."""


class Held(Wrapper):
    """A controller that is asked every so many steps of the world; its torques stay between.

    Parameters
    ----------
    controller
        Made for the longer steps.
    every
        How many steps of the world its own are.
    """

    def __init__(self, controller: Controller, every: int) -> None:
        super().__init__(controller)
        if every < 1:
            raise ProblemError(f"every must be 1 or more steps of the world, got {every}")
        self.every = every
        self._forget()

    def _forget(self) -> None:
        self._last: Command | None = None
        self._count = 0

    def step(self, state: RobotState) -> Command:
        """Return the controller's command, the last one between its steps."""
        if self._last is None or self._count % self.every == 0:
            self._last = self._ask(state)
        self._count += 1
        return self._last

    def _ask(self, state: RobotState) -> Command:
        """Return a new command."""
        return self.controller.step(state)


class JointTargetController(Held):
    """A controller whose commands go to joints with controllers of their own; see the module.

    Parameters
    ----------
    controller
        Made for steps of ``every * dt``; its commands tell the accelerations that they aim at, else
        they stay torques.
    robot
        Whose joints.
    dt
        Time between calls of `step` [s].
    every
        The controller's step in steps of the world: targets are held between.

    Attributes
    ----------
    stiffness, damping
        (joints,) kp [N m/rad] and kd [N m s/rad] of legs in the air.

    Examples
    --------
    >>> from surefoot.control.walking import WalkingController
    >>> from surefoot.control.walking_body import VelocityCommand
    >>> from surefoot.robot import load_robot
    >>> robot = load_robot("go2")
    >>> walk = WalkingController(robot, VelocityCommand.constant(0.5, 0.0, 0.0), dt=2e-3)
    >>> controller = JointTargetController(walk, robot, 1e-3, every=2)
    >>> targets = controller.step(RobotState(robot.nominal, np.zeros(18))).joint_targets
    >>> controller.stiffness[:3].round(1), targets.stiffness[:3].round(1)  # all feet carry
    (array([26.4, 26.4, 26.4]), array([7.9, 7.9, 7.9]))
    """

    def __init__(self, controller: Controller, robot: Robot, dt: float, every: int = 1) -> None:
        import pinocchio

        self.robot, first = robot, robot.base_dof
        super().__init__(controller, every)
        self.dt = every * real_number("dt", dt, low=1e-6)
        height = max(float(robot.nominal[2]), 0.05) if robot.floating else 1.0
        inertia = np.diag(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))[first:]
        self.stiffness = np.full(robot.joints, STIFFNESS * robot.mass * GRAVITY * height)
        self.damping = 2.0 * DAMPING * np.sqrt(self.stiffness * inertia)
        self._support = robot.contact_points.support[:, first:]

    def _forget(self) -> None:
        """Let the next step's targets begin at the joints' state."""
        super()._forget()
        self._positions: FloatArray | None = None
        self._velocities = np.zeros(self.robot.joints)

    def _ask(self, state: RobotState) -> Command:
        """Return the controller's command with targets for the joints."""
        command = super()._ask(state)
        return replace(command, joint_targets=self._targets(state, command))

    def _targets(self, state: RobotState, command: Command) -> JointTargets | None:
        """Return the targets that go with a command, in the middle of the time that it is held."""
        joints = self.robot.joints
        if command.accelerations is None or not computable(state.q, state.v):
            self._positions = None
            return None
        q, v = state.q[len(state.q) - joints :], state.v[len(state.v) - joints :]
        if self._positions is None:
            self._positions, self._velocities = q.copy(), v.copy()
        dt, rate = self.dt, command.accelerations[len(command.accelerations) - joints :]
        forget = min(dt / MEMORY, 1.0)
        self._positions = self._positions + forget * (q - self._positions)
        self._velocities = self._velocities + forget * (v - self._velocities)
        positions = self._positions + 0.5 * dt * self._velocities + 0.125 * dt * dt * rate
        velocities = self._velocities + 0.5 * dt * rate
        self._positions = self._positions + dt * self._velocities + 0.5 * dt * dt * rate
        self._velocities = self._velocities + dt * rate
        carries = self._support[command.for_points(len(self._support)).active].any(axis=0)
        gain = np.where(carries, CARRYING, 1.0)
        return JointTargets(
            positions, velocities, gain * self.stiffness, gain * self.damping, command.torques
        )
