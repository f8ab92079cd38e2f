"""Inverse kinematics of legs against the robot's own forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.robot.legs import Legs


@pytest.mark.parametrize("name", ["go2", "anymal_c", "solo12"])
def test_reach_undoes_feet(name: str) -> None:
    robot = sf.load_robot(name)
    legs, rng = Legs(robot), np.random.default_rng(5)
    for _ in range(10):
        joints = robot.nominal[7:] + 0.25 * rng.uniform(-1.0, 1.0, robot.joints)
        joints = np.clip(joints, legs.low + 0.1, legs.high - 0.1)
        q = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], joints])
        feet = robot.foot_positions(q)
        np.testing.assert_allclose(legs.feet(joints), feet, atol=1e-12)
        found = legs.reach(feet, robot.nominal[7:])
        np.testing.assert_allclose(legs.feet(found), feet, atol=1e-5)


def test_what_is_out_of_reach_stays_within_the_limits() -> None:
    robot = sf.load_robot("go2")
    legs = Legs(robot)
    far = legs.feet(robot.nominal[7:]) * [1.0, 1.0, 3.0]
    found = legs.reach(far, robot.nominal[7:])
    assert (found > legs.low).all()
    assert (found < legs.high).all()
    assert legs.feet(found)[:, 2].max() < legs.feet(robot.nominal[7:])[:, 2].min()
