"""The state of a robot's loop as a value: all that lasts from one reading to the next."""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Arrays, Memory, Remembering, alike, read_state, write_down
from surefoot.motion.control.controller import Command
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.drive.modes import LoopMode
from surefoot.motion.drive.postures import PostureMotion
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.state_kinds import STATE_KINDS
from surefoot.motion.estimation.state_estimator import Reading
from surefoot.motion.state import RobotState
from surefoot.motion.walking.walker import Walker


@dataclass(frozen=True, eq=False)
class LoopState:
    """All that lasts in a `RobotLoop` from one reading to the next.

    Attributes
    ----------
    made
        What the loop was made with, in words: another one does not go on from this state.
    mode, fault, time
        See `RobotLoop`.
    recover
        Whether it gets up by itself.
    began
        Time at which the balance controller began [s].
    velocity, posture
        (3,) each, what `steer` asked for last [m/s, rad/s], [m, rad, m].
    steered
        What of these the balance controller was told, as bytes.
    balance
        Name of the gait of the controller that balances, or would.
    reading, estimate, command
        What the estimator was given last, what it made of that, and the balance controller's answer; None
        in modes without.
    parts
        Memories of the watch on readings, of getting up, of postures and of the estimate, by name.
    balances
        By gait the state of the controller, and whether it plans once its command is given.
    """

    made: str
    mode: LoopMode
    fault: str
    time: float
    recover: bool
    began: float
    velocity: FloatArray
    posture: FloatArray
    steered: tuple[bytes, ...]
    balance: str
    reading: Reading | None
    estimate: RobotState | None
    command: Command | None
    parts: dict[str, Memory]
    balances: dict[str, tuple[Any, bool]]

    def __eq__(self, other: object) -> bool:
        """Return whether another state is the same to the last bit."""
        return isinstance(other, LoopState) and alike(self, other)

    __hash__ = None  # type: ignore[assignment]

    def to_arrays(self) -> tuple[Arrays, Any]:
        """Return the state as plain arrays by path, and facts that JSON can hold."""
        return write_down(self, KINDS)

    @staticmethod
    def from_arrays(arrays: Arrays, facts: Any) -> LoopState:
        """Return the state that `to_arrays` has written down.

        Raises
        ------
        ProblemError
            For arrays and facts that are no such state.
        """
        return read_state(LoopState, "a loop", arrays, facts, KINDS)


KINDS: dict[str, type] = STATE_KINDS | {
    kind.__name__: kind for kind in (LoopState, LoopMode, PostureMotion, Reading, RobotReadings)
}
"""Classes of what the state of a loop consists of, by name."""
OWN = {
    "mode": "mode", "fault": "fault", "time": "time", "recover": "recover", "began": "_began",
    "velocity": "_velocity", "posture": "_posture", "steered": "_steered", "reading": "_reading",
    "estimate": "estimate", "command": "command",
}  # fmt: skip
"""Fields of a state that a loop has as attributes, and the attributes' names."""


class ResumableLoop:
    """A loop that tells its state and goes on from one; `RobotLoop` is what it does.

    Attributes
    ----------
    walker
        The balance controller.
    """

    walker: Walker
    _controller: LatencyCompensation
    _make: tuple[str, Mapping[str, tuple[Walker, LatencyCompensation]]]
    """What the loop was made with, in words, and the balance controllers by their gaits."""

    @abstractmethod
    def _parts(self) -> dict[str, Remembering]:
        """Return what remembers something beside the balance controllers, by name."""

    @property
    def state(self) -> LoopState:
        """A copy of all that lasts from one reading to the next, for `resume`.

        A plan that has been left to `plan_ahead` is made first.
        """
        made, balances = self._make
        own = {name: copy.deepcopy(getattr(self, attribute)) for name, attribute in OWN.items()}
        (now,) = (name for name, (walker, _) in balances.items() if walker is self.walker)
        parts = {name: part.remembered() for name, part in self._parts().items()}
        states = {name: (one.state, walker.answers_first) for name, (walker, one) in balances.items()}
        return LoopState(made=made, balance=now, parts=parts, balances=states, **own)

    def resume(self, state: LoopState) -> None:
        """Go on from the state of a loop that was made in the same way, to the last bit.

        Raises
        ------
        ProblemError
            For a state of another loop, or one that does not fit.
        """
        made, balances = self._make
        if state.made != made:
            raise ProblemError(f"the state is of another loop: {state.made:.200}, this is {made:.200}")
        state = copy.deepcopy(state)
        try:
            for name, (walker, controller) in balances.items():
                own, walker.answers_first = state.balances[name]
                controller.resume(own)
            for name, part in self._parts().items():
                part.resume(state.parts[name])
            self.walker, self._controller = balances[state.balance]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ProblemError(f"the state does not fit: {type(error).__name__} {error}") from error
        for field in fields(state):
            if field.name in OWN:
                setattr(self, OWN[field.name], getattr(state, field.name))
