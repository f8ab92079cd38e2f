"""What motors give at a speed, delays, and torques beyond limits, against plain NumPy."""

from __future__ import annotations

import numpy as np

from surefoot.control.damping import LARGEST, computable
from surefoot.control.latency import EVIDENCE, fitting, note
from surefoot.control.torque_kernels import (
    exceeded,
    torque_range,
)


def driving(
    speed: np.ndarray, effort: np.ndarray, fastest: np.ndarray, knee: float, share: float
) -> np.ndarray:
    use = np.abs(speed) / fastest
    falling = (use < 1.0).astype(float) if knee >= 1.0 else np.clip((1.0 - use) / (1.0 - knee), 0.0, 1.0)
    with np.errstate(invalid="ignore"):
        return np.where(falling == 0.0, 0.0, share * falling * effort)


def test_the_usable_range_is_within_motors_and_command() -> None:
    random = np.random.default_rng(6)
    speed = np.r_[random.normal(scale=20.0, size=28), np.nan, np.inf]
    known = np.where(np.isfinite(speed), speed, 0.0)
    damping, friction, effort, fastest, limits = random.uniform(5.0, 30.0, (5, 30))
    effort[3], limits[3:5] = np.inf, np.inf
    knee, share, creep, least = 0.4, 0.8, 0.1, 0.02
    middle, half, losses = torque_range(
        speed, damping, friction, effort, fastest, knee, share, creep, limits, least
    )
    np.testing.assert_allclose(losses, damping * known + friction * np.tanh(known / creep))
    along = driving(known, effort, fastest, knee, share)
    bottom = np.maximum(np.where(known < 0.0, -along, -effort), -limits)
    top = np.minimum(np.where(known > 0.0, along, effort), limits)
    bounded = np.isfinite(bottom) & np.isfinite(top)
    assert 0 < (~bounded).sum() < 3
    low, high = bottom[bounded], top[bounded]
    np.testing.assert_allclose(middle[bounded], 0.5 * (high + low) - losses[bounded])
    np.testing.assert_allclose(half[bounded], np.maximum(0.5 * (high - low), least * limits[bounded]))
    assert (half[bounded] < 0.3 * limits[bounded]).any()  # spins away: the motor can hardly brake
    assert (middle[~bounded] == 0.0).all()
    assert np.isinf(half[~bounded]).all()


def test_the_delay_that_fits_is_that_of_plain_sums() -> None:
    random, rows, joints, keep = np.random.default_rng(7), 6, 3, 0.9
    asked, misfit, plain = np.zeros((rows, joints)), np.zeros(rows), np.zeros(rows)
    given: list[np.ndarray] = []
    steps = believed = 0
    for count in range(40):
        delay = 2 if count < 20 else 4
        if count:
            told = given[count - 1 - delay] if count > delay else np.zeros(joints)
            steps = fitting(asked, count, told, keep, misfit, steps)
            past = [given[count - 1 - k] if k < count else np.zeros(joints) for k in range(rows)]
            plain = keep * plain + np.array([((row - told) ** 2).sum() for row in past])
            best = int(np.argmin(plain[:count]))
            believed = best if EVIDENCE * plain[best] < plain[believed] else believed
            np.testing.assert_allclose(misfit, plain, atol=1e-12)
            assert steps == believed
        given.append(random.normal(size=joints))
        note(asked, count + 1, given[-1])
    assert steps == 4
    before = misfit.copy()
    assert fitting(asked, 40, np.array([np.nan, 0.0, 0.0]), keep, misfit, 3) == 3
    np.testing.assert_array_equal(misfit, before)
    note(asked, 41, np.array([np.nan, np.inf, 1.0]))
    np.testing.assert_array_equal(asked[40 % rows], [0.0, 0.0, 1.0])


def test_only_states_of_finite_size_are_computable() -> None:
    for bad in (np.nan, np.inf, -np.inf, 1.1 * LARGEST, -1.1 * LARGEST):
        x = np.array([1.0, bad, 0.0])
        assert computable(np.ones(3), x) == computable(x, np.ones(3)) == bool(np.abs(x).max() <= LARGEST)
    assert computable(np.full(3, LARGEST), np.zeros(0))


def test_excess_is_told_apart() -> None:
    middle, half = np.array([0.5, 0.0, 0.0]), np.array([1.0, 2.0, np.inf])
    loose = np.array([True, False, False])
    light, heavy, most, finite = exceeded(np.array([-1.0, 1.0, 7.0]), middle, half, loose)
    assert (light, heavy, most, finite) == (1.5, 0.5, 0.5, True)
    assert not exceeded(np.array([0.0, np.nan, 0.0]), middle, half, loose)[3]
