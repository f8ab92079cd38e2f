"""Motors: what they give at a speed, and a controller behind them."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.motor_limits import MotorLimits, motor_limits

ROBOT = sf.load_robot("go2")


def test_the_box_is_the_urdf() -> None:
    box = motor_limits(ROBOT)
    np.testing.assert_allclose(box.effort, [23.7, 23.7, 45.43] * 4)
    np.testing.assert_allclose(box.speed, [30.1, 30.1, 15.7] * 4)
    full = np.tile([30.0, -30.0, 50.0], 4)
    np.testing.assert_allclose(box.clip(full, 0.99 * box.speed), np.tile([23.7, -23.7, 45.43], 4))
    # beyond its speed a motor brakes, and does not drive
    np.testing.assert_array_equal(box.clip(full, 1.01 * box.speed), np.tile([0.0, -23.7, 0.0], 4))


def test_the_curve_against_its_own_points() -> None:
    """Unitree's figures, scaled to the URDF's: Y1 = 20.2 of Y2 = 23.4 N m to 13.5 rad/s, none at 30 rad/s."""
    curve = motor_limits(ROBOT, "curve")
    speeds = np.array([0.0, 13.5, 21.75, 30.0]) / 30.0
    for share, expected in zip(speeds, np.array([1.0, 1.0, 0.5, 0.0]) * 20.2 / 23.4, strict=True):
        driven = curve.clip(np.full(12, 99.0), share * curve.speed + 1e-12)
        np.testing.assert_allclose(driven, expected * curve.effort, atol=1e-2)
        braked = curve.clip(np.full(12, -99.0), share * curve.speed + 1e-12)
        np.testing.assert_allclose(braked, -curve.effort)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([0.0], [1.0]), "effort"),
        (([1.0], [-1.0]), "speed"),
        (([1.0], [1.0], 1.5), "knee"),
        (([1.0], [1.0], 1.0, -0.1), "driving"),
    ],
)
def test_what_is_no_limit(arguments: tuple[object, ...], said: str) -> None:
    effort, speed, *shares = arguments
    with pytest.raises(ProblemError, match=said):
        MotorLimits(np.array(effort), np.array(speed), *shares)  # type: ignore[arg-type]


def test_an_unknown_model() -> None:
    with pytest.raises(ProblemError, match=r"box.*curve"):
        motor_limits(ROBOT, "magic")
