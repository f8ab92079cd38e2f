"""Walks with real actuators and whole robots: what holds, and what is judged when it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.run_output import walk_headline
from surefoot.motion.walking.walking_controller import WalkSettings
from surefoot.records.audit.dynamics import unexplained
from surefoot.records.audit.logged_robot import LoggedRobot, from_robot
from surefoot.records.log import Log
from surefoot.worlds.running.run import Push
from surefoot.worlds.running.scenario import Fall
from surefoot.worlds.running.sensors import SensorModel
from tests.worlds.running.walks import GO2, REAL, WHOLE, walk


@pytest.mark.parametrize(
    ("speed", "world"),
    [(1.0, "mujoco"), (0.5, "mujoco"), (0.5, "rigid")],
)
@pytest.mark.long
def test_a_trot_with_real_actuators_keeps_every_limit(speed: float, world: str) -> None:
    walked = {"world": WHOLE | {"name": world}, "sensors": SensorModel(), "seed": 1}
    log, summary = walk(speed, 4.0, settings=WalkSettings(actuators=REAL), **walked)
    assert summary.good, walk_headline(summary)
    assert summary.velocity.forward.measured == pytest.approx(speed, abs=0.02)
    assert summary.motors is not None
    assert summary.motors.actuators == "real"
    assert summary.motors.speed_use_max < 1.0
    # the log tells the torques that the motors gave, and those that they were asked for
    given = [REAL.given(t, v[6:]) for t, v in zip(log["torques_commanded"], log["v"], strict=True)]
    np.testing.assert_allclose(log["torques"], given, atol=1e-9)


def test_logged_rotors_and_friction_explain_the_joints() -> None:
    """Newton-Euler of the logged motion: without rotors and friction, legs pull with newtons of nowhere."""
    settings = WalkSettings(actuators=REAL)
    log, _ = walk(0.5, 1.0, world=WHOLE, settings=settings, sensors=SensorModel(), seed=1)
    log = log.rows(slice(500, 900))
    frames = np.asarray(log["forces"])  # flat ground: contact axes are the world's
    robot = from_robot(GO2, log, np.asarray(log.facts["contact_foot"]))
    assert isinstance(robot, LoggedRobot)
    known = np.median(np.linalg.norm(unexplained(robot, log, frames).feet, axis=2))
    bare = Log(log.arrays, {k: v for k, v in log.facts.items() if k not in ("armature", "dry_friction")})
    unknown = np.median(np.linalg.norm(unexplained(robot, bare, frames).feet, axis=2))
    assert known < 0.25
    assert unknown > 4.0 * known


def test_limits_that_are_not_kept_are_told() -> None:
    """A robot that is pushed over, lands on its links and is let go on."""
    pushes, fall = [Push(0.3, (0.0, 600.0, 0.0), 0.1)], Fall(0.0, 4.0)
    log, summary = walk(0.0, 1.2, world=WHOLE, pushes=pushes, fall=fall, seed=None)
    assert not summary.good
    assert any(line.startswith("touched: ") for line in summary.limits_broken)
    assert "limits not kept: " in walk_headline(summary)
    assert "link_touches" in log.facts
    report = sf.audit_log(log)
    assert list(report.limits_broken) == summary.limits_broken
    for said in (report.sentence, str(report)):
        assert summary.limits_broken[0] in said
    assert replace(summary, limits_broken=[], laws_broken=[], success=True).good
