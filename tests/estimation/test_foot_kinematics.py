"""The feet as the joints have them, rolling, and the detector's kernels: against Pinocchio and NumPy."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.errors import ModelError
from surefoot.estimation.contact_detection import ContactDetector, DetectionSettings
from surefoot.estimation.detection_kernels import DAMPING, foot_forces
from surefoot.estimation.foot_kinematics import (
    FLOOR,
    FootKinematics,
    base_state,
    over_ground,
    roll,
    state_ahead,
)
from surefoot.estimation.live_arrays import live_parts
from surefoot.robot import load_robot
from surefoot.robot.rotors import with_rotors
from surefoot.spatial import GRAVITY, rotation_about, rotation_from_normal, rotation_from_quaternion
from tests.estimation.poses import exponential


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


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_the_observer_is_its_equation(name: str) -> None:
    """ṗ = S τ + C(q, v)ᵀ v - g + Jᵀ f with Pinocchio's M, C and g, rotors included, anywhere in the world."""
    robot, random, dt = load_robot(name), np.random.default_rng(2), 0.01
    robot = with_rotors(robot, random.uniform(0.0, 0.1, robot.joints))
    model, n = robot.model, len(robot.feet)
    data, points = model.createData(), robot.contact_points
    detector = ContactDetector(robot, dt, DetectionSettings(bandwidth=30.0), least=5.0)
    keep, expected, past = np.exp(-30.0 * dt), np.zeros(model.nv), None
    for _ in range(4):
        q = pinocchio.integrate(model, robot.nominal, 0.5 * random.normal(size=model.nv))
        q[:3] += [3.0, -2.0, 1.0]
        v, torques, up = (
            random.normal(size=model.nv),
            random.normal(size=robot.joints),
            random.normal(size=(n, 3)),
        )
        up /= np.linalg.norm(up, axis=1)[:, None]
        pushed = detector.observe(q, v, up)
        detector.applied(torques)
        M = np.triu(pinocchio.crba(model, data, q))
        momentum = (M + np.triu(M, 1).T) @ v
        C = pinocchio.computeCoriolisMatrix(model, data, q, v)
        if past is not None:
            expected = keep * expected + (1.0 - keep) * ((momentum - past[0]) / dt - past[1])
        np.testing.assert_allclose(detector._residual[6:], expected[6:], rtol=1e-9, atol=1e-9)
        past = (
            momentum,
            C.T @ v - pinocchio.computeGeneralizedGravity(model, data, q) + np.r_[np.zeros(6), torques],
        )
        J = np.array(pinocchio.computeJointJacobians(model, data, q))
        pinocchio.updateFramePlacements(model, data)
        centres = [data.oMf[f].act(m) for f, m in zip(points.frames, points.middles, strict=True)]
        places = np.array(centres) - points.foot_radii[:, None] * up
        forces, velocities = np.zeros((n, 3)), np.zeros((n, 3))
        foot_forces(J, points.foot_support, places, points.flat, expected, v, DAMPING, forces, velocities)
        np.testing.assert_allclose(detector.points, places, atol=1e-12)
        np.testing.assert_allclose(detector.velocities, velocities, atol=1e-11)
        np.testing.assert_allclose(detector.forces, forces, rtol=1e-7, atol=1e-7)
        np.testing.assert_array_equal(pushed, (forces * up).sum(axis=1) > 5.0)
    detector.reset()
    assert not detector._residual.any()
    detector.observe(q, v, up)
    assert not detector._residual.any()  # a first step has nothing to compare with


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


def test_the_state_ahead_is_that_of_its_parts() -> None:
    random, dt = np.random.default_rng(10), 2e-3
    X, bias, arm = exponential(0.5 * random.normal(size=15)), 0.1 * random.normal(size=6), np.full(3, 0.05)
    gyros, forces = random.normal(size=(3, 3)), 9.0 + random.normal(size=(3, 3))
    joints, speeds, early, late = random.normal(size=(4, 12))
    before = X.copy()
    q, v = np.empty(19), np.empty(18)
    state_ahead(X, bias, gyros, forces, dt, arm, joints, speeds, early, late, 0.02, 0.004, q, v)
    np.testing.assert_array_equal(X, before)
    rotation, velocity, place = X[:, :3], X[:, 3], X[:, 4]
    for rate, force in zip(gyros, forces, strict=True):  # far smaller steps, by the midpoint
        for _ in range(400):
            h = dt / 400
            size = float(np.linalg.norm(rate - bias[:3]))
            axis = (rate - bias[:3]) / size
            middle = rotation @ rotation_about(axis, 0.5 * h * size)
            gain = middle @ (force - bias[3:]) + [0.0, 0.0, -GRAVITY]
            place, velocity = place + h * velocity + 0.5 * h * h * gain, velocity + h * gain
            rotation = rotation @ rotation_about(axis, h * size)
    turn = gyros[-1] - bias[:3]
    np.testing.assert_allclose(rotation_from_quaternion(q[3:7]), rotation, atol=1e-9)
    np.testing.assert_allclose(q[:3], place - rotation @ arm, atol=1e-9)
    np.testing.assert_allclose(v[:3], rotation.T @ velocity - np.cross(turn, arm), atol=1e-7)
    np.testing.assert_allclose(v[3:6], turn)
    rate = (late - early) / 0.02
    np.testing.assert_allclose(v[6:], speeds + 0.004 * rate)
    np.testing.assert_allclose(q[7:], joints + 0.004 * speeds + 0.5 * 0.004**2 * rate)
