"""Walks on an estimated state: what must hold in MuJoCo and the rigid world, and the stop when it is lost."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from surefoot.audit import WalkSummary, summarise_walk
from surefoot.cli.walk_output import estimate_lines, headline
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.log import Ending, Log
from surefoot.robot import load_robot
from surefoot.simulation.run import Push, Scenario, run
from surefoot.simulation.sensing import STOP_TIME
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.terrain import FlatTerrain, SlopeTerrain, Terrain

ORDINARY = SensorModel()


def walk(
    world: str = "mujoco",
    speed: float = 0.5,
    duration: float = 3.0,
    terrain: Terrain | None = None,
    sensors: SensorModel | None = ORDINARY,
    **events: Any,
) -> tuple[Log, WalkSummary]:
    """Return the log of a Go2's trot on an estimated state, and its summary."""
    robot, ground = load_robot("go2"), terrain or FlatTerrain()
    command = VelocityCommand.constant(speed, 0.0, 0.0)
    controller = WalkingController(robot, command, "trot", ground, WalkSettings())
    scenario = Scenario(
        duration, 0.6, start=start_pose(robot, ground), sensors=sensors, **({"seed": 0} | events)
    )
    log = run(make_world(world, robot, ground, 0.6), controller, scenario)
    return log, summarise_walk(log)


@pytest.mark.parametrize(
    ("world", "speed", "terrain", "seed"),
    [
        ("mujoco", 0.5, None, 1),
        ("mujoco", 1.0, None, 2),
        ("mujoco", 0.4, SlopeTerrain(10.0), 3),
        ("rigid", 0.5, None, 4),
    ],
    ids=str,
)
def test_a_trot_on_an_estimate(world: str, speed: float, terrain: Terrain | None, seed: int) -> None:
    log, summary = walk(world, speed, terrain=terrain, seed=seed)
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


def test_a_robot_without_contacts_stops_and_says_so() -> None:
    deaf = replace(ORDINARY, touch=replace(ORDINARY.touch, missed=1.0))
    log, summary = walk(sensors=deaf)
    assert summary.outcome == "lost"
    assert not summary.success
    assert "no foot touched" in summary.error
    assert "lost the estimate of its state and stopped after" in headline(summary)
    stopped = int(np.argmin(log["attained"]))
    assert log["time"][stopped] == pytest.approx(0.3, abs=0.01)
    assert not log["active"][stopped:].any()
    assert not log["forces_commanded"][stopped:].any()
    assert log["time"][-1] == pytest.approx(log["time"][stopped] + STOP_TIME, abs=0.01)
    assert np.abs(log["v"][-1, :3]).max() < 0.2  # it has stood still, but for its legs' spring
    assert log["q"][-1, 2] > 0.25
    assert summary.tilt_max_deg < 5.0


def test_a_robot_that_is_thrown_over_fell_and_says_that_it_was_lost_before() -> None:
    log, summary = walk(pushes=(Push(1.0, (0.0, 0.0, 600.0), 0.3),), duration=3.0)
    assert log.facts["outcome"] == Ending.FELL
    assert summary.error.startswith("the state estimate was lost at 1.")


def test_the_same_seed_gives_the_same_log() -> None:
    first, second, other = (walk(duration=0.6, seed=seed)[0] for seed in (5, 5, 6))
    for name, array in first.arrays.items():
        if not name.endswith("_time"):
            assert array.tobytes() == second[name].tobytes(), name
    assert (first["q_estimated"] != other["q_estimated"]).any()


def test_a_true_state_has_no_estimate() -> None:
    log, summary = walk(duration=0.6, sensors=None)
    assert "q_estimated" not in log
    assert summary.estimate is None
    assert estimate_lines(summary) == []
    assert "estimate" not in summary.as_dict()
