"""Jumps sideways, turning, with a payload; limits that a model does not give; wrong requests."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.robot.actuators import unknown_limits
from surefoot.mechanics.robot.legs import Legs
from surefoot.mechanics.terrain import PitTerrain, StairsTerrain, rough_ground
from surefoot.motion.planning.schedule.motions import (
    QUICK,
    jump,
    landing_configuration,
    lift_speed,
    time_scale,
)
from surefoot.motion.planning.tasks import scheduled
from surefoot.motion.planning.tasks.scheduled import mover
from surefoot.motion.planning.tasks.task import PlanRequest
from surefoot.worlds.running.plan_execution import execute

pytest.importorskip("casadi")


@pytest.mark.long
def test_a_jump_goes_where_it_is_told_and_carries_its_payload(go2):
    plan = sf.plan(go2, "jump", 0.2, direction=0.5 * math.pi, payload=1.5, dt=0.02)
    assert plan.status.value in ("solved", "almost"), plan.facts["goal"]
    way = (plan["contact_positions"][-1] - plan["contact_positions"][0]).mean(axis=0)
    assert abs(way[0]) < 0.05
    assert 0.19 <= way[1] < 0.26
    assert plan.fact("mass") == pytest.approx(go2.mass + 1.5)
    last = plan["forces"][-5:, :, 2].sum(axis=1).mean()
    assert last == pytest.approx(9.81 * (go2.mass + 1.5), rel=0.05)
    again = plan.again(go2)  # the payload is in the plan's facts
    assert np.abs(again.q[:-1] - plan["q"]).max() < 1e-9


@pytest.mark.long
def test_a_jump_that_turns_is_solved_and_lands(go2):
    pytest.importorskip("mujoco")
    plan = sf.plan(go2, "jump", 0.0, turn=0.5 * math.pi).raise_if_failed()
    q = plan.fact("end_q")
    assert 2.0 * math.atan2(q[5], q[6]) == pytest.approx(0.5 * math.pi, abs=0.1)
    done = execute(plan, seed=0)
    assert (done.landed, done.laws) == (True, []), done.why


def test_where_a_jump_ends_is_turned_about_the_middle_of_the_feet(go2):
    q = sf.place(go2)
    there = landing_configuration(go2, q, 0.3, (0.25 * math.pi, 0.5 * math.pi), sf.FlatTerrain())
    before, after = go2.foot_positions(q), go2.foot_positions(there)
    assert after.mean(axis=0) - before.mean(axis=0) == pytest.approx([0.3 / 2**0.5, 0.3 / 2**0.5, 0.0])
    arms, turned = before - before.mean(axis=0), after - after.mean(axis=0)
    assert turned[:, 1] == pytest.approx(arms[:, 0])


@pytest.mark.parametrize(("name", "slow"), [("anymal_c", True), ("go2", False)])
def test_a_flight_begins_no_faster_than_the_joints_allow(name, slow):
    robot = sf.load_robot(name)
    q, speed, dt = sf.place(robot), lift_speed(robot, robot.nominal), 1e-4
    legs = Legs(robot)
    feet = legs.feet(q[7:]) - [0.0, 0.0, speed * dt]  # the body lifted over standing feet
    rates = (legs.reach(feet, q[7:]) - q[7:]) / dt
    assert np.abs(rates / robot.speed_limits).max() == pytest.approx(1.0, rel=0.05)
    lift, land = jump(robot, 0.3, 0.0, 0.6).schedule.event_times
    wanted = 2.0 * QUICK * speed / 9.81 if slow else 0.3 * time_scale(robot)
    assert land - lift == pytest.approx(wanted, rel=1e-3)


@pytest.mark.long
def test_a_robot_with_slow_joints_jumps():
    plan = sf.plan(sf.load_robot("anymal_c"), "jump", 0.3)
    assert plan.status.value == "solved", plan.facts["goal"]


def test_limits_that_no_motor_has_are_unknown(go2):
    bare = sf.load_robot("quadruped")
    assert unknown_limits(bare) == ("torque", "speed")
    for known in (go2, sf.load_robot("solo12"), sf.load_robot("ur5")):
        assert unknown_limits(known) == ()
    likely = mover(PlanRequest(bare))
    assert (likely.effort_limits < 10.0).all()
    assert (likely.speed_limits < 100.0).all()
    assert (bare.effort_limits == 1000.0).all()


@pytest.mark.parametrize(
    ("task", "asked", "told"),
    [
        ("ball", {"payload": 1.0}, "takes no payload"),
        ("stand-up", {"payload": 1.0}, "takes no payload; it takes none of these"),
        ("backflip", {"turn": 1.0}, "takes no turn; it takes start, payload"),
        ("jump", {"terrain": "flat"}, "terrain"),
        ("jump", {"near": "plan.npz"}, "near must be a Plan"),
        ("jump", {"terrain": PitTerrain(0.5, 0.2, 0.3)}, "FL_foot lands at x = 0.624 m, too near an edge"),
        ("jump", {"terrain": rough_ground(1, 0.05)}, "takes a plane or steps"),
        ("jump-up", {"over": 0.1}, "takes no over"),
        ("jump", {"over": 0.6}, "leaves 0.559 m, got 0.6; straight on it takes 1.05 m"),
        ("jump", {"over": 0.3, "amount": 0.5}, "leaves 0.0532 m, got 0.3; straight on it takes 0.747 m"),
        ("jump", {"over": 0.1, "terrain": sf.FlatTerrain()}, "over and terrain both say"),
        ("jump", {"start": [0.0] * 5}, r"start must have shape \(19,\), got \(5,\)"),
        ("jump", {"payload": math.nan}, "payload"),
    ],
)
def test_what_a_task_does_not_take_is_named(go2, task, asked, told):
    with pytest.raises(sf.ProblemError, match=told):
        sf.plan(None if task == "ball" else go2, task, **asked)


@pytest.mark.parametrize(("by", "told"), [(0.02, "0.02 m off it"), (-0.05, "0.05 m in it")])
def test_a_start_off_the_ground_is_refused(go2, by, told):
    q = sf.place(go2)
    q[2] += by
    with pytest.raises(sf.ProblemError, match=told):
        sf.plan(go2, "jump", start=q)


@pytest.mark.long
def test_a_search_from_a_near_plan_ends_in_the_same_motion_sooner(go2, monkeypatch):
    kept = sf.plan(go2, "jump", 0.25, dt=0.02)
    far, near = (sf.plan(go2, "jump", 0.35, dt=0.02, near=one) for one in (None, kept))
    assert near.iterations < 0.6 * far.iterations
    assert near.cost == pytest.approx(far.cost, rel=1e-5)
    assert np.abs(near["q"] - far["q"]).max() < 1e-3
    monkeypatch.setattr(scheduled, "BRIEF", 1e-9)  # a search from a plan that is not near begins anew
    assert sf.plan(go2, "jump", 0.35, dt=0.02, near=kept).iterations == far.iterations
    with pytest.raises(sf.ProblemError, match="the same robot, kind of task and knots"):
        sf.plan(go2, "jump", near=kept)


@pytest.mark.long
def test_a_jump_over_a_gap_is_solved_and_lands(go2):
    pytest.importorskip("mujoco")
    plan = sf.plan(go2, "jump", over=0.3).raise_if_failed()
    ditch = plan.terrain
    x = plan["contact_positions"][..., 0]
    inside = (x > ditch.start) & (x < ditch.start + ditch.length)
    assert inside.any()
    assert not plan["forces"][inside].any()
    done = execute(plan, seed=0)
    assert (done.landed, done.laws) == (True, []), done.why


def test_front_feet_leave_and_land_first_on_a_step(go2):
    problem = jump(go2, 0.75, 0.0, 0.6, terrain=StairsTerrain(0.2, 2.0, 1))
    first = np.unique(problem.stance, axis=0, return_index=True)[1]
    assert problem.stance[np.sort(first)].tolist() == [
        [True] * 4,
        [False, False, True, True],
        [False] * 4,
        [True, True, False, False],
    ]


@pytest.mark.long
@pytest.mark.parametrize(("height", "way"), [(0.15, 0.7), (0.25, 0.75)])
def test_a_jump_lands_on_a_step(go2, height, way):
    plan = sf.plan(go2, "jump", way, terrain=StairsTerrain(height, 2.0, 1)).raise_if_failed()
    assert plan["contact_positions"][-1, :, 2] == pytest.approx(height, abs=1e-3)
    if height < 0.2:
        pytest.importorskip("mujoco")
        done = execute(plan, seed=0)
        assert (done.landed, done.laws) == (True, []), done.why


@pytest.mark.parametrize(("task", "asked"), [("jump", 9.0), ("jump", -9.0), ("jump-up", -0.1)])
def test_a_jump_beyond_any_reach_is_refused_at_once(go2: sf.Robot, task: str, asked: float) -> None:
    with pytest.raises(sf.ProblemError, match="must be a number between"):
        sf.plan(go2, task, asked)
