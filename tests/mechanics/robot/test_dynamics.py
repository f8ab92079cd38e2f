from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.mechanics.robot import dynamics
from surefoot.mechanics.robot.jacobians import (
    Baumgarte,
    attach,
    contact_drift,
    contact_error,
    contact_jacobian,
)
from tests.mechanics.robot.constraints import constraints, relative

ROBOTS = ("go2", "anymal", "g1", "panda")


def pinocchio_answer(robot, q, v, tau, points):
    """Acceleration and contact forces of pinocchio.constraintDynamics."""
    data, models, datas = constraints(robot, q, points)
    pinocchio.initConstraintDynamics(robot.model, data, models, datas)
    settings = pinocchio.ProximalSettings(1e-12, 0.0, 1)
    a = np.array(pinocchio.constraintDynamics(robot.model, data, q, v, tau, models, datas, settings))
    forces = [d.contact_force.vector[: p.dim] for d, p in zip(datas, points, strict=True)]
    return a, np.concatenate(forces)


def spatial_instead_of_classical(robot, q, v, points):
    """Pinocchio holds the spatial acceleration of a 6-D contact, the classical one of a 3-D contact:
    return the classical acceleration (contact axes) that its 6-D contacts get."""
    pinocchio.forwardKinematics(robot.model, robot.data, q, v)
    pinocchio.updateFramePlacements(robot.model, robot.data)
    out = []
    for point in points:
        pose, rows = robot.data.oMf[point.frame], np.zeros(point.dim)
        if point.dim == 6:
            twist = pinocchio.getFrameVelocity(
                robot.model, robot.data, point.frame, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            speed = twist.linear + np.cross(twist.angular, pose.rotation @ point.offset)
            rows[:3] = point.rotation_world_contact.T @ np.cross(twist.angular, speed)
        out.append(rows)
    return np.concatenate(out)


def test_constrained_dynamics_is_pinocchios(case):
    robot, q, v, stance, rng = case
    points = attach(robot, q, stance)
    tau = 10.0 * rng.normal(size=robot.model.nv)
    acceleration, forces = pinocchio_answer(robot, q, v, tau, points)
    wanted = spatial_instead_of_classical(robot, q, v, points)
    ours = dynamics.constrained_dynamics(robot, q, v, tau, stance, contact_acceleration=wanted)
    assert ours.rank == stance.dim
    assert relative(ours.acceleration, acceleration) < 1e-9
    assert relative(ours.forces, forces) < 1e-9


def test_contacts_do_not_accelerate_and_the_equation_of_motion_holds(case):
    robot, q, v, stance, rng = case
    tau = rng.normal(size=robot.joints)
    motion = dynamics.constrained_dynamics(robot, q, v, tau, stance)
    J = contact_jacobian(robot, q, stance)
    drift = contact_drift(robot, q, v, stance)
    assert np.abs(J @ motion.acceleration + drift).max() < 1e-9 * max(1.0, np.abs(drift).max())
    needed = pinocchio.rnea(robot.model, robot.data, q, v, motion.acceleration)
    given = dynamics.generalised_torque(robot, tau) + J.T @ motion.forces
    assert relative(given, needed) < 1e-9


def test_free_robot_follows_aba(case):
    robot, q, v, _, rng = case
    tau = rng.normal(size=robot.model.nv)
    free = dynamics.constrained_dynamics(robot, q, v, tau, sf.Stance([]))
    assert relative(free.acceleration, pinocchio.aba(robot.model, robot.data, q, v, tau)) < 1e-9
    assert free.forces.size == 0


def redundant(make, name):
    """A stance whose Jacobian loses rank: eight corners of two soles, or a foot touched at three points."""
    robot = make.robot(name)
    if name == "g1":
        return robot, robot.stance().points(), 12
    base = robot.stance()
    copies = [
        sf.PointContact(base.positions[0] + [dx, 0, 0], name=base.names[0]) for dx in (0.0, 0.02, -0.02)
    ]
    return robot, sf.Stance([*base.contacts[1:], *copies]), None


@pytest.mark.parametrize("name", ["g1", "go2"])
def test_rank_deficient_contacts(make, name):
    robot, stance, rank = redundant(make, name)
    q, v = robot.nominal, np.zeros(robot.model.nv)
    J = contact_jacobian(robot, q, stance)
    expected = np.linalg.matrix_rank(J, tol=1e-9)
    exact = dynamics.constrained_dynamics(robot, q, v, np.zeros(robot.joints), stance)
    assert exact.rank == expected < stance.dim
    assert rank is None or rank == expected
    assert np.abs(J @ exact.acceleration).max() < 1e-9
    unmoved = exact.forces - np.linalg.pinv(J.T) @ (
        J.T @ exact.forces
    )  # least norm: nothing in the null space
    assert np.abs(unmoved).max() < 1e-7 * np.abs(exact.forces).max()
    damped = dynamics.constrained_dynamics(robot, q, v, np.zeros(robot.joints), stance, damping=1e-9)
    assert relative(damped.acceleration, exact.acceleration) < 1e-5
    coarse = dynamics.constrained_dynamics(robot, q, v, np.zeros(robot.joints), stance, damping=1e-2)
    gap = J @ coarse.acceleration + 1e-2 * coarse.forces  # J v̇ + ε f = γ with f on the robot
    assert np.abs(gap).max() < 1e-9 * np.abs(coarse.forces).max()


def hand_on_wall(make):
    """G1 on two soles, a hand against a wall that faces it."""
    robot = make.robot("g1")
    feet = robot.stance()
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.nominal)
    hand = data.oMf[robot.model.getFrameId("right_rubber_hand")].translation
    wall = sf.PointContact(hand + np.array([0.05, 0, 0]), normal=[-1, 0, 0], name="right_rubber_hand")
    return robot, robot.nominal, sf.Stance([*feet.contacts, wall])


@pytest.fixture(params=["go2-standing", "g1-standing", "g1-wall", *(f"{r}-random" for r in ROBOTS)])
def touching(request, make):
    name, kind = request.param.split("-")
    robot = make.robot(name)
    if kind == "wall":
        return hand_on_wall(make)
    if kind == "standing":
        return robot, robot.nominal, robot.stance()
    rng = np.random.default_rng(7)
    q, _ = make.state(robot, rng)
    return robot, q, make.stance(robot, q, rng)


def test_delassus_is_that_of_pinocchios_factors(touching):
    robot, q, stance = touching
    dense = dynamics.delassus_dense(robot, q, stance)
    scale = np.abs(dense).max()
    assert np.array_equal(dense, dense.T)
    assert np.linalg.eigvalsh(dense).min() > -1e-12 * scale
    data, models, datas = constraints(robot, q, attach(robot, q, stance))
    pinocchio.crba(robot.model, data, q, pinocchio.Convention.WORLD)
    for model, one in zip(models, datas, strict=True):
        model.calc(robot.model, data, one)  # the factorisation reads the placements, unasked for
    factors = pinocchio.ContactCholeskyDecomposition(robot.model, data, models, datas)
    factors.compute(robot.model, data, models, datas, 0.0)
    assert np.abs(factors.getInverseOperationalSpaceInertiaMatrix() - dense).max() < 1e-10 * scale


def test_baumgarte_brings_a_displaced_contact_back(make):
    """A standing Go2 whose anchors were moved by 5 mm returns to them like (1 + ω t) exp(-ω t)."""
    robot = make.robot("go2")
    q, v = robot.nominal.copy(), np.zeros(18)
    anchored = attach(robot, q, robot.stance())
    shifted = [replace(p, position=p.position + np.array([0.005, 0.0, 0.0])) for p in anchored]
    start = contact_error(robot, q, shifted)
    pull, dt = Baumgarte(20.0), 5e-4
    for _ in range(200):
        J = contact_jacobian(robot, q, shifted)
        wanted = pull.acceleration(J @ v, contact_error(robot, q, shifted))
        motion = dynamics.constrained_dynamics(
            robot, q, v, np.zeros(12), shifted, contact_acceleration=wanted
        )
        v = v + dt * motion.acceleration
        q = pinocchio.integrate(robot.model, q, dt * v)
    t = 200 * dt
    expected = (1.0 + 20.0 * t) * np.exp(-20.0 * t)
    assert np.allclose(contact_error(robot, q, shifted)[::3] / start[::3], expected, rtol=0.02)


def test_bad_input(make):
    robot = make.robot("go2")
    q, v = robot.nominal, np.zeros(18)
    with pytest.raises(sf.ProblemError, match=r"torque must have shape \(12,\) or \(18,\), got \(5,\)"):
        dynamics.constrained_dynamics(robot, q, v, np.zeros(5), robot.stance())
    with pytest.raises(sf.ProblemError, match="damping"):
        dynamics.constrained_dynamics(robot, q, v, np.zeros(12), robot.stance(), damping=-1.0)
