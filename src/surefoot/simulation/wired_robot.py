"""The robot's end of the wire, with a robot in MuJoCo behind it."""

from __future__ import annotations

import time as clock

from surefoot.control.controller import JointTargets
from surefoot.drive.readings import motor_order
from surefoot.drive.wire.dialect import Dialect
from surefoot.drive.wire.link import WireEnd
from surefoot.simulation.motor_robot import MotorRobot

SILENCE = 0.02
"""Time without a command that can be obeyed, after which the joints are damped [s]."""
MACHINE = 5
"""A humanoid's `mode_machine`."""
PATIENT = 1.0
"""Longest wait for an answer in slow motion [s]."""


class WiredRobot:
    """Says what its sensors read and does what commands ask for; damps its joints when none comes.

    Parameters
    ----------
    robot
        The robot.
    end
        Of the wire.
    dialect
        What is spoken there.
    slow
        Whether each state waits for its answer: slower than real time on a busy machine, and nothing is late.

    Attributes
    ----------
    damped
        How many steps it has damped by itself since the first command.
    """

    def __init__(self, robot: MotorRobot, end: WireEnd, dialect: Dialect, slow: bool = False) -> None:
        self.robot, self.end, self.dialect, self.slow = robot, end, dialect, slow
        self._back, self._order = motor_order(robot.robot, dialect.motors)
        self._silent, self._heard, self.damped = 0.0, False, 0
        self._due = clock.perf_counter()

    def step(self) -> None:
        """Say what is read, listen, and go on by a step."""
        robot = self.robot
        self.end.send(self.dialect.told(robot.read().ordered(self._order), MACHINE))
        self._due = max(self._due + robot.dt, clock.perf_counter() - robot.dt)
        left = max(self._due - clock.perf_counter(), 1e-5)
        message = self.end.receive(PATIENT if self.slow and self._heard and not self._silent else left)
        targets = None if message is None else self.dialect.targets(message, MACHINE)
        if targets is not None:
            self._heard, self._silent = True, 0.0
            robot.take(JointTargets(*(values[self._back] for values in targets)))
        else:
            self._silent += robot.dt
            if self._silent >= SILENCE - 1e-9:
                self.damped += self._heard
                robot.take(None)
        robot.step()
        left = self._due - clock.perf_counter()
        if left > 0.0 and not self.slow:
            clock.sleep(left)
