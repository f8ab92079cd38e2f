"""How far a jump got: along the way that was asked, and beside it, without what its feet climbed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from surefoot.motion.planning.tasks.jump import _progress_of

SQUARE = np.array([[0.2, 0.1, 0.0], [0.2, -0.1, 0.0], [-0.2, 0.1, 0.0], [-0.2, -0.1, 0.0]])


def progress(asked: Any, went: Any, climb: float = 0.0) -> tuple[float, float]:
    """Return the progress of feet that were asked to move by one way and went another."""
    robot: Any = SimpleNamespace(foot_positions=lambda q: SQUARE + q)
    motion: Any = SimpleNamespace(positions=np.array([SQUARE, SQUARE + went]))
    return _progress_of(robot, np.zeros(3), np.array(asked, dtype=float), motion, climb)


@pytest.mark.parametrize(
    ("asked", "went", "along", "beside"),
    [
        ([0.5, 0.0, 0.0], [0.3, 0.4, 0.0], 0.3, 0.4),
        ([0.0, -0.2, 0.0], [0.1, -0.6, 0.0], 0.6, 0.1),
        ([0.3, 0.4, 0.0], [0.3, 0.4, 0.0], 0.5, 0.0),
        ([0.0, 0.0, 0.0], [0.06, 0.08, 0.0], 0.0, 0.1),
    ],
)
def test_progress_is_along_the_way_asked_and_the_rest_beside_it(
    asked: list[float], went: list[float], along: float, beside: float
) -> None:
    assert progress(asked, went) == (pytest.approx(along), pytest.approx(beside, abs=1e-12))


def test_what_feet_climb_is_left_out() -> None:
    assert progress([0.5, 0.0, 0.0], [0.5, 0.0, 0.2], climb=0.2) == (pytest.approx(0.5), pytest.approx(0.0))
