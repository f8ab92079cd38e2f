"""The use of motors in a log, and what touched: against numbers put in by hand."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.records.audit.summary.motor_summary import limits_broken, motor_use
from surefoot.records.log import Log

NAMES = ["hip", "knee"]


def log(speeds: list[list[float]], torques: list[list[float]], **facts: object) -> Log:
    """Two joints of 10 N m and 20 rad/s; 0.8 of the torque along the motion, up to half the speed."""
    v = np.concatenate([np.zeros((len(speeds), 6)), np.array(speeds)], axis=1)
    told = {
        "joints": NAMES, "effort_limits": [10.0, 10.0], "speed_limits": [20.0, 20.0], "actuators": "real",
        "motor_knee": 0.5, "motor_driving": 0.8,
    }  # fmt: skip
    arrays = {"time": 1e-3 * np.arange(len(v)), "v": v, "torques": np.array(torques)}
    return Log(arrays, told | facts)


def test_speeds_are_held_against_their_limits() -> None:
    run = log([[5.0, 0.0], [0.0, -22.0], [0.0, 20.0], [1.0, 1.0]], [[0.0, 0.0]] * 4)
    use = motor_use(run)
    assert use is not None
    assert (use.speed_use_joint, use.over_speed_share) == ("knee", 0.25)
    assert use.speed_use_max == pytest.approx(1.1)
    assert limits_broken(run, use) == ["knee at 110 % of its largest speed, in 25 % of the steps beyond it"]
    ideal = log([[25.0, 0.0]], [[0.0, 0.0]], actuators="ideal")
    assert limits_broken(ideal, motor_use(ideal)) == []


@pytest.mark.parametrize(
    ("speed", "torque", "beyond"),
    [
        (5.0, 8.0, 0.0),
        (5.0, 9.0, 0.1),
        (-15.0, -5.0, 0.1),
        (15.0, -10.0, 0.0),
        (21.0, 1.0, 0.1),
        (0.0, 10.0, 0.0),
    ],
)
def test_torques_are_held_against_the_curve(speed: float, torque: float, beyond: float) -> None:
    use = motor_use(log([[speed, 0.0], [0.0, 0.0]], [[torque, 0.0], [0.0, 0.0]]))
    assert use is not None
    assert use.beyond_curve_max == pytest.approx(beyond, abs=1e-12)
    assert use.beyond_curve_share == (0.5 if beyond else 0.0)


def test_what_was_asked_for_counts_where_it_is_known() -> None:
    run = log([[5.0, 0.0]], [[8.0, 0.0]])
    asked = Log({**run.arrays, "torques_commanded": np.array([[12.0, 0.0]])}, run.facts)
    use = motor_use(asked)
    assert use is not None
    assert use.beyond_curve_max == pytest.approx(0.4)


def test_logs_that_tell_nothing_are_not_judged() -> None:
    run = log([[5.0, 0.0]], [[8.0, 0.0]])
    del run.facts["speed_limits"]
    assert motor_use(run) is None
    assert limits_broken(run, None) is None
    touched = log([[0.0, 0.0]], [[0.0, 0.0]], link_touches=["calf and ground from 0.100 s on, for 3 ms"])
    assert limits_broken(touched, motor_use(touched)) == [
        "touched: calf and ground from 0.100 s on, for 3 ms"
    ]
