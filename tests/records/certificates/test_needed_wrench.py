"""What a motion needs against Pinocchio's dynamics, and distances to cones against linear least squares."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from scipy.optimize import nnls

import surefoot as sf
from surefoot.records.certificates.body_tree import body_places, body_tree
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.certificates.cone_distance import nearest_sum
from surefoot.records.certificates.frame_data import deviation, frame_data, window_of
from surefoot.records.certificates.torque_rows import add_rotors
from surefoot.records.certificates.touching_points import touching_points
from surefoot.records.certificates.window_kernels import frame_weights, needed_wrench
from surefoot.records.motions.motion import Motion


@pytest.mark.parametrize("name", ["g1", "go2", "talos"])
def test_bodies_are_where_pinocchio_has_them(name: str) -> None:
    robot = sf.load_robot(name)
    tree = body_tree(robot)
    rng = np.random.default_rng(0)
    q = np.array(
        [pinocchio.integrate(robot.model, robot.nominal, rng.normal(size=robot.model.nv)) for _ in range(5)]
    )
    turns, origins = body_places(robot, tree, q)
    for k in range(5):
        pinocchio.forwardKinematics(robot.model, robot.data, q[k])
        for b in range(len(tree.parent)):
            assert np.allclose(turns[k, b], robot.data.oMi[b + 1].rotation, atol=1e-12)
            assert np.allclose(origins[k, b], robot.data.oMi[b + 1].translation, atol=1e-12)


def test_needed_forces_and_torques_are_those_of_inverse_dynamics() -> None:
    """A smooth motion at 2 kHz, whose windows are so short that their means are values."""
    robot = sf.load_robot("g1")
    model, rate = robot.model, 2000.0
    rng = np.random.default_rng(1)
    rates, bends = 0.4 * rng.normal(size=model.nv), rng.normal(size=model.nv)
    t = np.arange(41) / rate
    q = np.array([pinocchio.integrate(model, robot.nominal, rates * s + 0.5 * bends * s * s) for s in t])
    settings = CertificateSettings(mean=1.0 / rate)
    data = frame_data(
        robot, Motion(robot, q, rate), touching_points(robot, 0.8), (0.3, 0.8), None, 5.0 / rate, settings
    )
    k = 20
    parts, wrench, torques = np.empty((len(data.model.tree.mass), 6)), np.empty(6), np.empty(robot.joints)
    needed_wrench(
        data.model.tree,
        data.model.motion,
        data.model.window,
        data.model.weights,
        k,
        1.0,
        parts,
        wrench,
        torques,
    )
    add_rotors(data.model.motion, data.model.motors, data.model.window, 1.0, k, torques)
    v = pinocchio.difference(model, q[k - 1], q[k + 1]) * rate / 2.0
    after, before = (pinocchio.difference(model, q[i], q[i + 1]) * rate for i in (k, k - 1))
    tau = pinocchio.rnea(model, robot.data, q[k], v, (after - before) * rate)
    pinocchio.computeCentroidalMomentumTimeVariation(model, robot.data, q[k], v, (after - before) * rate)
    expected = np.array(robot.data.dhg.vector)
    expected[2] += robot.mass * 9.81
    assert np.allclose(wrench, expected, atol=2e-2)
    assert np.allclose(torques, tau[6:], atol=2e-2)


def test_windows_weigh_all_frames_once() -> None:
    for rate in (29.97, 30.0, 50.0, 60.0, 120.0, 500.0):
        window = window_of(0.1, 1.0 / 30.0, 1.0 / rate)
        assert (window.length - window.mean) % 2 == 0
        weights = frame_weights(window)
        assert weights.sum() == pytest.approx(1.0)
        assert (weights >= 0.0).all()
        assert np.allclose(weights, weights[::-1])


def test_noise_is_measured_beneath_a_motion() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(600) / 30.0
    places = 0.1 * np.sin(2.0 * np.pi * 0.7 * t) + rng.normal(0.0, 2e-3, 600)
    assert deviation(np.diff(places)[:, None])[0] == pytest.approx(2e-3, rel=0.15)
    assert deviation(np.zeros((3, 2))).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("seed", range(20))
def test_distances_to_cones_lie_between_pyramids(seed: int) -> None:
    """Pyramids inside and around the cones bound the distance from above and below."""
    rng = np.random.default_rng(seed)
    count, d = int(rng.integers(1, 10)), int(rng.integers(6, 10))
    maps, mu = rng.normal(size=(count, 3, d)), rng.choice([0.0, 0.3, 0.8], size=count)
    b = rng.normal(size=d)
    r, forces, work = np.empty(d), np.empty((count, 3)), np.empty((count + d + 4, d))
    nearest_sum(maps, mu, count, d, b, r, forces, work)
    forces[mu == 0.0, :2] = 0.0
    assert (np.hypot(forces[:, 0], forces[:, 1]) <= mu * forces[:, 2] + 1e-12).all()
    share = np.linalg.norm(b - np.einsum("cid,ci->d", maps, forces))
    angles = 2.0 * np.pi * np.arange(48) / 48
    for reach, below in ((1.0, False), (1.0 / np.cos(np.pi / 48), True)):
        rays = np.stack([reach * np.cos(angles), reach * np.sin(angles), np.ones(48)])
        columns = [maps[c].T @ (rays * np.array([[mu[c]], [mu[c]], [1.0]])) for c in range(count)]
        distance = nnls(np.hstack(columns), b)[1]
        assert distance <= share + 1e-6 if below else share <= distance + 1e-6
