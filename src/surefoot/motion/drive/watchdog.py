"""What happens when no fresh state comes: after a while the joints are damped, and the log says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.discrete_damping import DELAYED, largest_damping
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Command, Controller, JointTargets, RobotState, Wrapper
from surefoot.records import CHANNELS

PATIENCE = 0.02
"""Age of a state from which it is stale [s]."""
DAMPING_TIME = 0.1
"""Damping of a joint over m g h [s/rad], h the height of the base: a leg gives way slowly."""


@dataclass(frozen=True, kw_only=True)
class WatchedCommand(Command):
    """A controller's command, and whether the state was too old for one.

    Attributes
    ----------
    stale
        Whether the joints are damped because no fresh state came.
    inner
        The values of the controller's own channels.
    """

    stale: bool
    inner: Mapping[str, Any]

    def rows(self) -> dict[str, Any]:
        """Return the controller's rows, and `stale`."""
        return {**self.inner, "stale": self.stale}


def damping_targets(robot: Robot, dt: float) -> JointTargets:
    """Return targets that damp the joints and do nothing else, for drives that close their loop every dt [s].

    Less on light legs than on heavy ones, so that none shakes.
    """
    import pinocchio

    height = max(float(robot.nominal[2]), 0.05) if robot.floating else 1.0
    inertia = np.diag(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))
    none = np.zeros(robot.joints)
    damping: FloatArray = np.minimum(
        DAMPING_TIME * robot.mass * GRAVITY * height,
        largest_damping(inertia[robot.base_dof :], dt, DELAYED),
    )
    return JointTargets(none, none, none, damping, none)


class Watchdog(Wrapper):
    """A controller that is not asked with a state which is too old; the outermost of several.

    States tell when they were true. Older than `patience`, they are of no use: joints with controllers
    of their own are damped (kp = 0, v_des = 0), and get no torque otherwise. The first fresh state
    ends that.

    Parameters
    ----------
    controller
        Who commands.
    robot
        Whose joints.
    dt
        Time between calls of `step` [s].
    patience
        Age of a state from which it is stale [s].
    """

    MEMORY = ("_last", "_now")

    def __init__(self, controller: Controller, robot: Robot, dt: float, patience: float = PATIENCE) -> None:
        super().__init__(controller)
        self.dt = real_number("dt", dt, low=1e-6)
        self.patience = real_number("patience", patience, low=0.0)
        self.channels = (*controller.channels, CHANNELS["stale"])
        self._damp = damping_targets(robot, self.dt)
        self._forget()

    def _forget(self) -> None:
        """Take the next step's state for fresh."""
        self._last: Command | None = None
        self._now: float | None = None

    def step(self, state: RobotState) -> WatchedCommand:
        """Return the controller's command, or damping if the state is too old."""
        self._now = state.time if self._now is None else self._now + self.dt
        age = self._now - state.time
        stale = self._last is not None and not age <= self.patience + 0.5 * self.dt
        if not stale or self._last is None:
            self._last = self.controller.step(state)
        return self._watch_command(self._last, stale)

    def _watch_command(self, command: Command, stale: bool) -> WatchedCommand:
        """Return a command with what the watchdog says."""
        own = WatchedCommand(
            command.torques, command.forces, command.active, command.attained, command.status,
            command.accelerations, command.joint_targets, stale=stale, inner=command.rows(),
        )  # fmt: skip
        if not stale:
            return own
        return replace(
            own, torques=np.zeros_like(own.torques), forces=np.zeros_like(own.forces),
            active=np.zeros_like(own.active), attained=False, accelerations=None, joint_targets=self._damp,
        )  # fmt: skip
