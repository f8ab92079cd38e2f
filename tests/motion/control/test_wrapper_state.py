"""A wrapper's state: all that lasts in it and in the controller inside, or a refusal."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.motion.control.controller import Command, Controller, RobotState, Wrapper


class Counter(Controller):
    """Counts its steps."""

    state = 0

    def resume(self, state: int) -> None:
        """Go on counting."""
        self.state = state

    def reset(self) -> None:
        """Begin at zero."""
        self.state = 0

    def step(self, state: RobotState) -> Command:
        """Count."""
        self.state += 1
        return Command(np.zeros(1))


class Adding(Wrapper):
    """Counts by its own."""

    MEMORY: tuple[str, ...] = ("total",)
    total = 0

    def step(self, state: RobotState) -> Command:
        """Count by ten."""
        self.total += 10
        return self.controller.step(state)


class Unnamed(Adding):
    """Keeps more than its parent, and does not say what."""


HERE = RobotState(np.zeros(1), np.zeros(1), 0.0)


def test_a_state_goes_on_in_another_wrapper() -> None:
    first, second = Adding(Counter()), Adding(Counter())
    for _ in range(3):
        first.step(HERE)
    second.resume(first.state)
    second.step(HERE)
    assert (second.total, second.controller.state) == (40, 4)  # type: ignore[attr-defined]
    assert (first.total, first.controller.state) == (30, 3)  # type: ignore[attr-defined]


def test_a_class_that_names_nothing_of_its_own_has_no_state() -> None:
    """What its parent names is not all that lasts in it."""
    with pytest.raises(ProblemError, match="Unnamed does not name what lasts in it"):
        _ = Unnamed(Counter()).state
    with pytest.raises(ProblemError, match="not that of a Adding"):
        Adding(Counter()).resume({"own": {}})
