"""Whole walks in MuJoCo: velocity, cones, terrain, pushes, ice, other robots, faults, determinism."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.mechanics.terrain import SlopeTerrain, StairsTerrain, Terrain, rough_ground
from surefoot.records.audit.motion import commanded_excess
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.run import Ice, Push
from tests.worlds.running.walks import walk


@pytest.mark.sampled(1)
@pytest.mark.parametrize("velocity", [(1.0, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.8)])
def test_a_trot_follows_its_command_inside_the_cones(velocity: tuple[float, float, float]) -> None:
    log, summary = walk(velocity, 5.0)
    assert summary.success
    assert summary.laws_broken == []
    for axis, wanted in zip(("forward", "left", "turn"), velocity, strict=True):
        assert getattr(summary.velocity, axis).commanded == pytest.approx(wanted, abs=1e-6)
        assert getattr(summary.velocity, axis).measured == pytest.approx(wanted, rel=0.1, abs=0.03)
    assert commanded_excess(log).max() == 0.0
    assert log["attained"].all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("terrain", "speed", "duration"),
    [
        (SlopeTerrain(15.0), 0.4, 4.0),
        (SlopeTerrain(-15.0), 0.4, 4.0),
        (rough_ground(1, 0.04), 0.4, 4.0),
        (StairsTerrain(0.08, 0.3), 0.3, 7.0),
        (StairsTerrain(-0.08, 0.3), 0.3, 7.0),
    ],
    ids=repr,
)
def test_a_trot_masters_terrain(terrain: Terrain, speed: float, duration: float) -> None:
    log, summary = walk(speed, duration, terrain=terrain)
    assert summary.success
    assert summary.laws_broken == []
    assert summary.velocity.forward.measured == pytest.approx(speed, rel=0.1)
    assert commanded_excess(log).max() == 0.0
    climbed = terrain.height(log["q"][-1, :2]) - terrain.height(log["q"][0, :2])
    assert summary.climb == pytest.approx(float(climbed), abs=0.12)


@pytest.mark.parametrize("robot", ["hyq", "anymal_kinova"])
@pytest.mark.long
def test_a_base_beside_the_centre_of_mass_goes_at_the_command(robot: str) -> None:
    """The centre of mass is 4 and 8 cm ahead of the base: it swerves where the body turns; arms stay put."""
    log, summary = walk((0.1, 0.1, 0.4), 4.0, robot=robot)
    velocity, arm = summary.velocity, log["q"][:, 19:]
    assert summary.success
    assert [velocity.forward.commanded, velocity.left.commanded] == pytest.approx([0.1, 0.1], abs=1e-6)
    assert [velocity.forward.measured, velocity.left.measured] == pytest.approx([0.1, 0.1], abs=6e-3)
    assert np.abs(arm - arm[0]).max(initial=0.0) < 0.02


@pytest.mark.parametrize("side", [1.0, pytest.param(-1.0, marks=pytest.mark.long)])
def test_a_trot_survives_pushes(side: float) -> None:
    push = Push(1.5, (0.0, 100.0 * side, 0.0), 0.1)
    log, summary = walk(pushes=(push,), duration=3.5)
    left = summary.velocity.left.measured
    assert log.facts["outcome"] == "done"
    peak = log["v"][1600:1700, 1]
    assert side * peak[np.abs(peak).argmax()] > 0.2  # 10 N s on 16 kg, and feet that push back
    assert abs(left) < 0.15
    assert commanded_excess(log).max() == 0.0


@pytest.mark.long
def test_a_trot_crosses_ice() -> None:
    log, summary = walk(ice=(Ice(1.5, 0.2), Ice(3.0, 0.6)), duration=4.0)
    assert summary.success
    assert log["mu"].min() == 0.2


@pytest.mark.long
@pytest.mark.parametrize(
    ("gait", "speed"), [("walk", 0.3), ("pace", 0.4), ("bound", 0.4), ("flying_trot", 0.6)]
)
def test_every_gait_walks(gait: str, speed: float) -> None:
    _, summary = walk(speed, 3.5, gait=gait)
    assert summary.success
    assert summary.velocity.forward.measured == pytest.approx(speed, rel=0.1)
    assert summary.commanded_cone_excess == 0.0


def test_standing_is_a_gait() -> None:
    log, _ = walk(0.0, 2.0, gait="stand")
    assert log["active"].all()
    assert np.abs(log["q"][-1, :3] - log["q"][0, :3]).max() < 0.02


@pytest.mark.long
def test_a_walk_with_faults_and_payload_goes_on() -> None:
    faults = Faults(noise=0.5, delay=0.003, weak_joint="FL_calf_joint", torque_loss=0.2)
    log, _ = walk(duration=3.5, faults=faults, world={"payload": 3.0}, seed=2)
    assert log.facts["outcome"] == "done"
