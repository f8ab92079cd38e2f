"""Postures: where targets are in time, and torques that respect effort and speed."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.motion.planning.stand_up.posture_sequence import Postures

LAW = Postures(
    np.array([1.0, 3.0]),
    np.array([[1.0, 2.0], [3.0, -2.0]]),
    50.0,
    1.0,
    np.full(2, 10.0),
    np.full(2, 5.0),
    np.full(2, -3.0),
    np.full(2, 4.0),
)


@pytest.mark.parametrize(
    ("time", "expected"),
    [(0.0, [0.0, 0.0]), (0.5, [0.5, 1.0]), (1.0, [1.0, 2.0]), (2.0, [2.0, 0.0]), (9.0, [3.0, -2.0])],
)
def test_targets(time: float, expected: list[float]) -> None:
    np.testing.assert_allclose(LAW.at(time, np.zeros(2)), expected)


def test_torques() -> None:
    np.testing.assert_allclose(LAW.torques(np.array([0.1, -9.0]), np.zeros(2), np.zeros(2)), [5.0, -10.0])
    # at its speed limit a joint is braked, and not driven
    at_limit = np.array([5.0, -5.0])
    np.testing.assert_allclose(LAW.torques(np.array([9.0, -9.0]), np.zeros(2), at_limit), [0.0, 0.0])
    np.testing.assert_allclose(LAW.torques(np.array([-9.0, 9.0]), np.zeros(2), at_limit), [-10.0, 10.0])


def test_the_ends_of_the_range_push_back() -> None:
    """Harder than the target pulls: a target at the end is not reached."""
    at_end = np.array([-3.0, 4.0])
    torques = LAW.torques(at_end, at_end, np.zeros(2))
    assert torques[0] > 5.0
    assert torques[1] < -5.0
    inside = at_end + np.array([0.1, -0.1])
    np.testing.assert_allclose(LAW.torques(inside, inside, np.zeros(2)), 0.0)


def test_what_are_no_postures() -> None:
    with pytest.raises(ProblemError, match="increase"):
        Postures(np.array([1.0, 1.0]), np.zeros((2, 2)), 1.0, 1.0, *[np.ones(2)] * 4)
    with pytest.raises(ProblemError, match="a time each"):
        Postures(np.array([1.0]), np.zeros((2, 2)), 1.0, 1.0, *[np.ones(2)] * 4)
