"""What a motor gives at a speed, within a command, against plain NumPy."""

from __future__ import annotations

import numpy as np

from surefoot.robot.actuators import torque_range


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
