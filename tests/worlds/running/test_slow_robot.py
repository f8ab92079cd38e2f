"""A robot on the wire in slow motion: it waits for answers while somebody is there to give them."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.motion import JointTargets, PackedMessage
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.worlds.running.motor_robot import MACHINE, SILENCE, MotorRobot, WiredRobot
from tests.robots import robot_of

GO2 = robot_of("go2")
DIALECT = dialect_of(GO2)


class Controller:
    """Answers every state, some of them only when they are said for the third time."""

    def __init__(self, stubborn: set[int]) -> None:
        self.stubborn, self.states, self.here = stubborn, list[bytes](), 1

    def send(self, message: PackedMessage) -> None:
        """Hear a state."""
        self.states.append(bytes(message.data))

    def receive(self, timeout: float) -> PackedMessage | None:
        """Answer it."""
        said = self.states.count(self.states[-1])
        if not self.here or (len(set(self.states)) in self.stubborn and said < 3):
            return None
        return DIALECT.command_message(JointTargets(*np.zeros((3, 12)), np.ones(12), np.zeros(12)), MACHINE)

    def partners(self) -> int:
        """Return whether it is there."""
        return self.here


def test_it_says_again_what_nobody_answers_and_goes_on_when_nobody_is_there() -> None:
    end = Controller({4, 7})
    body = MotorRobot(GO2)
    wired = WiredRobot(body, end, DIALECT, slow=True)  # type: ignore[arg-type]
    for _ in range(10):
        wired.step()
    assert body.time == pytest.approx(10 * body.dt)
    assert len(set(end.states)) == 10
    assert len(end.states) == 14
    assert wired.damped == 0
    end.here = 0
    for _ in range(round(SILENCE / body.dt) + 5):
        wired.step()
    assert wired.damped > 0
