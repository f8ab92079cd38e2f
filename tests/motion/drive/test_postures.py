"""A motion through postures: from rest to rest, through every one of them, and no further."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.motion.drive.postures import PostureMotion

POINTS = np.array([[0.0, 1.0], [0.5, 1.0], [1.0, -1.0], [3.0, 0.0]])
DURATION = 2.0


@pytest.fixture
def motion() -> PostureMotion:
    return PostureMotion(POINTS, DURATION)


def test_it_begins_and_ends_at_rest_and_stays_there(motion: PostureMotion) -> None:
    for time, k in ((-1.0, 0), (0.0, 0), (DURATION, -1), (DURATION + 1.0, -1)):
        np.testing.assert_allclose(motion.at(time), POINTS[k], atol=1e-12)
    for time in (0.0, DURATION - 1e-4):
        assert np.abs(motion.speeds(time, 1e-4)).max() < 1e-3


def test_it_passes_every_posture_in_turn(motion: PostureMotion) -> None:
    """Where it is along them follows 3 s² - 2 s³ of the time."""
    times = np.linspace(0.0, DURATION, 2001)
    share = times / DURATION
    along = (len(POINTS) - 1) * (3.0 * share**2 - 2.0 * share**3)
    expected = np.array([np.interp(along, np.arange(len(POINTS)), joint) for joint in POINTS.T]).T
    np.testing.assert_allclose([motion.at(t) for t in times], expected, atol=1e-12)


def test_speeds_are_what_a_step_takes(motion: PostureMotion) -> None:
    np.testing.assert_allclose(motion.speeds(0.7, 0.1), (motion.at(0.8) - motion.at(0.7)) / 0.1)


def test_two_postures_are_a_way_as_well() -> None:
    motion = PostureMotion(POINTS[:2], 1.0)
    np.testing.assert_allclose(motion.at(0.5), 0.5 * (POINTS[0] + POINTS[1]))
