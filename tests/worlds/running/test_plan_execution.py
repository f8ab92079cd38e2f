"""Execution: what a seed changes, who counts as landed, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import rotation_from_quaternion, rotation_log
from surefoot.mechanics.robot.actuators import limited_robot
from surefoot.mechanics.robot.motor_limits import motor_limits
from surefoot.motion.planning import Plan, PlanSearch, plan_from, rollout
from surefoot.motion.planning.tracking import Reference
from surefoot.worlds.running.plan_execution import (
    FRICTION_ERROR,
    MASS_ERROR,
    START_PLACE,
    START_TURN,
    MotorLimiter,
    Surprise,
    displace,
    execute,
)
from tests.motion.planning.tracking.hops import hop

ROBOT = sf.load_robot("go2")


@pytest.fixture(scope="module")
def jump() -> Reference:
    return hop(ROBOT, 1.6, 0.8)


def test_seeds_cover_what_they_may_and_no_more() -> None:
    drawn = [Surprise.draw(seed) for seed in range(300)]
    for values, most in (
        ([s.place for s in drawn], START_PLACE),
        ([s.turn for s in drawn], START_TURN),
        ([[s.friction - 1.0] for s in drawn], FRICTION_ERROR),
        ([[s.mass - 1.0] for s in drawn], MASS_ERROR),
    ):
        array = np.array(values)
        assert np.abs(array).max() <= most
        assert (array.max(axis=0) > 0.9 * most).all()
        assert (array.min(axis=0) < -0.9 * most).all()
    np.testing.assert_array_equal(Surprise.draw(7).place, drawn[7].place)


def test_a_displaced_body_keeps_its_feet(jump: Reference) -> None:
    surprise = Surprise(np.array([0.02, -0.01, 0.0]), np.array([0.02, 0.03, -0.02]))
    q = displace(ROBOT, jump.start, surprise)
    np.testing.assert_allclose(ROBOT.foot_positions(q), ROBOT.foot_positions(jump.start), atol=1e-4)
    np.testing.assert_allclose(q[:2] - jump.start[:2], surprise.place[:2])
    turned = rotation_from_quaternion(q[3:7]) @ rotation_from_quaternion(jump.start[3:7]).T
    np.testing.assert_allclose(rotation_log(turned), surprise.turn, atol=1e-9)


@pytest.mark.parametrize(
    ("world", "limits"),
    [("mujoco", "curve"), ("mujoco-exact", "curve"), ("mujoco", "box")],
)
@pytest.mark.long
def test_surprises_are_survived(jump: Reference, world: str, limits: str) -> None:
    done = execute(jump, world, limits, 4, dt=1e-3)
    assert done.landed, done.why
    assert done.verdict == "lawful"
    assert done.log.facts["mass"] == pytest.approx(ROBOT.mass * done.surprise.mass)
    assert done.log["mu"][0] == pytest.approx(0.6 * done.surprise.friction)


@pytest.mark.long
def test_motors_cannot_give_what_a_weaker_robot_has_not(jump: Reference) -> None:
    """With a fifth of the torque the hop does not happen, and nobody says that it did."""
    from surefoot.mechanics.robot.motor_limits import MotorLimits, motor_limits

    box = motor_limits(ROBOT)
    weak = MotorLimits(0.2 * box.effort, box.speed)
    done = execute(jump, "mujoco", weak, dt=1e-3)
    assert not done.landed
    assert done.why
    assert done.torque_use_max == pytest.approx(0.2, abs=1e-9)


def test_a_plan_from_a_file_has_the_same_limits(tmp_path: Path) -> None:
    """Its model gives 1000 N m: a saved jump of such a one was executed with them, and burst."""
    robot = limited_robot(sf.load_robot("quadruped"))
    n = robot.joints
    motion = rollout(robot, sf.place(robot), np.zeros(6 + n), np.zeros((6, n)), dt=0.01)
    plan_from(motion, robot, PlanSearch("fall", "none", 0.0, True, 0, 0.0)).save(tmp_path / "fall.npz")
    done = execute(Plan.read(tmp_path / "fall.npz"), "mujoco", dt=1e-3, settle=0.01)
    np.testing.assert_allclose(done.log.fact("effort_limits"), robot.effort_limits)


def test_what_is_refused(jump: Reference) -> None:
    with pytest.raises(sf.ProblemError, match="worlds mujoco, mujoco-exact, rigid"):
        execute(jump, "drake")
    with pytest.raises(sf.ProblemError, match=r"box.*curve"):
        execute(jump, "mujoco", "strong")
    with pytest.raises(sf.ProblemError, match="seed"):
        execute(jump, "mujoco", seed=-1)


def test_a_controller_behind_motors() -> None:
    class Push(sf.Controller):
        channels = ()

        def step(self, state: sf.RobotState) -> sf.Command:
            every = np.ones(4, dtype=bool)
            return sf.Command(np.full(12, 40.0), np.zeros((4, 3)), every, True, sf.Status.SOLVED)

    limited = MotorLimiter(Push(), motor_limits(ROBOT))
    v = np.zeros(18)
    v[8] = 20.0
    torques = limited.step(sf.RobotState(ROBOT.nominal, v)).torques
    np.testing.assert_allclose(torques, [23.7, 23.7, 0.0, *[23.7, 23.7, 40.0] * 3])
