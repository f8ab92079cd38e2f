"""What a rollout puts into its world, step by step: kept the first time, and asked for again elsewhere.

A rollout is the user's own function. It is run once to be kept. Run again while a recorder gives the world
the states that it is to be in, it takes no steps: what it then puts in says how that depends on the states (a
controller) and on the rollout's parameters, without any derivative of the user's code.
"""

from __future__ import annotations

from collections import deque
from contextvars import ContextVar
from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, State, Step, StepOptions, Stepper

KEPT = 2000
"""Steps whose contact problems are kept, the last ones; others are taken again on the way back."""


class RecordedWorld(Protocol):
    """What a recorder and a gradient need of a world: a `RigidWorld` is one.

    Attributes
    ----------
    stepper
        What takes its steps.
    robot
        Whose torques go in.
    dt
        Length of a step [s].
    mu
        Friction of the ground in the next step [-].
    model
        Pinocchio's Model of what is simulated.
    """

    stepper: Stepper
    robot: Robot
    dt: float
    mu: float
    model: Any

    def check_differentiable(self) -> None:
        """Raise `ProblemError` where steps have no derivative."""


class RolloutRecorder:
    """Watches the one world of a rollout.

    Parameters
    ----------
    states
        The n + 1 states that the world is to be in; None to keep those that it comes to.
    first
        The run before in which the states were kept.
    unchanged
        Whether the rollout has the same parameters as then.

    Attributes
    ----------
    world
        Of the rollout; None before its first step.
    start
        State that the rollout put it in.
    states
        As given, or as they came.
    steps
        The last `KEPT` steps.
    torques, pushes, mu
        What went into every step: (joints,) [N m], (3,) [N], [-].
    """

    def __init__(
        self, states: list[State] | None = None, first: RolloutRecorder | None = None, unchanged: bool = False
    ) -> None:
        self.world: RecordedWorld | None = None
        self._first, self._unchanged = first, unchanged
        self.given, self.states, self.count = states is not None, states or [], 0
        self.steps: deque[Step] = deque(maxlen=KEPT)
        self.torques, self.pushes, self.mu = list[FloatArray](), list[FloatArray](), list[float]()

    def find_stepper(self, *parts: Any) -> Stepper | None:
        """Return the stepper of the first run where a world is made of the same `parts`, a robot first."""
        self._parts, self._model, first = parts, parts[0].model.copy(), self._first
        if first is None or first.world is None:
            return None
        pairs = zip(parts, first._parts, strict=True)
        same = all(a is b or (isinstance(a, float | StepOptions) and a == b) for a, b in pairs)
        same = same and self._model == first._model  # the robot itself may have been changed
        return first.world.stepper if same or self._unchanged else None

    def place_start(self, state: State) -> State:
        """Return the state that a world is to start in, for the one that it was put in."""
        if self.world is not None:
            raise ProblemError("a rollout is one run of one world, which is put in its place before it")
        self.start = state
        return self.states[0] if self.given else state

    def before(self, world: RecordedWorld, torques: FloatArray, push: FloatArray | None) -> State | None:
        """Keep (joints,) torques and the (3,) push of a step; return the state behind it if it is given."""
        self.world = world if self.world is None else self.world
        if self.world is not world:
            raise ProblemError("a rollout has one world, this one has more")
        self.torques.append(np.array(torques, dtype=np.float64))
        self.pushes.append(np.zeros(3) if push is None else np.array(push, dtype=np.float64))
        self.mu.append(world.mu)
        self.count += 1
        if not self.given:
            return None
        if self.count >= len(self.states):
            raise ProblemError("a rollout takes as many steps whatever its parameters are, this one does not")
        return self.states[self.count]

    def after(self, state: State, step: Step) -> None:
        """Keep a step that was taken from a state."""
        self.states += [state, step.state] if not self.states else [step.state]
        self.steps.append(step)


RECORDER: ContextVar[RolloutRecorder | None] = ContextVar("RECORDER", default=None)
"""Who watches this thread's rollout."""
