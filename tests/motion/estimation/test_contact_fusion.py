"""Odds of contact from force, height, speed and plan: against SciPy's densities and a simulated observer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.motion.estimation.contact_fusion import (
    BANDWIDTHS,
    QUIET,
    ContactFusion,
    GroundLevel,
    TouchSettings,
    force_noise,
    observer_gain,
    quiet_bandwidth,
)
from surefoot.motion.estimation.detection_kernels import (
    LEAST_HEIGHT,
    LEAST_SPEED,
    MOST_FORCE,
    decide_contacts,
)
from surefoot.motion.estimation.foot_force_observer import FootForceObserver

UP = np.tile([0.0, 0.0, 1.0], (4, 1))


def test_odds_are_those_of_the_densities() -> None:
    random, n = np.random.default_rng(0), 200
    up = random.normal(size=(n, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    forces, velocities = 20.0 * random.normal(size=(n, 3)), 0.2 * random.normal(size=(n, 3))
    points, heights = 0.01 * random.normal(size=(n, 3)), 0.01 * random.normal(size=n)
    prior, deviations, felt = random.normal(size=n), 2.0 + random.random(n), random.random(n) < 0.5
    told, memory = np.where(random.random(n) < 0.2, ~felt, felt), np.array([np.zeros(n), prior, deviations])
    heavy, gap, clearance, still, swinging, hold, usual = 80.0, 0.005, 0.08, 0.05, 1.0, 0.5, 40.0
    scales = np.array([heavy, gap, clearance, still, swinging, hold, usual])
    before = random.random(n) < 0.5
    contact = before.copy()
    decide_contacts(forces, velocities, points, up, heights, felt, told, scales, memory, contact)
    f, v = np.maximum((forces * up).sum(axis=1), 0.0), (velocities * up).sum(axis=1)
    f = np.where(felt == told, f, usual * told)
    pushed = np.minimum(-np.log(heavy) - norm.logpdf(f, scale=deviations), MOST_FORCE)
    gaps = (points[:, 2] - heights) * up[:, 2]
    near = np.maximum(norm.logpdf(gaps, scale=gap) + np.log(clearance), LEAST_HEIGHT)
    stopped = np.maximum(norm.logpdf(v, scale=still) - norm.logpdf(v, scale=swinging), LEAST_SPEED)
    expected = prior + pushed + near + stopped
    np.testing.assert_allclose(memory[0], expected, atol=1e-12)
    np.testing.assert_array_equal(contact, expected > np.where(before, -hold, hold))
    assert 0.1 < contact.mean() < 0.9
    assert (contact & (expected < hold)).any()  # held on


@pytest.mark.parametrize("name", ["go2", "anymal_c"])
def test_noise_of_speeds_shows_in_forces_as_foretold(name: str) -> None:
    """A robot in free fall: what its detector takes for forces is noise of the joints' speeds alone."""
    robot, speed, dt = load_robot(name), 0.05, 1e-3
    bandwidth = quiet_bandwidth(robot, dt, speed)
    detector = FootForceObserver(robot, dt, bandwidth)
    random, q, found = np.random.default_rng(1), robot.nominal.copy(), []
    v = np.zeros(robot.model.nv)
    for k in range(1500):
        v[2] = -GRAVITY * dt * k
        v[6:] = speed * random.normal(size=robot.joints)
        detector.observe(q, v, UP)
        detector.applied(np.zeros(robot.joints))
        found.append(detector.forces[:, 2].copy())
    expected = observer_gain(bandwidth, dt) * force_noise(robot, speed)
    np.testing.assert_allclose(np.std(found[50:], axis=0), expected, rtol=0.15)
    share = robot.mass * GRAVITY / 4
    assert expected.max() <= QUIET * share * 1.001
    assert BANDWIDTHS[0] <= bandwidth <= BANDWIDTHS[1]
    assert bandwidth == BANDWIDTHS[1] or expected.max() > 0.99 * QUIET * share


def test_each_says_its_part() -> None:
    robot = load_robot("go2")
    fusion = ContactFusion(robot, TouchSettings(), np.full(4, 1.0), 0.05, mapped=True)
    share, none = robot.mass * GRAVITY / 4, np.zeros(4, dtype=bool)
    forces, velocities = np.zeros((4, 3)), np.zeros((4, 3))
    forces[:, 2] = share * np.array([1.0, 1.0, 0.0, 1.0])
    velocities[:, 2] = [0.0, -0.5, 0.0, 0.0]
    points, heights = np.zeros((4, 3)), np.full(4, 0.5)
    points[:, 2] = [0.5, 0.53, 0.5, 0.55]  # stands; false in its swing; hovers; on a stone that no map has
    felt = forces[:, 2] > 0.0
    seen = forces, velocities, points, UP, heights, felt, felt
    believed = fusion.scales, fusion.memory, fusion.contact
    fusion.expect(none, none)
    decide_contacts(*seen, *believed)
    assert fusion.contact.tolist() == [True, False, False, True]
    fusion.expect(~none, ~none)  # a foot that pushed before and is where it was
    decide_contacts(*seen, *believed)
    assert fusion.contact.tolist() == [True, False, True, True]
    fusion.reset()
    assert not fusion.contact.any()


def test_ground_without_a_map_is_the_plane_under_the_feet() -> None:
    random, slope = np.random.default_rng(2), SlopeTerrain(12.0)
    feet = random.normal(size=(4, 3))
    feet[:, 2] = slope.height(feet[:, :2])
    places = random.normal(size=(5, 3))
    mapped, sensed = GroundLevel(slope, feet), GroundLevel(None, feet)
    np.testing.assert_allclose(mapped.heights(places), slope.height(places[:, :2]))
    np.testing.assert_allclose(sensed.heights(places), slope.height(places[:, :2]), atol=1e-12)
    np.testing.assert_allclose(sensed.normal(), slope.normal(places[0, :2]), atol=1e-12)
    for k in range(4):
        sensed.stood(k, feet[k] + [0.0, 0.0, 0.1])
    np.testing.assert_allclose(sensed.heights(places), slope.height(places[:, :2]) + 0.1, atol=1e-12)
    row = GroundLevel(None, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2]]))  # two feet: level across them
    np.testing.assert_allclose(row.heights(np.array([[0.5, 3.0, 0.0]])), [0.1])
