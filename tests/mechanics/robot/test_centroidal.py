from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import centroidal
from surefoot.mechanics.robot.jacobians import contact_jacobian
from tests.mechanics.robot.constraints import relative


def test_momentum_is_the_sum_over_links(case):
    """h link by link, each from its own velocity: no momentum matrix anywhere."""
    robot, q, v, _, _ = case
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, q, v)
    h = centroidal.momentum(robot, q, v)
    linear, angular, mass, first = np.zeros(3), np.zeros(3), 0.0, np.zeros(3)
    bodies = [(data.oMi[i], data.v[i], robot.model.inertias[i]) for i in range(1, robot.model.njoints)]
    for pose, _, body in bodies:
        mass, first = mass + body.mass, first + body.mass * pose.act(body.lever)
    com = first / mass
    for pose, twist, body in bodies:
        w = pose.rotation @ twist.angular
        speed = pose.rotation @ (twist.linear + np.cross(twist.angular, body.lever))
        linear += body.mass * speed
        spin = pose.rotation @ body.inertia @ pose.rotation.T @ w
        angular += spin + body.mass * np.cross(pose.act(body.lever) - com, speed)
    assert relative(h.com, com) < 1e-9
    assert abs(h.mass - mass) < 1e-9 * mass
    assert relative(h.vector, np.concatenate([linear, angular])) < 1e-9
    assert relative(centroidal.momentum_matrix(robot, q) @ v, h.vector) < 1e-9
    assert relative(h.com_velocity, linear / mass) < 1e-9


def test_bias_against_finite_differences(case):
    robot, q, v, _, _ = case
    step = 1e-6  # central: relative error about 1e-9
    ahead = centroidal.momentum_matrix(robot, pinocchio.integrate(robot.model, q, step * v)) @ v
    behind = centroidal.momentum_matrix(robot, pinocchio.integrate(robot.model, q, -step * v)) @ v
    assert relative(centroidal.momentum_bias(robot, q, v), (ahead - behind) / (2 * step)) < 2e-8


@pytest.mark.parametrize("name", ["go2", "anymal", "g1"])
@pytest.mark.parametrize("seed", range(5))
def test_momentum_changes_by_contact_wrenches_and_gravity_only(make, name, seed):
    """ABA with random torques and contact forces: the torques do not show in the momentum."""
    robot, rng = make.robot(name), np.random.default_rng(400 + seed)
    q, v = make.state(robot, rng)
    stance = make.stance(robot, q, rng)
    forces = 30.0 * rng.normal(size=stance.dim)
    torque = np.concatenate([np.zeros(6), 20.0 * rng.normal(size=robot.joints)])
    effort = torque + contact_jacobian(robot, q, stance).T @ forces
    acceleration = pinocchio.aba(robot.model, robot.data, q, v, effort)
    rate = centroidal.momentum_rate(robot, q, v, acceleration)
    assert relative(rate, centroidal.external_wrench(robot, q, stance, forces)) < 1e-9


def test_a_fixed_base_takes_up_the_rest(make):
    """For a bolted arm ḣ differs from gravity by the wrench in the bolts, which RNEA knows."""
    robot, rng = make.robot("panda"), np.random.default_rng(4)
    q, v = make.state(robot, rng)
    a = pinocchio.aba(robot.model, robot.data, q, v, 5.0 * rng.normal(size=robot.model.nv))
    pinocchio.rnea(robot.model, robot.data, q, v, a)
    pinocchio.updateGlobalPlacements(robot.model, robot.data)
    bolts = robot.data.oMi[1].act(robot.data.f[1])
    com = centroidal.momentum(robot, q, v).com
    mass = centroidal.momentum(robot, q, v).mass
    moment = bolts.angular - np.cross(com, bolts.linear)
    rate = centroidal.momentum_rate(robot, q, v, a)
    assert relative(rate, np.concatenate([bolts.linear - [0, 0, mass * 9.81], moment])) < 1e-9


@pytest.mark.parametrize("name", ["go2", "anymal", "g1"])
def test_block_structure(make, name):
    robot, rng = make.robot(name), np.random.default_rng(5)
    q, v = make.state(robot, rng)
    A, mass = centroidal.momentum_matrix(robot, q), robot.mass
    R = rotation_from_quaternion(q[3:7])
    assert relative(A[:3, :3], mass * R) < 1e-9
    assert np.abs(A[3:, :3]).max() < 1e-9 * np.abs(A).max()  # moving the base straight spins nothing
    T = centroidal.base_velocity_to_world_axes(robot, q)
    in_world = A @ np.linalg.inv(T)
    lever = robot.com(q) - q[:3]
    assert relative(in_world[:3, :3], mass * np.eye(3)) < 1e-9
    assert relative(in_world[:3, 3:6], -mass * np.cross(np.eye(3), lever).T @ -np.eye(3)) < 1e-9
    locked = centroidal.centroidal_inertia(robot, q)
    assert relative(in_world[3:, 3:6], locked[3:, 3:]) < 1e-9  # turning the base turns the locked robot
    assert relative(locked[:3, :3], mass * np.eye(3)) < 1e-9
    assert np.abs(locked[:3, 3:]).max() < 1e-9 * mass
    assert relative((T @ v)[:3], R @ v[:3]) < 1e-12


def test_base_velocity_for_zero_momentum(make):
    robot, rng = make.robot("go2"), np.random.default_rng(9)
    q, v = make.state(robot, rng)
    base = centroidal.base_velocity_for(robot, q, v[6:])
    assert np.abs(centroidal.momentum(robot, q, np.concatenate([base, v[6:]])).vector).max() < 1e-12
    wanted = rng.normal(size=6)
    base = centroidal.base_velocity_for(robot, q, v[6:], wanted)
    assert relative(centroidal.momentum(robot, q, np.concatenate([base, v[6:]])).vector, wanted) < 1e-9
    with pytest.raises(sf.ProblemError, match="panda has a fixed base"):
        centroidal.base_velocity_for(make.robot("panda"), make.robot("panda").nominal, np.zeros(9))
