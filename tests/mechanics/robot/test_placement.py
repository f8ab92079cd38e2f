from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.terrain import rough_ground


@pytest.mark.parametrize("name", ["go2", "anymal_c", "hyq", "solo12", "b1"])
@pytest.mark.parametrize("degrees", [-15.0, 0.0, 20.0])
def test_feet_touch_and_weight_is_over_them(name: str, degrees: float) -> None:
    robot, terrain = sf.load_robot(name), sf.SlopeTerrain(degrees)
    q = sf.place(robot, terrain)
    radii = np.array([foot.radius for foot in robot.feet])
    np.testing.assert_allclose(terrain.gap(robot.foot_positions(q)) - radii, 0.0, atol=1e-7)
    stance = robot.stance(q, terrain=terrain)
    np.testing.assert_allclose(robot.com(q)[:2], stance.positions.mean(axis=0)[:2], atol=1e-6)
    up = rotation_from_quaternion(q[3:7])[:, 2]
    np.testing.assert_allclose(up, terrain.normal([0.0, 0.0]), atol=1e-9)


def test_humanoid_stands_level_on_flat_soles() -> None:
    robot, terrain = sf.load_robot("g1"), sf.SlopeTerrain(10.0)
    q = sf.place(robot, terrain)
    np.testing.assert_allclose(rotation_from_quaternion(q[3:7]), np.eye(3), atol=1e-9)
    robot.foot_positions(q)
    for foot in robot.feet:
        corners = np.array([robot.data.oMf[foot.frame].act(c) for c in foot.centres])
        np.testing.assert_allclose(terrain.gap(corners), foot.radius, atol=1e-6)


def test_what_cannot_stand_is_refused() -> None:
    with pytest.raises(ModelError, match="needs a floating base and feet"):
        sf.place(sf.load_robot("panda"))
    with pytest.raises(ModelError, match="legs do not reach the ground"):
        sf.place(sf.load_robot("g1"), sf.SlopeTerrain(70.0))


def test_stands_about_another_place() -> None:
    robot, ground = sf.load_robot("go2"), rough_ground(3, 0.03)
    at = np.array([0.7, -0.4])
    q = sf.place(robot, ground, at=at)
    gaps = ground.gap(robot.foot_positions(q)) - [foot.radius for foot in robot.feet]
    assert np.abs(gaps).max() < 1e-6
    assert np.abs(q[:2] - at).max() < 0.05
    with pytest.raises(sf.ProblemError, match="at"):
        sf.place(robot, ground, at=[np.nan, 0.0])
