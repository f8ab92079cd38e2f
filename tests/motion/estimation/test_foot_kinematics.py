"""The feet as the joints have them, rolling, and the detector's kernels: against Pinocchio and NumPy."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ModelError
from surefoot.base.live_arrays import live_parts
from surefoot.base.spatial import rotation_about, rotation_from_normal, rotation_from_quaternion
from surefoot.mechanics.robot import load_robot
from surefoot.motion.estimation.foot_kinematics import FLOOR, FootKinematics, base_state, over_ground, roll
from tests.motion.estimation.poses import exponential


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_places_speeds_and_spreads_are_those_of_differences(name: str) -> None:
    robot, random, deviation, h = load_robot(name), np.random.default_rng(0), 0.01, 1e-6
    joints = robot.nominal[7:] + 0.1 * random.normal(size=robot.joints)
    speeds = random.normal(size=robot.joints)
    feet = FootKinematics(robot, deviation)
    feet.update(joints, speeds)

    def places(angles: np.ndarray) -> np.ndarray:
        return robot.foot_positions(np.r_[np.zeros(6), 1.0, angles])

    np.testing.assert_allclose(feet.centres, places(joints), atol=1e-12)
    moved = (places(joints + h * speeds) - places(joints - h * speeds)) / (2.0 * h)
    np.testing.assert_allclose(feet.velocities, moved, atol=1e-8)
    J = np.array(
        [(places(joints + h * e) - places(joints - h * e)) / (2.0 * h) for e in np.eye(robot.joints)]
    )
    for k, spread in enumerate(feet.spreads):
        np.testing.assert_allclose(spread, deviation**2 * J[:, k].T @ J[:, k] + FLOOR * np.eye(3), atol=1e-10)
    pinocchio.framesForwardKinematics(robot.model, robot.data, np.r_[np.zeros(6), 1.0, joints])
    turned = [robot.data.oMf[f.frame].rotation for f in robot.feet]
    np.testing.assert_allclose(feet.rotations, turned, atol=1e-12)


def test_a_sphere_rolls_as_far_as_it_turns() -> None:
    """Down a slope about the level axis, seen from a body that turns as well."""
    normal, radius, steps = np.array([0.6, 0.0, 0.8]), 0.02, 1000
    frame, angle = rotation_from_normal(normal), 0.7
    X = exponential(np.r_[0.3, -0.2, 0.5, np.zeros(9)])
    body = X[:, :3].copy()
    last = (body @ (body.T @ np.eye(3)))[None].copy()
    rolled = np.zeros((1, 3))
    for k in range(1, steps + 1):
        world = rotation_about(frame[:, 1], angle * k / steps)  # about the contact frame's y: along its x
        X[:, :3] = body @ rotation_about([0.0, 0.0, 1.0], 0.4 * k / steps)
        feet = (X[:, :3].T @ world)[None].copy()
        roll(X, feet, normal[None], np.array([radius]), np.array([True]), last, rolled)
    np.testing.assert_allclose(rolled[0], radius * angle * frame[:, 0], atol=1e-8)
    roll(X, feet, normal[None], np.array([radius]), np.array([False]), last, rolled)
    assert not rolled.any()


@pytest.mark.parametrize("seed", range(6))
def test_base_state_and_speeds_over_ground(seed: int) -> None:
    random = np.random.default_rng(seed)
    X = exponential(
        np.r_[random.normal(size=3) * (0.1, 1.0, 1.0, 2.0, 3.0, 3.1)[seed], random.normal(size=12)]
    )
    turn, arm = random.normal(size=3), random.normal(size=3)
    q, v = np.zeros(19), np.zeros(18)
    base_state(X, turn, arm, q, v)
    R = X[:, :3]
    np.testing.assert_allclose(rotation_from_quaternion(q[3:7]), R, atol=1e-12)
    assert q[6] >= 0.0
    np.testing.assert_allclose(q[:3], X[:, 4] - R @ arm)
    np.testing.assert_allclose(v[:3], R.T @ X[:, 3] - np.cross(turn, arm))
    np.testing.assert_allclose(v[3:6], turn)
    centres, velocities, out = random.normal(size=(2, 3)), random.normal(size=(2, 3)), np.zeros(2)
    over_ground(X, turn, arm, centres, velocities, out)
    expected = [
        np.linalg.norm(v[:3] + np.cross(turn, c) + w) for c, w in zip(centres, velocities, strict=True)
    ]
    np.testing.assert_allclose(out, expected)


def test_only_what_lies_in_place_is_read_in_place() -> None:
    model = load_robot("go2").model
    data = model.createData()
    momenta = live_parts(data.h, "vector")
    pinocchio.computeCentroidalMomentum(model, data, load_robot("go2").nominal, np.arange(18.0))
    np.testing.assert_array_equal(momenta, [h.vector for h in data.h])
    with pytest.raises(ModelError, match="np cannot be read in place"):
        live_parts(data.oMi, "np")  # a copy
    with pytest.raises(ModelError, match="cannot be read in place"):
        live_parts([np.zeros(3)[:2]])
