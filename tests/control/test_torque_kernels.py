"""What motors give at a speed, against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.latency import EVIDENCE, fitting, note
from surefoot.control.torque_kernels import (
    friction_losses,
    hold_to_motors,
    motor_bounds,
    torque_range,
    usable_range,
)


def driving(
    speed: np.ndarray, effort: np.ndarray, fastest: np.ndarray, knee: float, share: float
) -> np.ndarray:
    use = np.abs(speed) / fastest
    falling = (use < 1.0).astype(float) if knee >= 1.0 else np.clip((1.0 - use) / (1.0 - knee), 0.0, 1.0)
    with np.errstate(invalid="ignore"):
        return np.where(falling == 0.0, 0.0, share * falling * effort)


@pytest.mark.parametrize(("knee", "share"), [(0.45, 0.86), (1.0, 1.0), (0.0, 0.5)])
def test_bounds_and_losses_are_those_of_the_curve(knee: float, share: float) -> None:
    random = np.random.default_rng(5)
    speed = np.concatenate([random.normal(scale=20.0, size=40), [0.0, -0.0, np.inf, -30.0, 30.0]])
    effort, fastest = random.uniform(5.0, 40.0, len(speed)), random.uniform(10.0, 40.0, len(speed))
    effort[::7], fastest[::5] = np.inf, np.inf
    speed = np.where(np.isinf(speed) & np.isinf(fastest), 1.0, speed)
    low, high = motor_bounds(speed, effort, fastest, knee, share)
    along = driving(speed, effort, fastest, knee, share)
    np.testing.assert_allclose(low, -np.where(speed < 0.0, along, effort))
    np.testing.assert_allclose(high, np.where(speed > 0.0, along, effort))
    asked = np.concatenate([random.normal(scale=60.0, size=len(speed) - 3), [np.nan, np.inf, -np.inf]])
    given = asked.copy()
    hold_to_motors(given, speed, effort, fastest, knee, share)
    np.testing.assert_array_equal(given, np.minimum(np.maximum(asked, low), high))
    damping, friction = random.uniform(0.0, 1.0, (2, 40))
    lost = friction_losses(speed[:40], damping, friction, 0.1)
    np.testing.assert_allclose(lost, damping * speed[:40] + friction * np.tanh(speed[:40] / 0.1))


def test_the_usable_range_is_within_motors_and_command() -> None:
    random = np.random.default_rng(6)
    low, high = -random.uniform(0.0, 30.0, 30), random.uniform(0.0, 30.0, 30)
    effort, losses = random.uniform(5.0, 25.0, 30), random.normal(size=30)
    low[3], high[4], effort[3:5] = -np.inf, np.inf, np.inf
    low[7] = high[7] = -5.0  # spins away: the motor can only brake
    middle, half, scale = np.zeros((3, 30))
    usable_range(low, high, losses, effort, 0.02, middle, half, scale)
    bottom, top = np.maximum(low, -effort), np.minimum(high, effort)
    bounded = np.isfinite(bottom) & np.isfinite(top)
    assert (~bounded).sum() == 2
    np.testing.assert_allclose(middle[bounded], (0.5 * (top + bottom) - losses)[bounded])
    np.testing.assert_allclose(half[bounded], np.maximum(0.5 * (top - bottom), 0.02 * effort)[bounded])
    np.testing.assert_allclose(scale[bounded], effort[bounded] / half[bounded])
    assert (middle[~bounded] == 0.0).all()
    assert np.isinf(half[~bounded]).all()
    assert (scale[~bounded] == 1.0).all()


def test_the_range_at_a_speed_is_that_of_its_parts() -> None:
    random = np.random.default_rng(8)
    speed = np.r_[random.normal(scale=20.0, size=10), np.nan, np.inf]
    told = np.where(np.isfinite(speed), speed, 0.0)
    figures = random.uniform(5.0, 30.0, (5, 12))
    knee, share, creep, least = 0.4, 0.8, 0.1, 0.02
    found, plain = np.full((4, 12), np.nan), np.zeros((3, 12))
    torque_range(speed, figures, knee, share, creep, least, found)
    lost = figures[0] * told + figures[1] * np.tanh(told / creep)
    along = driving(told, figures[2], figures[3], knee, share)
    low, high = -np.where(told < 0.0, along, figures[2]), np.where(told > 0.0, along, figures[2])
    usable_range(low, high, lost, figures[4], least, *plain)
    np.testing.assert_allclose(found, [*plain, lost], rtol=1e-12, atol=1e-12)


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
