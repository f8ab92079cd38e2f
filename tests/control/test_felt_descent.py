"""Going down steps that feet have felt: late feet, settled ones, and a blind Go2 on stairs."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.felt_descent import SETTLED, SLOW_SEARCH, FeltDescent
from surefoot.control.felt_ground import FeltGround
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.control.walking_feet import SEARCH_SPEED
from surefoot.estimation.felt_flight import FeltFlight
from surefoot.robot import load_robot
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.run import run
from surefoot.simulation.scenario import Scenario
from surefoot.simulation.walk_terrain import start_pose
from surefoot.spatial import rotation_from_quaternion
from surefoot.terrain import StairsTerrain

HEIGHT = 0.3
ALL = np.ones(4, dtype=bool)
LATE = np.array([True, False, False, False])


def descent() -> FeltDescent:
    """Return steps down of 12 cm by 30 cm."""
    return FeltDescent(
        FeltFlight.downwards(np.array([1.0, 0.0]), np.array([0.0, 0.3]), 0.0, 0.12, 0.45), HEIGHT
    )


def test_a_late_foot_falls_fast_and_comes_down_gently() -> None:
    going, speeds = descent(), []
    for z in (-0.12, -0.13, -0.16, -0.2, -0.22, -0.24):
        going.observe(0.0, ~LATE, np.array([[0.28, 0.1, z], *np.zeros((3, 3))]), -0.12 - z)
        speeds.append((going.search_speed, going.lead > 0.0))
    slow, fast = SLOW_SEARCH, SEARCH_SPEED
    assert speeds == [(slow, False), (slow, False), (fast, True), (fast, True), (slow, True), (slow, True)]


def test_a_stand_tells_once_it_has_lasted() -> None:
    going = descent()
    soles = np.array([[0.15, 0.1, -0.115], *np.zeros((3, 3))])
    going.observe(0.0, ~LATE, soles, 0.0)
    going.observe(0.1, ALL, soles, 0.0)
    before = going.flight.rise
    going.observe(0.1 + 0.5 * SETTLED, ALL, soles, 0.0)
    assert going.flight.rise == before
    going.observe(0.1 + 1.1 * SETTLED, ALL, soles, 0.0)
    assert going.flight.rise > before


@pytest.mark.parametrize("tread", [0.3, 0.34])
def test_a_blind_go2_goes_down_stairs(tread: float) -> None:
    go2, stairs, ground = load_robot("go2"), StairsTerrain(-0.12, tread), FeltGround()
    walker = WalkingController(go2, VelocityCommand.constant(0.4), "trot", ground)
    scenario = Scenario(9.0, 0.6, start=start_pose(go2, stairs))
    log = run(MujocoWorld(go2, stairs, 0.6), walker, scenario, [])
    assert log.fact("outcome") == "done"
    assert rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2].min() > np.cos(np.radians(32.0))
    assert ground.flight is not None
    assert ground.flight.tread == pytest.approx(tread, abs=0.012)
    assert ground.flight.edge(0) == pytest.approx(0.0, abs=0.02)
    assert log["q"][-1, 2] < -0.2  # it has gone on down for three treads and more
    assert log["q"][-1, 0] > 1.0
    (note,) = log.fact("notes")
    assert "feet felt for the edges of steps" in note
