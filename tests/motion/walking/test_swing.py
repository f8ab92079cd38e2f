"""Swing paths: they start and end where they should, are smooth, and clear the ground."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.mechanics.terrain import FlatTerrain, StairsTerrain
from surefoot.motion.walking.swing import (
    DOWN,
    EVEN,
    LAND,
    RISE,
    apex_height,
    clear_lift,
    even_swing,
    ramped_step,
    swing_motion,
    swing_places,
)

PLACES = st.tuples(*[st.floats(-0.3, 0.3)] * 3).map(np.array)


@given(PLACES, PLACES, st.floats(0.02, 0.2), st.floats(0.1, 0.5))
@settings(max_examples=60, deadline=None)
def test_a_swing_starts_and_ends_at_rest_and_peaks_at_its_apex(
    start: np.ndarray, target: np.ndarray, rise: float, duration: float
) -> None:
    apex = max(start[2], target[2]) + rise
    first, top, last = (swing_motion(start, target, apex, s, duration, 0.0) for s in (0.0, RISE, 1.0))
    assert first[0] == pytest.approx(start, abs=1e-12)
    assert last[0] == pytest.approx(target, abs=1e-12)
    assert np.abs(first[1]).max() < 1e-9
    assert np.abs(last[1]).max() < 1e-9
    assert top[0, 2] == pytest.approx(apex)


@given(PLACES, PLACES, st.floats(0.1, 0.5), st.floats(0.0, 0.3), st.floats(0.02, 0.98))
@settings(max_examples=60, deadline=None)
def test_velocity_and_acceleration_are_derivatives(
    start: np.ndarray, target: np.ndarray, duration: float, descent: float, share: float
) -> None:
    corners = np.array([0.08, RISE, 0.75, 0.92, DOWN])
    step = 1e-5
    if np.abs(corners - share).min() < 3.0 * step:
        share += 1e-3
    apex = max(start[2], target[2]) + 0.1

    def at(s: float) -> np.ndarray:
        return swing_motion(start, target, apex, s, duration, descent)

    rate = (at(share + step) - at(share - step)) / (2.0 * step * duration)
    scale = 1.0 / duration**3
    assert at(share)[1] == pytest.approx(rate[0], abs=1e-6 * scale)
    assert at(share)[2] == pytest.approx(rate[1], abs=1e-5 * scale)


def test_a_late_foot_keeps_going_down() -> None:
    args = np.zeros(3), np.array([0.1, 0.0, 0.0]), 0.08
    late, later = (swing_motion(*args, s, 0.2, 0.3) for s in (1.2, 1.7))
    assert later[0, 2] - late[0, 2] == pytest.approx(-0.3 * 0.2 * 0.5)
    assert late[1] == pytest.approx([0.0, 0.0, -0.3])
    assert late[0, :2] == pytest.approx([0.1, 0.0])


def test_places_along_a_swing_are_those_of_its_motion() -> None:
    start, target, shares = np.zeros(3), np.array([0.1, 0.02, 0.12]), np.linspace(0.0, 1.0, 9)
    places = swing_places(start, target, 0.2, shares, 0.16)
    wanted = [swing_motion(start, target, 0.2, s, 0.3, 0.0, 0.16)[0] for s in shares]
    np.testing.assert_allclose(places, wanted, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("down", [0.8, 0.85, 0.95])
def test_a_foot_only_sinks_after_a_share(down: float) -> None:
    """There it is at its target, above which it goes down straight, with four fifths of the descent."""
    start, target = np.zeros(3), np.array([0.1, 0.02, 0.12])
    at = swing_motion(start, target, 0.2, down, 0.3, 0.2, 0.08, down)
    assert at[0] == pytest.approx(target, abs=1e-12)
    assert at[1] == pytest.approx([0.0, 0.0, -0.16], abs=1e-9)
    later = swing_motion(start, target, 0.2, 1.0, 0.3, 0.2, 0.08, down)
    assert later[0, :2] == pytest.approx(target[:2])
    assert 0.16 * (1.0 - down) * 0.3 <= target[2] - later[0, 2] <= 0.2 * (1.0 - down) * 0.3


def test_the_apex_clears_ends_and_ground() -> None:
    start, target = np.zeros(3), np.array([0.2, 0.0, 0.1])
    assert apex_height(start, target, np.array([0.0, 0.05]), 0.06) == pytest.approx(0.16)
    assert apex_height(start, target, np.array([0.0, 0.25]), 0.06) == pytest.approx(0.31)
    assert apex_height(start, target, np.zeros(0), 0.06) == pytest.approx(0.16)


def test_a_foot_before_a_riser_lifts_first() -> None:
    stairs, radius = StairsTerrain(0.1, 0.3), 0.02
    start, target = np.array([-0.035, 0.0, radius]), np.array([0.12, 0.0, 0.1 + radius])
    apex = 0.1 + radius + 0.06
    lift = clear_lift(start, target, apex, stairs, radius, 0.01)
    assert lift > clear_lift(start, np.array([0.12, 0.0, radius]), apex, FlatTerrain(), radius, 0.01)
    for share in np.linspace(0.0, 1.0, 101):
        place = swing_motion(start, target, apex, share, 0.2, 0.0, lift)[0]
        assert place[2] >= stairs.height(place[:2] + np.array([radius, 0.0])) + radius - 1e-3


@given(PLACES, PLACES, st.floats(0.02, 0.2), st.floats(0.15, 0.5), st.floats(0.05, 0.3))
@settings(max_examples=60, deadline=None)
def test_the_foot_meets_the_ground_with_its_descent(
    start: np.ndarray, target: np.ndarray, rise: float, duration: float, descent: float
) -> None:
    """Where it passes the target's height it moves straight down with four fifths of the speed."""
    apex = max(start[2], target[2]) + rise
    for swing in (swing_motion, even_swing):
        paths = np.array(
            [swing(start, target, apex, s, duration, descent) for s in np.linspace(0.9, 1.0, 101)]
        )
        first = int(np.flatnonzero(paths[:, 0, 2] <= target[2] + 1e-9)[0])
        assert first == 50
        assert paths[first, 1] == pytest.approx([0.0, 0.0, -0.8 * descent], abs=1e-9)


START, TARGET = np.array([0.1, 0.2, 0.02]), np.array([0.6, 0.1, 0.05])
APEX, DURATION, DESCENT = 0.12, 0.18, 0.1


def path(share: float) -> np.ndarray:
    return swing_motion(START, TARGET, APEX, share, DURATION, DESCENT, EVEN)


@pytest.mark.parametrize("ramp", [0.05, 0.15, 0.5])
def test_the_ramped_step_is_the_integral_of_its_acceleration(ramp: float) -> None:
    shares = np.linspace(0.0, 1.0, 20001)
    rise = np.minimum(np.minimum(shares, 1.0 - shares) / ramp, 1.0) * (1.0 - 2.0 * shares)
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (rise[1:] + rise[:-1]))]) * (shares[1] - shares[0])
    place = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * (shares[1] - shares[0])
    made = np.array([ramped_step(s, ramp) for s in shares[::500]])
    expected = np.column_stack([place, speed, rise])[::500] / place[-1]
    assert made == pytest.approx(expected, abs=1e-6)


def test_those_over_even_ground_are_derivatives() -> None:
    tiny = 1e-6
    for share in np.linspace(0.02, 0.98, 25):
        before, here, after = (path(share + d) for d in (-tiny, 0.0, tiny))
        assert (after[0] - before[0]) / (2 * tiny * DURATION) == pytest.approx(here[1], abs=1e-5)
        assert (after[1] - before[1]) / (2 * tiny * DURATION) == pytest.approx(here[2], abs=2e-3)


def test_it_begins_at_rest_clears_the_middle_and_ends_straight_down() -> None:
    assert path(0.0) == pytest.approx(np.stack([START, np.zeros(3), np.zeros(3)]))
    highest = max(path(s)[0, 2] for s in np.linspace(0.0, 1.0, 201))
    assert APEX <= highest < APEX + 0.01
    for share in (LAND + 1e-9, 0.97, 1.0, 1.2):
        place, speed, _ = path(share)
        assert place[:2] == pytest.approx(TARGET[:2])
        assert speed[:2] == pytest.approx(0.0, abs=1e-9)
        assert speed[2] < 0.0
    assert path(1.2)[1, 2] == -DESCENT
    assert path(1.2)[0, 2] - path(1.1)[0, 2] == pytest.approx(-DESCENT * 0.1 * DURATION)
