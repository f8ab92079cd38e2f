"""Contact-implicit walking: what its cost says of legs, and that it stands, steps and recovers by itself."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ModelError, ProblemError
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.planning.mpc.contact_implicit_controller import ContactImplicitMpc, MpcSettings
from surefoot.motion.planning.mpc.cost import WalkWeights, walking_costs
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Push, Scenario
from surefoot.worlds.running.walk_terrain import start_pose
from tests.robots import go2


def controller(*velocity: float, **settings: object) -> ContactImplicitMpc:
    return ContactImplicitMpc(go2(), VelocityCommand.constant(*velocity), settings=MpcSettings(**settings))  # type: ignore[arg-type]


def test_diagonal_legs_that_mirror_each_other_cost_nothing() -> None:
    tables = walking_costs(go2(), place(go2()), WalkWeights(diagonal=1.0, torque=0.5)).tables(go2(), 3)
    D = tables.torque[0] - 0.5 * np.eye(12)
    leg, other = np.array([1.0, 2.0, 3.0]), np.array([-4.0, 0.5, 1.0])
    mirror = np.array([-1.0, 1.0, 1.0])  # FL, FR, RL, RR
    trot = np.concatenate([leg, other, mirror * other, mirror * leg])
    pace = np.concatenate([leg, other, leg, other])
    assert trot @ D @ trot == pytest.approx(0.0, abs=1e-12)
    assert pace @ D @ pace == pytest.approx(2.0 * ((leg - mirror * other) ** 2).sum())


def test_robots_without_four_legs_are_refused() -> None:
    with pytest.raises(ModelError, match="g1"):
        ContactImplicitMpc(load_robot("g1"), VelocityCommand.constant(0.0))


@pytest.mark.parametrize(
    "change", [{"knots": 1}, {"dt": 0.0}, {"interval": 0.1}, {"iterations": 0}, {"mu": -1.0}]
)
def test_settings_out_of_range_are_named(change: dict[str, float]) -> None:
    with pytest.raises(ProblemError, match=next(iter(change))):
        MpcSettings(**change)  # type: ignore[arg-type]


@pytest.mark.long
def test_it_steps_off_without_being_told_which_foot_and_when() -> None:
    """In rigid contact, from standing: feet of a diagonal lift together, and it moves."""
    world = RigidWorld(go2())
    log = run(world, controller(0.5), Scenario(1.0, 0.6, start=place(go2())))
    assert log.fact("outcome") == "done"
    assert log["attained"].all()
    late = log["time"] > 0.5
    on = log["forces"][late][:, :, 2] > 1.0
    assert (np.diff(on.astype(int), axis=0) == 1).sum(axis=0).min() >= 1  # every foot lands
    assert 0.3 < log["v"][late, 0].mean() < 0.7
    assert log["q"][:, 2].min() > 0.25
    assert (np.abs(log["torques"]) <= go2().effort_limits + 1e-9).all()


@pytest.mark.long
def test_it_stands_still_when_told_to_and_steps_when_pushed() -> None:
    world = RigidWorld(go2())
    push = Push(0.3, (0.0, 120.0, 0.0), 0.1)
    log = run(world, controller(0.0), Scenario(1.0, 0.6, pushes=(push,), start=place(go2())))
    assert log.fact("outcome") == "done"
    on = log["forces"][:, :, 2] > 1.0
    before = (log["time"] > 0.1) & (log["time"] < 0.29)
    assert on[before].all()
    assert not on[log["time"] > 0.3].all()
    moved = log["contact_positions"][-1] - log["contact_positions"][0]
    assert np.linalg.norm(moved[:, :2], axis=1).max() > 0.02
    assert np.abs(log["v"][-1]).max() < 0.6


def test_between_ticks_a_step_only_reads_the_plan() -> None:
    member, q = controller(0.3, first_iterations=2), place(go2())
    first = member.step(RobotState(q, np.zeros(18), 0.0))
    assert first.tick > 0.0
    assert first.status is Status.SOLVED
    torques = member.iteration.now.torques.copy()
    again = member.step(RobotState(q, np.zeros(18), 0.001))
    assert again.tick == 0.0
    assert (member.iteration.now.torques == torques).all()
    later = member.step(RobotState(q, np.zeros(18), 0.02))
    assert later.tick > 0.0


def test_the_wanted_motion_is_in_the_heading_frame_and_ramped() -> None:
    member, q = controller(0.4, 0.1, 0.5, first_iterations=1), place(go2())
    q[3:7] = [0.0, 0.0, np.sin(0.6), np.cos(0.6)]  # heading 1.2 rad
    member.step(RobotState(q, np.zeros(18), 0.0))
    member.step(RobotState(q, np.zeros(18), 0.02))
    _, wanted_q, wanted_v = member.iteration.tables.state
    speed = 0.02 * 1.5  # the ramp's share of all three
    c, s = np.cos(1.2 + 0.02 * speed), np.sin(1.2 + 0.02 * speed)
    np.testing.assert_allclose(wanted_v[0, :2], [speed * (c - s), speed * (s + c)], rtol=1e-3)
    np.testing.assert_allclose(wanted_v[:, 5], speed)
    heading = 2.0 * np.arctan2(wanted_q[:, 5], wanted_q[:, 6])
    np.testing.assert_allclose(np.diff(heading), member.settings.dt * speed, rtol=1e-9)


def test_the_height_follows_the_ground() -> None:
    ground, level = SlopeTerrain(3.0), place(go2())
    member = ContactImplicitMpc(go2(), VelocityCommand.constant(0.0), ground, MpcSettings(first_iterations=1))
    q = start_pose(go2(), ground)
    q[0] += 2.0
    q[2] += float(ground.height(np.array([2.0, 0.0])) - ground.height(np.zeros(2)))
    assert member.step(RobotState(q, np.zeros(18), 0.0)).attained
    want = level[2] + float(ground.height(q[:2]))
    np.testing.assert_allclose(member.iteration.tables.state[1][:, 2], want)
    assert want > level[2] + 0.05


def test_a_robot_that_no_step_can_be_taken_from_gets_springs_and_is_taken_up_again() -> None:
    member, q = controller(0.0, first_iterations=2), place(go2())
    fast = np.full(18, 9e5)
    lost = member.step(RobotState(q, fast, 0.0))
    assert not lost.attained
    assert lost.status is Status.STALLED
    assert (lost.forces == 0.0).all()
    good = member.step(RobotState(q, np.zeros(18), 0.02))
    assert good.attained


def test_after_a_long_pause_the_plan_begins_anew() -> None:
    member, q = controller(0.0, first_iterations=2), place(go2())
    member.step(RobotState(q, np.zeros(18), 0.0))
    late = member.step(RobotState(q, np.zeros(18), 1e9))
    assert late.attained
    assert np.abs(late.torques).max() < go2().effort_limits.max()


def test_a_reset_controller_repeats_itself() -> None:
    member, q = controller(0.3, first_iterations=2), place(go2())

    def two() -> np.ndarray:
        return np.array([member.step(RobotState(q, np.zeros(18), t)).torques for t in (0.0, 0.02)])

    first = two()
    member.reset()
    assert (two() == first).all()
