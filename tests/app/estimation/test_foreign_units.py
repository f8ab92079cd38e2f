"""Units of another maker's log: clocks by the time between rows, turn rates by feet that stand."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.app.estimation.foreign_units import in_seconds, turn_by_feet
from surefoot.app.estimation.standing_feet import Misfit
from surefoot.base.arrays import FloatArray
from surefoot.records import Log
from tests.app.estimation.test_foreign_log import SLIDER, turned

BOTH, ORDER, FEET = np.ones((60, 2), dtype=bool), np.arange(6), np.arange(2)


@pytest.mark.parametrize("step", [0.0005, 0.002, 0.02])
@pytest.mark.parametrize(
    ("unit", "size"), [("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9)]
)
def test_a_clock_is_the_one_by_which_a_log_has_a_robots_rate(step: float, unit: str, size: float) -> None:
    first, told = 1.7e9, list[str]()
    log = Log({"time": (first + step * np.arange(50)) / size}, {"robot": "go2"})
    found = in_seconds(log, told)
    np.testing.assert_allclose(found["time"], step * np.arange(50), atol=1e-6)
    assert told == [f"time is in {unit}: rows are {np.median(np.diff(log['time'])):g} apart"]
    assert found.facts == log.facts


def test_seconds_stay_seconds() -> None:
    told = list[str]()
    for step in (5e-5, 1e-3, 0.25, 1e12):
        log = Log({"time": step * np.arange(50)})
        assert in_seconds(log, told) is log
    short = Log({"time": np.zeros(1)})
    assert in_seconds(short, told) is short
    assert not told


def gyro_of(rate: float) -> FloatArray:
    return np.tile([0.0, 0.0, rate], (60, 1))


@pytest.mark.parametrize("order", [ORDER, np.array([3, 4, 5, 0, 1, 2]), np.array([0, 3, 1, 4, 2, 5])])
def test_degrees_are_told_by_standing_feet_whatever_the_order(order: np.ndarray) -> None:
    time, told = 0.01 * np.arange(60), list[str]()
    joints = np.empty((60, 6))
    joints[:, order] = turned(rate=0.5)
    for factor, degrees in ((180.0 / np.pi, True), (1.0, False)):
        gyro = factor * gyro_of(0.5)
        assert turn_by_feet(Misfit(SLIDER, time, gyro, joints, BOTH), ORDER, FEET, gyro, told) == degrees
        np.testing.assert_allclose(gyro, gyro_of(0.5), atol=1e-12)
    assert len(told) == 1
    assert told[0].startswith("turn rates are in degrees per second: in rad/s standing feet would part at ")


def test_a_robot_that_stands_or_is_carried_and_a_moment_of_one_that_turns_tell_no_unit() -> None:
    time, told, still = 0.01 * np.arange(60), list[str](), np.zeros((60, 6))
    noise = 0.01 * np.random.default_rng(0).normal(size=(60, 3))
    few = np.where(np.arange(60)[:, None] % 6 == 0, gyro_of(30.0), 0.0)
    carried = gyro_of(2.0)
    for gyro, joints in ((noise, still), (few, turned()), (carried, still)):
        given = gyro.copy()
        assert not turn_by_feet(Misfit(SLIDER, time, gyro, joints, BOTH), ORDER, FEET, gyro, told)
        np.testing.assert_array_equal(gyro, given)
    assert not told
