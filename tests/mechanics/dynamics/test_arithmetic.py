"""The compiled arithmetic of a rigid step against plain NumPy and Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.robot.jacobians import contact_jacobian
from surefoot.mechanics.terrain.frames import surface_frames
from surefoot.worlds.rigid.rigid_world import RigidWorld


@pytest.fixture
def state():
    robot, rng = sf.load_robot("go2"), np.random.default_rng(0)
    q = pinocchio.integrate(robot.model, robot.nominal, 0.3 * rng.normal(size=18))
    world = RigidWorld(robot, sf.SlopeTerrain(10.0))
    world.reset(q, rng.normal(size=18))
    return world, rng


def test_surface_frames_are_those_of_single_normals():
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(50, 3))
    normals[:6] = np.vstack([np.eye(3), -np.eye(3)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frames = np.zeros((50, 3, 3))
    surface_frames(normals, frames)
    expected = np.array([rotation_from_normal(n) for n in normals])
    assert np.allclose(frames, expected, atol=1e-12)


def test_contact_rows_are_the_contact_jacobian(state):
    world, _ = state
    q, v = world.q_v()
    expected = contact_jacobian(world.robot, q, world.robot.stance(q, terrain=world.terrain))
    J = world.stepper.contacts(world.stepper.start(q, v)).J
    assert np.abs(J - expected).max() < 1e-12
    assert np.abs(world.contacts().velocities.ravel() - expected @ v).max() < 1e-12


def test_restitution_enters_only_where_the_gap_closes_fast():
    J, L = np.eye(3), np.eye(3)
    near = np.array([0])
    for speed, gap, expected in (
        (-2.0, 0.0, -1.0),
        (-0.01, 0.0, 0.0),
        (-2.0, 0.01, 10.0),
        (-2.0, 0.001, -1.0),
    ):
        v = np.array([0.0, 0.0, speed])
        _, _, g = arithmetic.assemble(J, L, v, v, np.array([gap]), near, 1e-3, np.array([0.5]), 0.02, 0.0)
        assert g[2] - speed == pytest.approx(expected)


def test_near_ground_takes_what_may_touch():
    J = np.vstack([np.eye(3)] * 3)
    v = np.array([0.0, 0.0, -3.0])
    gaps = np.array([0.0, 0.0035, 0.02])
    assert list(arithmetic.near_ground(J, v, v, gaps, 1e-3, 1e-3)) == [0, 1]
    assert arithmetic.near_ground(J, -v, -v, gaps, 1e-3, 1e-3).size == 0  # all on their way up
    assert list(arithmetic.near_ground(J, v, -v, gaps, 1e-3, 1e-3)) == [0, 1]  # pushed up, still counted


def test_contacts_that_the_others_push_down_join_in():
    velocities = np.array([[0, 0, 1.0], [0, 0, -3.0], [0, 0, -3.0]])
    more = arithmetic.with_missed(velocities, np.array([0.0, 0.002, 0.02]), 1e-3, np.array([0]))
    assert list(more) == [0, 1]
