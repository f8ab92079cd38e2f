"""How a robot stops that does not know its state: every joint goes to the stance and holds there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.discrete_damping import DELAYED, largest_damping
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Command, RobotState
from surefoot.motion.drive.postures import DAMPING

APPROACH = 0.4
"""Time in which the joints go to the nominal pose [s]."""


class Standstill(Remembering):
    """Torques from the joints' own angles and speeds alone; the next call of `torques` is the first.

    A joint's stiffness is m g h per radian, h the height of the base: legs give way by a tenth of a radian
    or so under the weight.

    Parameters
    ----------
    robot
        With a floating base.
    dt
        Time between steps [s].
    """

    MEMORY = ("_start", "_time")

    def __init__(self, robot: Robot, dt: float) -> None:
        import pinocchio

        self.dt = real_number("dt", dt, low=1e-6)
        self._goal, self._limits = robot.nominal[7:].copy(), robot.effort_limits
        inertia = np.diag(pinocchio.crba(robot.model, robot.model.createData(), robot.nominal))[6:]
        self._stiffness = robot.mass * GRAVITY * max(float(robot.nominal[2]), 0.05)
        self._damping = np.minimum(DAMPING * self._stiffness, largest_damping(inertia, dt, DELAYED))
        self._start: FloatArray | None = None
        self._time = 0.0

    def torques(self, positions: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return (joints,) torques within the limits [N m]; one whose numbers are not finite is zero."""
        if self._start is None:
            self._start = np.where(np.isfinite(positions), positions, self._goal)
        share = min(self._time / APPROACH, 1.0)
        self._time += self.dt
        target = self._start + share * share * (3.0 - 2.0 * share) * (self._goal - self._start)
        wanted = self._stiffness * (target - positions) - self._damping * speeds
        return np.clip(np.where(np.isfinite(wanted), wanted, 0.0), -self._limits, self._limits)

    def command(self, state: RobotState, last: Command) -> Command:
        """Return the command for a state whose joints alone are known, after the last one: no forces."""
        return replace(
            last,
            torques=self.torques(state.q[7:], state.v[6:]),
            forces=np.zeros_like(last.forces),
            active=np.zeros_like(last.active),
            attained=False,
        )
