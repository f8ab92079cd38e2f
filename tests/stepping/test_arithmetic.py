"""The compiled arithmetic of a rigid step against plain NumPy and Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.robot.dynamics import delassus_dense, mass_matrix
from surefoot.robot.jacobians import contact_jacobian
from surefoot.simulation.rigid import RigidWorld
from surefoot.spatial import rotation_from_normal, rotation_from_quaternion
from surefoot.stepping import arithmetic
from surefoot.terrain.frames import surface_frames


@pytest.fixture
def state():
    robot, rng = sf.load_robot("go2"), np.random.default_rng(0)
    q = pinocchio.integrate(robot.model, robot.nominal, 0.3 * rng.normal(size=18))
    world = RigidWorld(robot, sf.SlopeTerrain(10.0))
    world.reset(q, rng.normal(size=18))
    return world, rng


def spd(rng, n):
    A = rng.normal(size=(n, n))
    return A @ A.T + n * np.eye(n)


@pytest.mark.parametrize("n", [1, 6, 18, 35])
def test_factor_and_solves(n):
    rng = np.random.default_rng(n)
    M, x = spd(rng, n), rng.normal(size=n)
    L, y = np.zeros((n, n)), x.copy()
    arithmetic.factorise(np.triu(M), L)
    assert np.allclose(L, np.linalg.cholesky(M), rtol=1e-12, atol=1e-12)
    arithmetic.solve_lower(L, y)
    arithmetic.solve_upper(L, y)
    assert np.allclose(y, np.linalg.solve(M, x), rtol=1e-10)


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
    q, v = world.state()
    expected = contact_jacobian(world.robot, q, world.robot.stance(q, terrain=world.terrain))
    J = world.stepper.contacts(world.stepper.start(q, v)).J
    assert np.abs(J - expected).max() < 1e-12
    assert np.abs(world.contacts().velocities.ravel() - expected @ v).max() < 1e-12


def test_problem_is_the_delassus_operator_with_the_shifted_free_velocity(state):
    world, rng = state
    q, v = world.state()
    robot, dt, gaps = world.robot, 1e-3, np.array([0.003, -0.002, 0.001, 0.2])
    effort = rng.normal(size=18)
    M, J, bodies = (
        mass_matrix(robot, q),
        world.stepper.contacts(world.stepper.start(q)).J,
        world.stepper.bodies,
    )
    bodies.weigh(q)
    free = arithmetic.free_velocity(bodies.L, effort, v, dt)
    assert np.allclose(free, v + dt * np.linalg.solve(M, effort), rtol=1e-10)
    near = np.array([0, 1, 2])
    Y, G, g = arithmetic.assemble(J, bodies.L, v, free, gaps, near, dt, 0.0, 0.02, 0.2)
    whole = delassus_dense(robot, q, robot.stance(q, terrain=world.terrain))
    assert np.allclose(G, whole[:9, :9], rtol=1e-9, atol=1e-12)
    expected = (J @ free)[:9]
    expected[2::3] += np.array([1.0, 0.2, 1.0]) * gaps[:3] / dt
    assert np.allclose(g, expected, rtol=1e-10)
    impulses = rng.normal(size=9)
    after = arithmetic.apply_impulses(bodies.L, Y, impulses, free)
    assert np.allclose(after, free + np.linalg.solve(M, J[:9].T @ impulses), rtol=1e-9)


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
        _, _, g = arithmetic.assemble(J, L, v, v, np.array([gap]), near, 1e-3, 0.5, 0.02, 0.0)
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


def test_largest_magnitude():
    assert arithmetic.largest(np.zeros(0)) == 0.0
    assert arithmetic.largest(np.array([1.0, -3.0, 2.0])) == 3.0
    for bad in (np.nan, np.inf, -np.inf):
        assert arithmetic.largest(np.array([1.0, bad, 2.0])) == np.inf


def test_flight_of_a_robot_without_gravity_keeps_its_centre_on_course(state):
    """Momentum of a robot with waving legs over 0.2 s."""
    world, _ = state
    q, v = world.state()
    q[2] += 5.0
    world.reset(q, v)
    R = rotation_from_quaternion(q[3:7])
    assert np.linalg.det(R) == pytest.approx(1.0)
    from surefoot.robot.centroidal import momentum

    before = momentum(world.robot, q, v)
    for _ in range(200):
        world.step(np.zeros(12))
    after = momentum(world.robot, *world.state())
    fall = np.array([0, 0, -9.81 * 0.2 * world.robot.mass])
    assert np.abs(after.linear - before.linear - fall).max() < 1e-7 * np.abs(fall).max()
    assert np.abs(after.angular - before.angular).max() < 1e-7
