"""Robots stand in MuJoCo: forces from the world, not from the controller, feed every check."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation, rotation_about
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import Lift, StandingPlan
from surefoot.records.audit import summarise_stand
from surefoot.records.audit.motion import tilt_angles
from surefoot.records.log import Log
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import STANDING_FALL, START_DEPTH, Ice, Push, Scenario, push_at


def stand(
    name: str = "go2",
    degrees: float = 0.0,
    duration: float = 2.0,
    mu: float = 0.6,
    payload: float = 0.0,
    lifts: tuple[Lift, ...] = (),
    **events: object,
) -> Log:
    robot, terrain = sf.load_robot(name), sf.SlopeTerrain(degrees)
    q = sf.place(robot, terrain)
    controller = StandingController(robot, StandingPlan(robot, terrain, q, lifts), terrain, q, mu)
    world = MujocoWorld(robot, terrain, mu, payload=payload)
    scenario = Scenario(duration, mu, start=q, depth=START_DEPTH, fall=STANDING_FALL, **events)  # type: ignore[arg-type]
    return run(world, controller, scenario)


def test_go2_stands_on_flat_ground() -> None:
    log = stand(duration=5.0)
    summary = summarise_stand(log)
    weight = summary.mass * GRAVITY
    assert weight == pytest.approx(157.8, abs=0.05)
    assert summary.success
    assert summary.laws_broken == []
    assert summary.normal_force_total_mean == pytest.approx(weight, rel=5e-3)
    means = {foot.name: foot.normal_force_mean for foot in summary.feet}
    assert abs(means["FL_foot"] - means["FR_foot"]) < 1.0
    assert abs(means["RL_foot"] - means["RR_foot"]) < 1.0
    assert summary.base.position_max < 5e-3
    assert summary.base.tilt_max_deg < 0.5
    steady = slice(len(log) // 2, None)
    measured, commanded = log["forces"][steady], log["forces_commanded"][steady]
    assert np.abs(measured[..., :2]).max() < 1.0  # tangential forces are small
    error = np.linalg.norm(measured - commanded, axis=-1)
    assert np.all(error <= 0.05 * np.linalg.norm(commanded, axis=-1) + 1.0)


@pytest.mark.parametrize("name", ["go1", "anymal_b", "hyq", "solo12", "g1"])
@pytest.mark.sampled(2)
def test_other_robots_stand_without_code_of_their_own(name: str) -> None:
    summary = summarise_stand(stand(name, duration=1.0))
    assert summary.success
    assert summary.laws_broken == []
    assert summary.normal_force_total_mean == pytest.approx(summary.mass * GRAVITY, rel=5e-3)


@pytest.mark.parametrize(
    "case",
    [
        {"payload": 5.0, "duration": 4.0},
        {"ice": [Ice(1.0, 0.05)]},
    ],
    ids=["payload", "ice"],
)
@pytest.mark.long
def test_go2_stands_through(case: dict[str, object]) -> None:
    summary = summarise_stand(stand(**case))  # type: ignore[arg-type]
    assert summary.success, summary.outcome
    assert summary.laws_broken == []


@pytest.mark.parametrize(
    ("name", "degrees", "foot", "seed"),
    [("go2", 20.0, "RR", 4), ("anymal_c", 20.0, "LF", 1), ("b1", 15.0, "FR", 2)],
)
@pytest.mark.long
def test_robots_stand_through_a_push_and_a_lift_on_a_slope(
    name: str, degrees: float, foot: str, seed: int | None
) -> None:
    """README's first command (two seconds sooner), and others like it: no foot slides, no law is broken."""
    force = 60.0 / 16.085 * sf.load_robot(name).mass
    pushes = [Push(0.3, (force, 0.0, 0.0), 0.2)]
    summary = summarise_stand(
        stand(name, degrees, 3.2, lifts=(Lift(foot, 1.6, 2.3),), pushes=pushes, seed=seed)
    )
    assert summary.success, summary.outcome
    assert summary.laws_judged == ["unilateral", "Coulomb", "dissipation"]
    assert summary.laws_broken == []
    assert max(f.slip for f in summary.feet) < 5e-4


@pytest.mark.long
def test_lifted_foot_is_in_the_air_and_back() -> None:
    log = stand(lifts=(Lift("FL", 1.0, 2.0),), duration=3.0)
    aloft = (log["time"] > 1.0) & (log["time"] < 2.0)
    assert np.all(log["forces_commanded"][aloft][:, 0] == 0.0)
    middle = (log["time"] > 1.2) & (log["time"] < 1.8)
    assert log["gaps"][middle, 0].min() > 0.02
    assert np.all(log["forces"][middle, 0] == 0.0)
    assert log["forces"][-100:, 0, 2].mean() == pytest.approx(log.facts["mass"] * GRAVITY / 4, rel=0.05)


def test_ice_on_a_slope_ends_in_an_honest_slip() -> None:
    log = stand(degrees=15.0, duration=4.0, ice=[Ice(1.0, 0.15)])
    summary = summarise_stand(log)
    assert summary.outcome == "slipped"
    assert not summary.success
    assert all(np.isfinite(rows).all() for rows in log.arrays.values())
    assert max(foot.slip for foot in summary.feet) > 0.01


def test_push_beyond_the_ground_is_flagged_not_hidden() -> None:
    log = stand(pushes=[Push(0.5, (0.0, 250.0, 0.0), 0.3)], duration=1.5)
    assert not log["attained"].all()
    cone = sf.FrictionCone(0.6)
    assert np.all(cone.margin(log["forces_commanded"]) > -1e-9)


def test_logged_grasp_map_is_the_one_of_that_step() -> None:
    log = stand(duration=0.2, pushes=[Push(0.05, (40.0, 0.0, 0.0), 0.1)])
    missed = np.einsum("tij,tj->ti", log["grasp_map"], log["forces_commanded"].reshape(len(log), -1))
    np.testing.assert_allclose(missed - log["wrench_desired"], log["wrench_error"], atol=1e-9)


def test_helpers() -> None:
    pushes = [Push(1.0, (1.0, 0.0, 0.0), 0.5), Push(1.2, (0.0, 2.0, 0.0), 0.1)]
    assert push_at(pushes, 0.9) is None
    np.testing.assert_allclose(push_at(pushes, 1.25), [1.0, 2.0, 0.0])
    assert push_at(pushes, 1.5) is None
    q = sf.load_robot("go2").nominal
    lying = q.copy()
    lying[3:7] = quaternion_from_rotation(rotation_about([1.0, 0.0, 0.0], np.radians(60.0)))
    assert STANDING_FALL.happened(lying, q[2], sf.FlatTerrain()) == "fell"
    np.testing.assert_allclose(tilt_angles(np.stack([q, lying])), [0.0, np.radians(60.0)], atol=1e-9)
