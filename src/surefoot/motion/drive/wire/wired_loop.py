"""The controller's end of the wire: a state comes, the loop makes a step, a command goes."""

from __future__ import annotations

import gc
import time as clock
from collections import Counter
from collections.abc import Callable

from numpy.typing import ArrayLike

from surefoot.base.errors import ProblemError, SurefootError
from surefoot.motion.drive.modes import POWERLESS
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.motion.drive.wire.dialect import Dialect
from surefoot.motion.drive.wire.packed import PackedMessage
from surefoot.motion.drive.wire.simulator import OVERDUE, STOPPED, SimulatorClock
from surefoot.motion.drive.wire.survey import refusals_in_words
from surefoot.motion.drive.wire.transport import Transport

LATE = 1.5
"""A reading is missing after so many steps since the last."""
PATIENT = 1.0
"""Time without a state in slow motion after which the robot is looked for [s]."""
AGAIN = 0.5
"""In slow motion a state that comes again so long after its answer has not got it [s]."""
LONGEST, REST = 30.0, 0.5
"""Longest time to reach a posture, and time in it before the next [s]."""
NOTHING_CAME = "no reading came"
"""The loop's reason where it was given no reading."""


class WiredLoop:
    """A loop that answers each state on the wire, and makes a step without one that is missing.

    Parameters
    ----------
    loop
        With the motors of the dialect.
    end
        Of the wire.
    dialect
        What is spoken there.
    slow
        Whether the robot waits for each answer, so that no clock tells what is late.
    watch
        Called after each step; None for nobody.
    simulator
        Tells the time of a simulator's readings; None for a robot.

    Attributes
    ----------
    refused
        How many readings were void, by reason.
    rivals
        Who else began to command the robot, in words; the loop damped it then.
    """

    def __init__(
        self, loop: RobotLoop, end: Transport, dialect: Dialect, slow: bool = False,
        watch: Callable[[RobotLoop], None] | None = None, simulator: SimulatorClock | None = None,
    ) -> None:  # fmt: skip
        self.loop, self.end, self.dialect, self.slow, self.watch = loop, end, dialect, slow, watch
        self.simulator = simulator
        self.refused: Counter[str] = Counter()
        self.rivals: tuple[str, ...] = ()
        self._late = LATE * loop.dt if simulator is None else OVERDUE
        self._patience = STOPPED if simulator is not None else PATIENT
        self._machine = 0
        self._sent: PackedMessage | None = None
        self._answered, self._answer_at = -1.0, 0.0
        self._due = clock.perf_counter()

    def wait(self, seconds: float) -> None:
        """Wait for a robot.

        Raises
        ------
        SurefootError
            If none speaks in that time [s].
        """
        message = self.end.receive(seconds)
        if message is None:
            raise SurefootError(f"no robot speaks on the wire: {seconds:g} s without a state")
        self._due = clock.perf_counter() + PATIENT

    def step(self) -> None:
        """Wait for the next state, make a step and send what it asks for."""
        dt = self.loop.dt
        message, readings = self._next()
        now = clock.perf_counter()
        if message is None:
            self._due += dt
        else:
            self._machine = 0 if self.dialect.headed else int(message["mode_machine"])
            self._due = now + self._late
        targets = self.loop.step(readings, None if self.slow else now)
        self._sent = self.dialect.command_message(targets, self._machine)
        self.end.send(self._sent)
        if self.slow and message is not None:  # a step may take long where machines are busy
            self._answer_at = clock.perf_counter()
            self._answered = -1.0 if readings is None else readings.time
            self._due = self._answer_at + self._patience
        self.loop.plan_ahead()
        self._look_out()
        if self.watch is not None:
            self.watch(self.loop)
        if not gc.isenabled():
            gc.collect(1)  # what the step leaves, in the time that nobody waits for

    def _next(self) -> tuple[PackedMessage | None, RobotReadings | None]:
        """Return the next message and what it reads; None for one that is late, and for one that is void."""
        while True:
            message = self.end.receive(max(self._due - clock.perf_counter(), 1e-5))
            if message is None:
                if self.slow and self.end.partners():  # it is there, and waits for nobody else
                    self._due = clock.perf_counter() + self._patience
                    continue
                return None, None
            readings = self.dialect.readings(message)
            if readings is None:
                self.refused[self.dialect.refusal(message)] += 1
            elif self._comes_again(readings):
                continue
            if self.simulator is None or readings is None:
                return message, readings
            # in slow motion a step has no length by any clock
            now = self.loop.time + self.loop.dt if self.slow else clock.perf_counter()
            time = self.simulator.stamp(readings.time, now)
            if time is not None:
                return message, readings._replace(time=time)

    def _comes_again(self, readings: RobotReadings) -> bool:
        """Return whether a robot in slow motion repeats an answered state; answer again if need be.

        It repeats what nobody answers for a while: the answer was late, or it was lost.
        """
        if not self.slow or self.simulator is not None or readings.time != self._answered:
            return False
        if self._sent is not None and clock.perf_counter() - self._answer_at >= AGAIN:
            self.end.send(self._sent)
            self._answer_at = clock.perf_counter()
        return True

    def _look_out(self) -> None:
        """Damp the robot if somebody else begins to command it."""
        if self.rivals or not (found := tuple(self.end.rivals())):
            return
        self.rivals = found
        self.loop.go("damp")
        self.loop.fault = self.fault

    @property
    def fault(self) -> str:
        """Why control was lost last, with who else commands and what was refused; empty for no fault."""
        if self.rivals:
            return f"somebody else commands the robot, too: {'; '.join(self.rivals)}"
        return self._explain(self.loop.fault)

    def _explain(self, reason: str) -> str:
        """Return a reason with how many readings were refused, where none came that could be used."""
        if NOTHING_CAME not in reason or not self.refused:
            return reason
        return f"{reason} that could be used: {refusals_in_words(self.refused)} were refused"

    def go(self, goal: str, seconds: float | None = None) -> bool:
        """Go to a mode and stay for a time [s], None until it is reached; return whether no fault came.

        Raises
        ------
        ProblemError
            For what may not follow now.
        SurefootError
            If a posture is not reached in `LONGEST`.
        """
        loop = self.loop
        for _ in range(round(REST / loop.dt)):  # a short silence is waited for
            if not loop.watch.blind:
                break
            self.step()
        if self.rivals and goal not in POWERLESS:
            return False
        try:
            loop.go(goal)
        except ProblemError as error:
            raise ProblemError(self._explain(str(error))) from error
        begin = rested = loop.time
        while not loop.fault:
            self.step()
            if seconds is None:
                rested = rested if loop.settled and loop.mode.value == goal else loop.time
                if loop.time - rested >= REST:
                    return True
                if loop.time - begin > LONGEST:
                    raise SurefootError(f"{goal} was not reached in {LONGEST:g} s")
            elif loop.time - begin >= seconds:
                return True
        return False

    def outing(self, velocity: ArrayLike, seconds: float, end: str) -> str:
        """Stand up, walk at a (3,) velocity [m/s, m/s, rad/s] for a time [s], stop, end as is said, and damp.

        Returns the fault that ended it early, empty for none.
        """
        self.loop.steer(velocity)
        stages = (("damp", 0.2), ("stand", None), ("walk", seconds), ("stand", None), (end, None))
        for goal, time in stages:
            if not self.go(goal, time):
                break
        fault = self.fault
        self.go("damp", REST)
        return fault
