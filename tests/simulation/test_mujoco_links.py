"""MuJoCo with all links: what the trunk carries, and what the log says of it."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.collision import robot_geometry
from surefoot.errors import ProblemError
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.rigid import RigidWorld
from surefoot.spatial import GRAVITY
from tests.simulation.test_other_forces import Hold, Lying, unexplained

ROBOT = sf.load_robot("go2")


def on_its_back() -> np.ndarray:
    q = ROBOT.nominal.copy()
    q[2], q[3:7] = 0.2, [1.0, 0.0, 0.0, 0.0]
    return q


@pytest.fixture(scope="module")
def log() -> sf.Log:
    world = MujocoWorld(ROBOT, collision="full")
    return sf.run(world, Hold(), sf.Scenario(0.8, 0.6, start=on_its_back(), fall=Lying()))


def test_the_trunk_carries_the_weight(log: sf.Log) -> None:
    """On its back no foot touches, and the others' force is the weight, along the base's own -z."""
    assert not np.asarray(log["forces"])[-100:].any()
    force = np.asarray(log["other_forces"])[-100:, :3].mean(axis=0)
    up = sf.load_robot("go2").mass * GRAVITY
    assert float(np.linalg.norm(force)) == pytest.approx(up, rel=0.01)
    assert force[2] < -0.97 * up


def test_the_forces_explain_the_motion(log: sf.Log) -> None:
    assert np.abs(unexplained(log)[:-1]).max() < 0.02


def test_where_it_comes_to_rest_is_where_rigid_contact_lets_it(log: sf.Log) -> None:
    world = RigidWorld(ROBOT, collision="full")
    rigid = sf.run(world, Hold(), sf.Scenario(0.8, 0.6, start=on_its_back(), fall=Lying()))
    np.testing.assert_allclose(log["q"][-1], rigid["q"][-1], atol=0.02)


def test_a_foot_on_a_link_is_no_foot_on_the_ground() -> None:
    """In the air, with the legs folded into each other: forces within the robot, and none of the ground."""
    world = MujocoWorld(ROBOT, collision="full")
    q = ROBOT.nominal.copy()
    q[2] = 3.0
    q[7:] = np.array([0.0, 3.4, -2.6, 0.0, 3.4, -2.6, 0.0, -0.4, -1.0, 0.0, -0.4, -1.0])
    world.reset(q)
    touched, fed = set[tuple[str, str]](), 0.0
    for _ in range(300):
        now, v = world.state()
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


def test_feet_alone_are_the_default() -> None:
    world = MujocoWorld(ROBOT)
    assert world.contacts().others is None
    assert world.touching() == []
    with pytest.raises(ProblemError, match="full"):
        MujocoWorld(ROBOT, collision="some")
