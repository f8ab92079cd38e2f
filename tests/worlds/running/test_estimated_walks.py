"""Walks on an estimated state: what must hold in MuJoCo and the rigid world, and the stop when it is lost."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.run_output import estimate_lines, walk_headline
from surefoot.mechanics.terrain import SlopeTerrain, Terrain
from surefoot.records.audit import WalkSummary
from surefoot.records.log import Ending, Log
from surefoot.worlds.running.run import Push
from surefoot.worlds.running.sensing import STOP_TIME
from surefoot.worlds.running.sensors import SensorModel
from tests.worlds.running.walks import walk

ORDINARY = SensorModel()


def estimated(*words: Any, sensors: SensorModel = ORDINARY, **options: Any) -> tuple[Log, WalkSummary]:
    """Return log and summary of a walk on an estimated state."""
    return walk(*words, sensors=sensors, **options)


@pytest.mark.parametrize(
    ("world", "speed", "terrain", "seed"),
    [
        ("mujoco", 1.0, None, 2),
        ("mujoco", 0.4, SlopeTerrain(10.0), 3),
        ("rigid", 0.5, None, 4),
    ],
    ids=str,
)
@pytest.mark.long
def test_a_trot_on_an_estimate(world: str, speed: float, terrain: Terrain | None, seed: int) -> None:
    log, summary = estimated(speed, world={"name": world}, terrain=terrain, seed=seed)
    assert summary.success
    assert summary.laws_broken == []
    errors = summary.estimate
    assert errors is not None
    assert errors.velocity_rms < 0.02  # wanted: 0.05
    assert errors.drift_share is not None
    assert errors.drift_share < 0.02
    assert summary.velocity.forward.measured == pytest.approx(speed, rel=0.1)
    assert np.abs(log["q_estimated"] - log["q"]).max() > 1e-4  # it was an estimate indeed
    assert (log["contact_estimated"].mean(axis=0) > 0.4).all()
    assert "velocity off by" in estimate_lines(summary)[0]


@pytest.mark.long
def test_legs_that_feel_nothing_walk_by_heights_speeds_and_the_plan() -> None:
    numb = replace(ORDINARY, touch=replace(ORDINARY.touch, missed=1.0))
    _, summary = estimated(sensors=numb)
    assert summary.success
    assert summary.laws_broken == []


@pytest.mark.long
def test_false_touches_do_not_stop_a_leg_in_its_swing() -> None:
    haunted = replace(ORDINARY, touch=replace(ORDINARY.touch, false=1.0))
    log, summary = estimated(sensors=haunted, seed=1)
    assert summary.success
    high = (log["gaps"] > 0.02) & ~log["planned"]
    assert high.mean() > 0.15
    assert (log["contact_estimated"] & high).sum() / high.sum() < 1e-3


@pytest.mark.long
def test_a_slope_is_felt_without_a_map() -> None:
    """Feet that roll on what is taken for level drift by 3 % of the way."""
    _, summary = estimated(0.4, terrain=SlopeTerrain(15.0), sensors=replace(ORDINARY, heights=False))
    assert summary.success
    assert summary.estimate is not None
    assert summary.estimate.drift_share is not None
    assert summary.estimate.drift_share < 0.01


@pytest.mark.long
def test_a_heavy_robot_whose_feet_bounce_stays_level() -> None:
    """HyQ's feet rebound at 1.2 m/s: a force alone finds them 50 ms late, and it leans by 30 degrees."""
    _, summary = estimated(1.21, 5.0, "hyq")
    assert summary.success
    assert summary.tilt_max_deg < 2.0


@pytest.mark.long
def test_latency_of_five_milliseconds_is_made_up_for() -> None:
    late = replace(
        ORDINARY, imu=replace(ORDINARY.imu, latency=0.005), encoders=replace(ORDINARY.encoders, latency=0.005)
    )
    _, summary = estimated(sensors=late)
    assert summary.success
    assert summary.laws_broken == []
    assert summary.estimate is not None
    assert summary.estimate.velocity_rms < 0.005  # 0.009 if the state were taken for that of now


def test_a_robot_with_a_broken_accelerometer_stops_and_says_so() -> None:
    broken = replace(ORDINARY, imu=replace(ORDINARY.imu, accelerometer_range=6.0))
    log, summary = estimated(sensors=broken)
    assert summary.outcome == "lost"
    assert not summary.success
    assert "diverged" in summary.error
    assert "lost the estimate of its state and stopped after" in walk_headline(summary)
    stopped = int(np.argmin(log["attained"]))
    assert log["time"][stopped] < 0.3
    assert not log["active"][stopped:].any()
    assert not log["forces_commanded"][stopped:].any()
    assert log["time"][-1] == pytest.approx(log["time"][stopped] + STOP_TIME, abs=0.01)
    assert np.abs(log["v"][-1, :3]).max() < 0.2  # it has stood still, but for its legs' spring
    assert log["q"][-1, 2] > 0.25
    assert summary.tilt_max_deg < 5.0


def test_a_robot_that_is_thrown_over_fell_and_says_that_it_was_lost_before() -> None:
    log, summary = estimated(pushes=(Push(1.0, (0.0, 0.0, 1000.0), 0.1),), duration=3.0)
    assert log.facts["outcome"] == Ending.FELL
    assert summary.error.startswith("the state estimate was lost at 1.")
