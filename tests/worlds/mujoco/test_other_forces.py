"""A robot on its trunk, in both worlds: its log has the trunk's forces, and the audit explains the motion."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.mechanics.collision import robot_geometry
from surefoot.mechanics.terrain import read_terrain
from surefoot.mechanics.terrain.terrain import Terrain
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.rows import Rows
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.scenario import Fall
from tests.records.audit.logs import changed

ROBOT = sf.load_robot("go2")
WEIGHT = ROBOT.mass * GRAVITY


class Hold(sf.Controller):
    """Springs at the joints."""

    channels = ()

    def step(self, state: sf.RobotState) -> sf.Command:
        torques = np.clip(60.0 * (ROBOT.nominal[7:] - state.q[7:]) - 2.0 * state.v[6:], -23.0, 23.0)
        return sf.Command(torques, np.zeros((4, 3)), np.ones(4, dtype=bool), True, sf.Status.SOLVED)


class Lying(Fall):
    """Whatever the robot does, the run goes on."""

    def happened(self, q: np.ndarray, height: float, terrain: Terrain) -> None:
        return None


@cache
def fallen(world: str = "rigid") -> sf.Log:
    """Return the log of a robot that falls on its back."""
    q = ROBOT.nominal.copy()
    q[2], q[3:7] = 0.2, [1.0, 0.0, 0.0, 0.0]
    scenario = sf.Scenario(0.8, 0.6, start=q, fall=Lying())
    return sf.run(make_world(world, ROBOT, collision="full"), Hold(), scenario)


@pytest.fixture(scope="module")
def on_its_back() -> sf.Log:
    return fallen()


def unexplained(log: sf.Log) -> np.ndarray:
    """Return the force that the log leaves unexplained, over the weight: (T, 3)."""
    rest = Rows(log, setting_of(log, None), 0, len(log)).unexplained
    assert rest is not None
    return rest.force / WEIGHT


@pytest.mark.parametrize("world", ["rigid", "mujoco"])
def test_the_trunk_carries_the_weight(world: str) -> None:
    log = fallen(world)
    assert log.channels["other_forces"].shape == (18,)
    assert not np.asarray(log["forces"])[-200:].any()
    R = rotation_from_quaternion(np.asarray(log["q"])[-200:, 3:7])
    force = np.einsum("tij,tj->ti", R, np.asarray(log["other_forces"])[-200:, :3])
    assert np.abs(force.mean(axis=0) - [0.0, 0.0, WEIGHT]).max() < 0.02 * WEIGHT


def test_the_motion_is_explained_through_the_impact_and_after(on_its_back: sf.Log) -> None:
    """Newton-Euler of the audit, which knows nothing of the world's contact problem."""
    rest = unexplained(on_its_back)
    assert np.nanmax(np.linalg.norm(rest[-200:], axis=1)) < 1e-3
    # through impacts too momentum is accounted for, over rows
    assert np.linalg.norm(np.nansum(rest, axis=0)) < 1e-2 * np.linalg.norm(
        np.nansum(unexplained(without(on_its_back)), axis=0)
    )
    report = sf.audit_log(on_its_back)
    assert report.verdict == "lawful", report.violations
    assert report.symptoms == ()


def without(log: sf.Log) -> sf.Log:
    """Return a log that has the feet's forces alone."""
    kept = tuple(name for name in log.arrays if name != "other_forces")
    return changed(log, keep=kept)


def test_without_the_channel_the_audit_misses_the_weight(on_its_back: sf.Log) -> None:
    rest = unexplained(without(on_its_back))
    assert np.nanmean(rest[-200:, 2]) == pytest.approx(1.0, abs=0.02)
    assert sf.audit_log(without(on_its_back)).verdict != "lawful"


def test_a_wrong_force_of_the_trunk_is_told(on_its_back: sf.Log) -> None:
    wrong = changed(on_its_back, other_forces=0.7 * np.asarray(on_its_back["other_forces"]))
    assert sf.audit_log(wrong).verdict != "lawful"
    lost = np.array(on_its_back["other_forces"])
    lost[300:320] = np.nan
    assert sf.audit_log(changed(on_its_back, other_forces=lost)).verdict != "broken"


def test_both_worlds_explain_the_motion_and_come_to_rest_alike() -> None:
    rigid, mujoco = fallen("rigid"), fallen("mujoco")
    assert np.abs(unexplained(mujoco)[:-1]).max() < 0.02
    np.testing.assert_allclose(mujoco["q"][-1], rigid["q"][-1], atol=0.02)


def test_feet_on_ridges_and_in_valleys_explain_the_motion() -> None:
    """Facets under one foot lean towards each other: together they push less than their forces added up."""
    ground = read_terrain("rough:2,0.2")
    q = sf.place(ROBOT, ground, at=(0.13, -0.04))
    q[2] += 0.03
    log = sf.run(make_world("mujoco", ROBOT, terrain=ground), Hold(), sf.Scenario(0.3, 0.6, start=q))
    rest, blow = np.linalg.norm(unexplained(log)[:-1], axis=1), np.asarray(log["forces"])[..., 2].sum(axis=1)
    assert blow.max() > 2.0 * WEIGHT
    assert np.linalg.norm(np.asarray(log["other_forces"])[:, :3], axis=1).max() > 0.2 * WEIGHT
    assert rest.max() < 1e-3


@pytest.mark.parametrize("world", ["rigid", "mujoco"])
def test_feet_alone_have_stops_at_most(world: str) -> None:
    """The rigid world knows no stops without links; MuJoCo's joints have theirs all the same."""
    made = make_world(world, ROBOT)
    log = sf.run(made, Hold(), sf.Scenario(0.01, 0.6))
    assert ("other_forces" in log) == (world == "mujoco")
    assert world == "rigid" or not log["other_forces"].any()
    with pytest.raises(sf.ProblemError, match="full"):
        make_world(world, ROBOT, collision="some")


class Driven(Hold):
    """Holds its pose, but for a knee that is driven into its stop."""

    def step(self, state: sf.RobotState) -> sf.Command:
        torques = np.array(super().step(state).torques)
        torques[2] = -ROBOT.effort_limits[2]
        return sf.Command(torques)


@pytest.mark.parametrize("world", ["mujoco", "mujoco-exact"])
def test_a_joint_at_its_stop_is_no_force_from_nowhere(world: str) -> None:
    log = sf.run(make_world(world, ROBOT), Driven(), sf.Scenario(0.6, 0.6))
    assert np.abs(log["other_forces"][:, 8]).max() > 1.0
    assert "motion" not in sf.audit_log(log).laws_broken
    bare = {name: array for name, array in log.arrays.items() if name != "other_forces"}
    assert "motion" in sf.audit_log(sf.Log(bare, dict(log.facts))).laws_broken


def test_a_foot_on_a_link_is_no_foot_on_the_ground() -> None:
    """In the air, with the legs folded into each other: forces within the robot, and none of the ground."""
    world = MujocoWorld(ROBOT, collision="full")
    q = ROBOT.nominal.copy()
    q[2] = 3.0
    q[7:] = np.array([0.0, 3.4, -2.6, 0.0, 3.4, -2.6, 0.0, -0.4, -1.0, 0.0, -0.4, -1.0])
    world.reset(q)
    touched, fed = set[tuple[str, str]](), 0.0
    for _ in range(300):
        now, v = world.q_v()
        aim = np.array([-1.0, 3.4, -2.0, 1.0, 3.4, -2.0, -1.0, 0.8, -2.6, 1.0, 0.8, -2.6])
        world.step(np.clip(40.0 * (aim - now[7:]) - v[6:], -20.0, 20.0))
        reading = world.contacts()
        touched.update(world.touching())
        assert not reading.forces.any()
        assert reading.others is not None
        fed = max(fed, float(np.abs(reading.others[6:]).max()))
        # what the robot does to itself moves nothing as a whole
        assert np.abs(reading.others[:3]).max() < 1e-6 * max(1.0, fed)
    assert touched
    assert fed > 1.0
    assert not any("ground" in pair for pair in touched)


def test_pairs_are_those_of_the_rigid_world() -> None:
    world = MujocoWorld(ROBOT, collision="full")
    geometry = robot_geometry(ROBOT)
    names = [s.name for s in geometry.solids]
    wanted = {frozenset((names[a], names[b])) for a, b in geometry.pairs().tolist()}
    model = world.model
    made = {
        frozenset(
            model.geom(int(g)).name.split(":", 1)[1] for g in (model.pair_geom1[k], model.pair_geom2[k])
        )
        for k in range(model.npair)
    }
    assert made == wanted
