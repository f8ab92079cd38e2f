"""Walks with real actuators and whole robots: what holds, and what is judged when it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.audit import WalkSummary, summarise_walk
from surefoot.audit.dynamics import unexplained
from surefoot.cli.walk_output import headline
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.log import Log
from surefoot.robot.actuators import real_actuators
from surefoot.simulation.run import Push, Scenario, run
from surefoot.simulation.scenario import Fall
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.terrain import FlatTerrain

GO2 = sf.load_robot("go2")
REAL = real_actuators(GO2)


def walk(speed: float, duration: float, world: str = "mujoco", known: bool = True) -> tuple[Log, WalkSummary]:
    """Return log and summary of a Go2's trot on an estimated state, with motors and all its links."""
    settings = WalkSettings(actuators=REAL if known else None)
    command = VelocityCommand.constant(speed, 0.0, 0.0)
    controller = WalkingController(GO2, command, "trot", FlatTerrain(), settings)
    start = start_pose(GO2, FlatTerrain())
    scenario = Scenario(duration, 0.6, start=start, sensors=SensorModel(), seed=1)
    there = make_world(world, GO2, None, 0.6, actuators="real", collision="full")
    log = run(there, controller, scenario)
    return log, summarise_walk(log)


@pytest.mark.parametrize(("speed", "world"), [(0.5, "mujoco"), (1.0, "mujoco"), (0.5, "rigid")])
def test_a_trot_with_real_actuators_keeps_every_limit(speed: float, world: str) -> None:
    log, summary = walk(speed, 3.0, world)
    assert summary.good, headline(summary)
    assert summary.velocity.forward.measured == pytest.approx(speed, abs=0.02)
    assert summary.motors is not None
    assert summary.motors.actuators == "real"
    assert summary.motors.speed_use_max < 1.0
    # the log tells the torques that the motors gave, and those that they were asked for
    given = [REAL.given(t, v[6:]) for t, v in zip(log["torques_commanded"], log["v"], strict=True)]
    np.testing.assert_allclose(log["torques"], given, atol=1e-9)


def test_logged_rotors_and_friction_explain_the_joints() -> None:
    """Newton-Euler of the logged motion: without rotors and friction, legs pull with newtons of nowhere."""
    log, _ = walk(0.5, 1.0)
    log = log.rows(slice(500, 900))
    frames = np.asarray(log["forces"])  # flat ground: contact axes are the world's
    known = np.median(np.linalg.norm(unexplained(GO2, log, frames).feet, axis=2))
    bare = Log(log.arrays, {k: v for k, v in log.facts.items() if k not in ("armature", "dry_friction")})
    unknown = np.median(np.linalg.norm(unexplained(GO2, bare, frames).feet, axis=2))
    assert known < 0.25
    assert unknown > 4.0 * known


def test_limits_that_are_not_kept_are_told() -> None:
    """A robot that is pushed over, lands on its links and is let go on."""
    world = make_world("mujoco", GO2, None, 0.6, actuators="real", collision="full")
    controller = WalkingController(GO2, VelocityCommand.constant(0.0, 0.0, 0.0), "trot", FlatTerrain())
    pushes, start = [Push(0.3, (0.0, 600.0, 0.0), 0.1)], start_pose(GO2, FlatTerrain())
    scenario = Scenario(1.2, 0.6, pushes=pushes, start=start, fall=Fall(0.0, 4.0))
    log = run(world, controller, scenario)
    summary = summarise_walk(log)
    assert not summary.good
    assert any(line.startswith("touched: ") for line in summary.limits_broken)
    assert "limits not kept: " in headline(summary)
    assert "link_touches" in log.facts
    assert replace(summary, limits_broken=[], laws_broken=[], success=True).good
