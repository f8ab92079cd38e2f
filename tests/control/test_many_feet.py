"""Made-up robots of other numbers of point feet walk by gaits of their own, or are refused before a run."""

from __future__ import annotations

from pathlib import Path

import pytest

import surefoot as sf
from surefoot.control.walkers import walking_controller
from surefoot.errors import ModelError
from tests.legged import write_legged


def robot_of(folder: Path, legs: int) -> sf.Robot:
    path, feet = write_legged(folder, legs)
    return sf.load_robot(path, feet=feet)


def walk(robot: sf.Robot, gait: sf.Gait | str | None, speed: float, duration: float) -> sf.Log:
    controller = walking_controller(robot, sf.VelocityCommand.constant(speed), gait)
    return sf.run(sf.MujocoWorld(robot), controller, sf.Scenario(duration, 0.6))


def test_a_hexapod_walks_by_a_gait_of_its_own(tmp_path: Path) -> None:
    tripod = sf.Gait.from_phases("tripod", 0.45, 0.6, [0.5, 0.0, 0.0, 0.5, 0.5, 0.0])
    log = walk(robot_of(tmp_path, 6), tripod, 0.4, 2.5)
    summary = sf.summarise_walk(log)
    assert summary.good
    assert summary.velocity.forward.measured == pytest.approx(0.4, rel=0.1)
    assert sf.audit_log(log).verdict == "lawful"


def test_feet_that_cannot_stand_are_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"legged2 cannot walk here: .* three or more point feet, it has 2"):
        walk(robot_of(tmp_path, 2), None, 0.3, 1.0)
    with pytest.raises(sf.ProblemError, match="named gaits for 2 and 4 feet, not for 6"):
        walk(robot_of(tmp_path, 6), "trot", 0.3, 1.0)
