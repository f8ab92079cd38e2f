"""Walks as values: what the controller counts on, and what the world is told."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.walks import HARD, Walk, known_robot
from surefoot.control.walking import WalkingController
from surefoot.terrain import FlatTerrain


def test_the_controller_counts_on_what_it_is_told() -> None:
    robot = known_robot("go2")
    assert robot is known_robot("go2")
    walk = Walk(mu=0.2, believed_mu=0.7, believed_mass=1.5, options=HARD)
    made = walk.controller(robot, FlatTerrain())
    assert isinstance(made, WalkingController)
    assert made.settings.mu == 0.7
    assert made.settings.actuators is not None
    assert made.robot.mass == pytest.approx(1.5 * robot.mass)
    assert Walk(mu=0.2).counted_on == 0.2
    assert Walk().motors(robot) is None


def test_a_walk_carries_its_load_on_its_ground() -> None:
    log = Walk(terrain="slope:5", mu=0.5, options={"payload": 2.0}).log(seed=3, duration=0.1)
    assert len(log) == 100
    assert np.all(log["mu"] == 0.5)
    assert log.fact("payload") == 2.0
    assert np.degrees(np.arccos(log["normals"][0, 0, 2])) == pytest.approx(5.0)
