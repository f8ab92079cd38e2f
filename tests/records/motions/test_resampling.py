"""Resampling and velocities against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation, Slerp

import surefoot as sf
from tests.records.motions.made_motions import g1, waved

TURN, ACCELERATION = np.array([0.3, -0.2, 0.9]), np.array([0.4, 0.1, -9.81])


def thrown(rate: float, count: int) -> sf.Motion:
    """Return a free fall with a steady turn about one axis and joints in sines."""
    times = np.arange(count)[:, None] / rate
    q = np.tile(g1().nominal, (count, 1))
    q[:, :3] = [0.0, 0.0, 2.0] + times * [1.0, 0.5, 3.0] + 0.5 * times**2 * ACCELERATION
    q[:, 3:7] = Rotation.from_rotvec(times * TURN).as_quat()
    q[:, 7:] += 0.3 * np.sin(2.0 * times + np.arange(29))
    return sf.Motion(g1(), q, rate)


def exact(rate: float, count: int) -> tuple[Any, Any]:
    """Return velocities and spatial accelerations in base axes."""
    times = np.arange(count)[:, None] / rate
    world = [1.0, 0.5, 3.0] + times * ACCELERATION
    into = Rotation.from_rotvec(times * TURN).inv()
    linear = into.apply(world)
    change = into.apply(ACCELERATION) - np.cross(TURN, linear)  # of the components in base axes
    angles = 2.0 * times + np.arange(29)
    v = np.hstack([linear, np.tile(TURN, (count, 1)), 0.6 * np.cos(angles)])
    a = np.hstack([change, np.zeros((count, 3)), -1.2 * np.sin(angles)])
    return v, a


@pytest.mark.parametrize(("window", "v_error", "a_error"), [(0.0, 2e-4, 3e-3), (0.1, 4e-3, 3e-2)])
def test_velocities_and_accelerations_are_the_exact_ones(
    window: float, v_error: float, a_error: float
) -> None:
    motion = thrown(100.0, 80)
    v, a = motion.velocities(window)
    true_v, true_a = exact(100.0, 80)
    inner = slice(5, -5)
    assert np.abs(v - true_v)[inner].max() < v_error
    assert np.abs(a - true_a)[inner].max() < a_error
    assert np.isfinite(v).all()
    assert np.isfinite(a).all()
    assert np.abs(v - true_v).max() < 0.1  # at the ends a parabola goes on


def test_errors_of_central_differences_fall_by_four_where_the_rate_doubles() -> None:
    errors = []
    for rate, count in ((50.0, 41), (100.0, 81)):
        v, a = thrown(rate, count).velocities()
        true_v, true_a = exact(rate, count)
        inner = slice(2, -2)
        errors.append((np.abs(v - true_v)[inner].max(), np.abs(a - true_a)[inner].max()))
    assert errors[0][0] / errors[1][0] == pytest.approx(4.0, rel=0.15)
    assert errors[0][1] / errors[1][1] == pytest.approx(4.0, rel=0.15)


def test_a_window_averages_noise() -> None:
    motion = thrown(100.0, 200)
    noise = np.random.default_rng(1).normal(0.0, 1e-3, (200, 29))
    motion.q[:, 7:] += noise
    true_a = exact(100.0, 200)[1][:, 6:]
    rough, smooth = (np.std((motion.velocities(w)[1][:, 6:] - true_a)[20:-20]) for w in (0.0, 0.2))
    assert smooth < 0.02 * rough


def test_too_few_frames_for_a_window_are_refused() -> None:
    with pytest.raises(sf.SurefootError, match=r"has 5 frames, a window of 0\.2 s at 100 Hz needs 21"):
        thrown(100.0, 5).velocities(0.2)
    with pytest.raises(sf.SurefootError, match="window"):
        thrown(100.0, 5).velocities(-1.0)


@pytest.mark.parametrize("rate", [30.0, 50.0, 120.0, 7.3])
def test_resampling_is_linear_and_slerp(rate: float) -> None:
    motion = sf.Motion(g1(), waved(g1(), 2), 50.0, torques=np.arange(150.0)[:, None] * np.ones(29))
    new = motion.resample(rate)
    times, old = np.arange(len(new)) / rate, np.arange(150) / 50.0
    assert new.rate == rate
    assert motion.duration - 1.0 / rate < new.duration <= motion.duration + 1e-9
    for column in (*range(3), *range(7, 36)):
        assert np.allclose(new.q[:, column], np.interp(times, old, motion.q[:, column]), atol=1e-12)
    turns = Slerp(old, Rotation.from_quat(motion.q[:, 3:7]))(np.minimum(times, old[-1]))
    assert (turns.inv() * Rotation.from_quat(new.q[:, 3:7])).magnitude().max() < 1e-7
    assert np.allclose(new.torques[:, 0], 50.0 * times)


def test_resampling_at_the_same_rate_and_to_integer_multiples_keeps_frames() -> None:
    motion = sf.Motion(g1(), waved(g1(), 2), 30.0)
    assert np.allclose(motion.resample(30.0).q, motion.q, atol=1e-15)
    finer = motion.resample(90.0)
    assert np.allclose(finer.q[::3], motion.q, atol=1e-12)
    assert len(finer) == 3 * (len(motion) - 1) + 1


def test_quaternions_of_either_sign_take_the_short_way() -> None:
    q = np.tile(g1().nominal, (2, 1))
    q[1, 3:7] *= -1.0
    assert np.allclose(np.abs(sf.Motion(g1(), q, 10.0).resample(100.0).q[:, 6]), 1.0)
    v, a = sf.Motion(g1(), np.vstack([q, q]), 10.0).velocities()
    assert np.abs(v).max() < 1e-9
    assert np.abs(a).max() < 1e-7


def test_a_motion_says_what_it_is() -> None:
    motion = sf.Motion(g1(), waved(g1(), 2), 50.0, name="wave", notes=("doubt: rate: x", "y"))
    assert repr(motion) == "Motion('wave', robot='g1', frames=150, rate=50)"
    assert motion.duration == pytest.approx(2.98)
    assert motion.times[-1] == motion.duration
    assert motion.doubts == ("rate: x",)
    with pytest.raises(sf.SurefootError, match="rate must be"):
        motion.resample(0.0)
    assert pinocchio.isNormalized(g1().model, motion.q[0], 1e-9)
