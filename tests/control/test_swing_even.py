"""The swing over even ground: a smooth path, lower peaks than a minimum-jerk step, down at the end."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.swing import DOWN, swing_motion
from surefoot.control.swing_even import LAND, even_swing, ramped_step, smooth_bump

START, TARGET = np.array([0.1, 0.2, 0.02]), np.array([0.6, 0.1, 0.05])
APEX, DURATION, DESCENT = 0.12, 0.18, 0.1


def path(share: float) -> np.ndarray:
    return even_swing(START, TARGET, APEX, share, DURATION, DESCENT)


@pytest.mark.parametrize("ramp", [0.05, 0.15, 0.5])
def test_the_ramped_step_is_the_integral_of_its_acceleration(ramp: float) -> None:
    shares = np.linspace(0.0, 1.0, 20001)
    rise = np.minimum(np.minimum(shares, 1.0 - shares) / ramp, 1.0) * (1.0 - 2.0 * shares)
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (rise[1:] + rise[:-1]))]) * (shares[1] - shares[0])
    place = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) * (shares[1] - shares[0])
    made = np.array([ramped_step(s, ramp) for s in shares[::500]])
    expected = np.column_stack([place, speed, rise])[::500] / place[-1]
    assert made == pytest.approx(expected, abs=1e-6)


def test_velocity_and_acceleration_are_derivatives() -> None:
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


def test_its_peak_speeds_are_below_those_of_the_other_swing() -> None:
    shares = np.linspace(0.0, 1.0, 201)
    ours = np.array([path(s)[1] for s in shares])
    other = np.array([swing_motion(START, TARGET, APEX, s, DURATION, DESCENT)[1] for s in shares])
    assert np.abs(ours[:, 0]).max() < 0.9 * np.abs(other[:, 0]).max()
    assert ours[:, 2].max() < 0.85 * other[:, 2].max()


def test_the_bump_is_highest_where_it_says() -> None:
    values = [smooth_bump(s)[0] for s in np.linspace(0.0, 1.0, 1101)]
    assert max(values) == pytest.approx(1.0)
    assert int(np.argmax(values)) == round(1100 * DOWN * 6.0 / 11.0)
    assert smooth_bump(0.0) == smooth_bump(1.0) == (0.0, 0.0, 0.0)
