"""Joints outside the legs: they come back as a damped spring does, and arms swing against the legs."""

from __future__ import annotations

import math

import numpy as np
import pinocchio
import pytest

from surefoot.mechanics.robot import Robot, load_robot
from surefoot.motion.control.posture import Posture, leg_share, stretching


@pytest.fixture(scope="module")
def g1() -> Robot:
    return load_robot("g1")


def reach_ahead(robot: Robot, q: np.ndarray, side: str) -> float:
    """Return how far ahead of the base an arm's last link is [m]."""
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q)
    hand = [k for k, name in enumerate(robot.model.names) if side in name and "wrist" in name][-1]
    return float(data.oMi[hand].translation[0])


def test_arms_go_against_the_legs(g1: Robot) -> None:
    """With the left foot ahead, the left arm goes back and the right one ahead."""
    posture, still = Posture(g1, 10.0, 1.0), np.zeros(g1.model.nv)
    for lead, sense in ((0.1, -1.0), (-0.1, 1.0)):
        wanted = posture.accelerations(g1.nominal, still, lead)
        moved = pinocchio.integrate(g1.model, g1.nominal, 1e-4 * np.r_[np.zeros(6), wanted])
        left, right = (
            reach_ahead(g1, moved, side) - reach_ahead(g1, g1.nominal, side) for side in ("left", "right")
        )
        assert sense * left > 1e-5
        assert sense * right < -1e-5
        assert left == pytest.approx(-right, rel=0.05)
    assert np.count_nonzero(posture.swing) == 2
    np.testing.assert_array_equal(Posture(g1, 10.0, 0.0).swing, 0.0)


def test_a_joint_comes_back_as_a_critically_damped_spring_does(g1: Robot) -> None:
    """From rest and away by a: a (1 + w t) exp(-w t)."""
    frequency, dt = 8.0, 1e-4
    posture = Posture(g1, frequency, 0.0)
    q, v = g1.nominal.copy(), np.zeros(g1.model.nv)
    q[7:] += 0.1
    for _ in range(2000):
        v[6:] += dt * posture.accelerations(q, v)
        q[7:] += dt * v[6:]
    t = 2000 * dt
    left = 0.1 * (1.0 + frequency * t) * math.exp(-frequency * t)
    legs = ~posture.free
    assert legs.sum() == 12
    np.testing.assert_allclose((q[7:] - g1.nominal[7:])[posture.free], left, rtol=0.01)
    np.testing.assert_allclose((q[7:] - g1.nominal[7:])[legs], 0.1)  # the legs are not its affair
    posture.hold(q)
    np.testing.assert_allclose(posture.accelerations(q, np.zeros_like(v)), 0.0, atol=1e-12)


def test_legs_of_a_quadruped_are_all_but_its_trunk() -> None:
    go2 = load_robot("go2")
    assert leg_share(go2) == pytest.approx(1.0 - go2.model.inertias[1].mass / go2.mass)


def test_a_leg_straightened_by_its_rise_is_as_long_as_was_asked(g1: Robot) -> None:
    """A tenth more of the share is a tenth of a leg: thigh and shank, from the hip's second joint."""
    data = g1.model.createData()
    pinocchio.forwardKinematics(g1.model, data, pinocchio.neutral(g1.model))
    names = list(g1.model.names)
    hip, ankle = (
        next(k for k, name in enumerate(names) if name.startswith("left") and part in name)
        for part in ("hip_roll", "ankle_roll")
    )
    straight = np.linalg.norm(data.oMi[hip].translation - data.oMi[ankle].translation)
    whole = 10.0 * (stretching(g1, 1.0) - stretching(g1, 0.9))
    assert whole == pytest.approx(straight, rel=0.05)  # the joints are not quite in one line
    assert whole >= straight - 1e-9
    assert stretching(g1, 0.1) == 0.0  # its legs are longer already
