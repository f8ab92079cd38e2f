"""Commands as joints' own controllers take them: target, gains and feed-forward torque.

The drives of the Go2 and the G1 close a loop of their own at the joint, faster than any bus,

    τ = τ_ff + kp (q_des - q) + kd (v_des - v),

so that between two commands, and while one is late, a joint follows its plan instead of a torque that has
become wrong. The targets come from the accelerations of the whole-body controller, integrated

    v_des ← v_des + a dt + (v - v_des) dt / T,     q_des ← q_des + v_des dt + (q - q_des) dt / T,

which forgets what the joints did not follow in the time T: the feet's forces stay with the feed-forward
torques, and a leg that is held back is not pushed ever harder. Stance legs get a share of the gains: what
their joints miss after a push would otherwise slide the feet.
"""

from __future__ import annotations

from copy import copy
from typing import ClassVar

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Command, Controller, JointTargets, RobotState, Wrapper
from surefoot.motion.control.damping import computable

STIFFNESS = 0.5
"""kp over m g h, h the height of the base [1/rad]."""
DAMPING = 0.7
"""Ratio of the damping of a joint alone with its inertia and kp."""
MEMORY = 0.01
"""Time T in which a target forgets what was not followed [s]."""
STANCE_GAIN = 0.3
"""Share of both gains in stance legs."""


class CommandHold(Wrapper):
    """A controller that is asked every so many steps of the world; its torques stay between.

    Parameters
    ----------
    controller
        Made for the longer steps.
    every
        How many steps of the world its own are.
    """

    MEMORY: ClassVar[tuple[str, ...]] = ("_last", "_count")

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


class JointTargetController(CommandHold):
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
    >>> from surefoot.motion.walking.walking_controller import WalkingController
    >>> from surefoot.motion.walking.walking_body import VelocityCommand
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("go2")
    >>> walk = WalkingController(robot, VelocityCommand.constant(0.5, 0.0, 0.0), dt=2e-3)
    >>> controller = JointTargetController(walk, robot, 1e-3, every=2)
    >>> targets = controller.step(RobotState(robot.nominal, np.zeros(18))).joint_targets
    >>> controller.stiffness[:3].round(1), targets.stiffness[:3].round(1)  # all feet stand
    (array([26.4, 26.4, 26.4]), array([7.9, 7.9, 7.9]))
    """

    MEMORY = ("_kept",)

    def __init__(self, controller: Controller, robot: Robot, dt: float, every: int = 1) -> None:
        import pinocchio

        self.robot, first = robot, robot.base_dof
        super().__init__(controller, every)
        self.dt = every * real_number("dt", dt, low=1e-6)
        height = max(float(robot.nominal[2]), 0.05) if robot.floating else 1.0
        inertia = np.diag(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))[first:]
        self.stiffness = np.full(robot.joints, STIFFNESS * robot.mass * GRAVITY * height)
        self.damping = 2.0 * DAMPING * np.sqrt(self.stiffness * inertia)
        self._support = robot.contact_points.support[:, first:].copy()

    def _forget(self) -> None:
        """Let the next step's targets begin at the joints' state."""
        super()._forget()
        self._kept: FloatArray | None = None  # (2, joints) positions and velocities to go on from

    def _ask(self, state: RobotState) -> Command:
        """Return the controller's command with targets for the joints."""
        command = copy(super()._ask(state))  # `replace` makes every field anew, and in every step
        object.__setattr__(command, "joint_targets", self._targets(state, command))
        return command

    def _targets(self, state: RobotState, command: Command) -> JointTargets | None:
        """Return the targets that go with a command, in the middle of the time that it is held."""
        joints = self.robot.joints
        if command.accelerations is None or not computable(state.q, state.v):
            self._kept = None
            return None
        q, v = state.q[len(state.q) - joints :], state.v[len(state.v) - joints :]
        if self._kept is None:
            self._kept = np.array([q, v])
        active = np.ascontiguousarray(command.for_points(len(self._support)).active, dtype=bool)
        rate = np.ascontiguousarray(command.accelerations[len(command.accelerations) - joints :], np.float64)
        out = np.empty((4, joints))
        fill_joint_targets(
            q, v, rate, self.dt, self.stiffness, self.damping, self._support, active, self._kept, out
        )
        return JointTargets(out[0], out[1], out[2], out[3], command.torques)


@kernel
def fill_joint_targets(
    q: FloatArray, v: FloatArray, rate: FloatArray, dt: float, stiffness: FloatArray, damping: FloatArray,
    support: BoolArray, active: BoolArray, kept: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill `out` with the first four fields of `JointTargets`: (4, joints).

    Parameters
    ----------
    q, v, rate
        (joints,) of now [rad], [rad/s], and accelerations that are aimed at [rad/s²].
    dt
        Time for which the targets are held [s].
    stiffness, damping
        (joints,) of legs in the air.
    support, active
        (p, joints) which joints move each contact point, and (p,) which of these push.
    kept
        (2, joints) positions and velocities at the end of the last step: brought to the end of this.
    """
    forget = min(dt / MEMORY, 1.0)
    for j in range(len(q)):
        angle = kept[0, j] + forget * (q[j] - kept[0, j])
        speed = kept[1, j] + forget * (v[j] - kept[1, j])
        out[0, j] = angle + 0.5 * dt * speed + 0.125 * dt * dt * rate[j]
        out[1, j] = speed + 0.5 * dt * rate[j]
        kept[0, j] = angle + dt * speed + 0.5 * dt * dt * rate[j]
        kept[1, j] = speed + dt * rate[j]
        gain = 1.0
        for i in range(len(active)):
            if active[i] and support[i, j]:
                gain = STANCE_GAIN
        out[2, j], out[3, j] = gain * stiffness[j], gain * damping[j]
