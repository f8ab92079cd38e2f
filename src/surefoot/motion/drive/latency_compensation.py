"""A controller whose commands take effect late: it acts on the state that it expects by then.

A command that is computed from the state at t and acts from t + δ on meets the state at t + δ. Until then the
commands of the last δ act, whose accelerations are known to whoever commanded them::

    v(t + δ) = v + Σ a_k dt,      q(t + δ) = q ⊕ (v δ + Σ a_k dt (δ - s_k))

with s_k the middle of the step in which a_k acts: a Smith predictor [1]_ whose model is the plan.

The delay is given, or measured: the torques that the motors report are those that were commanded δ ago. A
state that is older than it should be, by its own time, is carried on by its age as well.

References
----------
.. [1] O. J. M. Smith, "Closer control of loops with dead time", Chemical Engineering Progress 53, 1957.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.kernels import kernel
from surefoot.base.memory import Remembering
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Command, Controller, RobotState, Wrapper
from surefoot.motion.control.damping import computable

LONGEST = 0.03
"""Longest delay that is looked for [s]."""
COMPARED = 0.1
"""Time over which reported and commanded torques are compared [s]."""
EVIDENCE = 4.0
"""How many times better another delay must fit than the one believed so far before it is believed."""


class DelayMeter(Remembering):
    """Measures after how many steps commanded torques are reported by the motors.

    Parameters
    ----------
    joints
        Number of joints.
    dt
        Time between steps [s].
    """

    MEMORY = ("steps", "_asked", "_misfit", "_seen")

    def __init__(self, joints: int, dt: float) -> None:
        self._count = round(LONGEST / dt) + 1
        self._keep = float(np.exp(-dt / COMPARED))
        self._joints = joints
        self.reset()

    def reset(self) -> None:
        """Forget the past; the delay is none until something else is seen."""
        self.steps = 0
        self._asked = np.zeros((self._count, self._joints))
        self._misfit = np.zeros(self._count)
        self._seen = 0

    def note_command(self, torques: FloatArray) -> None:
        """Record the (joints,) torques commanded in this step [N m]."""
        self._seen += 1
        note(self._asked, self._seen, torques)

    def compare_report(self, torques: FloatArray) -> int:
        """Return the estimated delay in steps, given the (joints,) torques that the motors reported [N m]."""
        if self._seen:
            self.steps = fitting(self._asked, self._seen, torques, self._keep, self._misfit, self.steps)
        return self.steps


@kernel
def note(asked: FloatArray, count: int, torques: FloatArray) -> None:
    """Write (joints,) torques [N m], the count-th of all, into a ring (rows, joints); 0 if not finite."""
    row = asked[(count - 1) % len(asked)]
    for j in range(len(torques)):
        row[j] = torques[j] if math.isfinite(torques[j]) else 0.0


@kernel
def fitting(
    asked: FloatArray, count: int, torques: FloatArray, keep: float, misfit: FloatArray, steps: int
) -> int:
    """Return which delay in steps fits (joints,) reported torques [N m] best, after those before.

    Parameters
    ----------
    asked, count
        (rows, joints) ring of commands [N m], and how many there were.
    torques
        (joints,) that the motors tell; ones that are not finite change nothing.
    keep, misfit
        How much of the past is kept, and (rows,) sums of squares for each delay [N² m²]; changed.
    steps
        What was believed so far; kept unless another fits `EVIDENCE` times better.
    """
    for j in range(len(torques)):
        if not math.isfinite(torques[j]):
            return steps
    rows, best = len(asked), 0
    for k in range(rows):
        misfit[k] *= keep
        row = asked[(count - 1 - k) % rows]
        for j in range(len(torques)):
            misfit[k] += (row[j] - torques[j]) ** 2
        if k < count and misfit[k] < misfit[best]:
            best = k
    return best if EVIDENCE * misfit[best] < misfit[steps] else steps


class LatencyCompensation(Wrapper):
    """A controller that acts on the state to come; see the module.

    Parameters
    ----------
    controller
        Whose commands tell their `accelerations`; those that do not count as zero.
    robot
        Whose state.
    dt
        Time between steps [s].
    delay
        Between a state and its torques [s]; None to measure it.

    Raises
    ------
    ProblemError
        For a delay that is negative or longer than `LONGEST`.
    """

    MEMORY = ("meter", "_past", "_now")

    def __init__(self, controller: Controller, robot: Robot, dt: float, delay: float | None = None) -> None:
        super().__init__(controller)
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self._given = (
            None if delay is None else round(real_number("delay", delay, low=0.0, high=LONGEST) / dt)
        )
        self.meter = DelayMeter(robot.joints, dt)
        most = round(LONGEST / dt) + 1
        self._past: deque[FloatArray] = deque(maxlen=most)
        # time from the middle of each of so many steps to their end
        self._left = [k * self.dt - self.dt * (np.arange(k) + 0.5) for k in range(most + 1)]
        self._now: float | None = None

    def _forget(self) -> None:
        self.meter.reset()
        self._past.clear()
        self._now = None

    @property
    def steps(self) -> int:
        """The delay that it allows for, in steps."""
        return self.meter.steps if self._given is None else self._given

    def step(self, state: RobotState) -> Command:
        """Return the command for the state when it will act."""
        self._now = state.time if self._now is None else self._now + self.dt
        if self._given is None and state.torques is not None:
            self.meter.compare_report(state.torques)
        command = self.controller.step(self.ahead(state))
        aimed = command.accelerations
        self._past.append(np.zeros(self.robot.model.nv) if aimed is None else aimed)
        self.meter.note_command(command.torques)
        return command

    def ahead(self, state: RobotState) -> RobotState:
        """Return the state in which a command for this one will act."""
        age = 0 if self._now is None else max(round((self._now - state.time) / self.dt), 0)
        steps = min(self.steps + age, len(self._past))
        if steps == 0 or not computable(state.q, state.v):
            return state
        import pinocchio

        accelerations = np.array([self._past[k] for k in range(-steps, 0)])  # the first acts now
        delay, dt = steps * self.dt, self.dt
        move = delay * state.v + dt * (self._left[steps] @ accelerations)
        q = np.asarray(pinocchio.integrate(self.robot.model, state.q, move))
        v = state.v + dt * np.add.reduce(accelerations)
        return RobotState(q, v, state.time + delay, *state[3:]) if computable(q, v) else state
