from __future__ import annotations

import json

import numpy as np
import pinocchio as pin
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.statics.allocation import ExactAllocation
from surefoot.motion.control.controller import RobotState
from surefoot.motion.standing.stand_state import StandState
from surefoot.motion.standing.standing_controller import StandingController, default_normal_bounds
from surefoot.motion.standing.standing_kernels import foot_impedance, pd_wrench
from surefoot.motion.standing.standing_plan import Lift, StandingPlan


def standing(name: str = "go2", mu: float = 0.6, lifts: tuple[Lift, ...] = (), **options: object):
    robot, terrain = sf.load_robot(name), sf.FlatTerrain()
    q = sf.place(robot, terrain)
    plan = StandingPlan(robot, terrain, q, lifts)
    return robot, q, StandingController(robot, plan, terrain, q, mu, **options)  # type: ignore[arg-type]


def random_state(robot: sf.Robot, q: np.ndarray, rng: np.random.Generator, size: float = 0.1):
    return pin.integrate(robot.model, q, size * rng.normal(size=robot.model.nv)), size * rng.normal(
        size=robot.model.nv
    )


FEET = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]


def test_symmetric_stance_shares_the_weight() -> None:
    """The textbook case: each leg m g / 4, tangential near zero, inside the cone."""
    stance = sf.Stance([sf.PointContact(p, mu=0.6) for p in FEET])
    mass = 15.0
    A = stance.grasp_map(about=[0.0, 0.0, 0.3])
    wrench = np.array([0.0, 0.0, mass * GRAVITY, 0.0, 0.0, 0.0])
    weights = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    allocation = ExactAllocation(np.full(4, 0.6), weights, 1e-4)
    forces = allocation.share(A, wrench, np.zeros(4), np.full(4, 250.0))
    np.testing.assert_allclose(forces[:, 2], mass * GRAVITY / 4, rtol=1e-4)
    np.testing.assert_allclose(forces[:, :2], 0.0, atol=1e-3)
    assert np.all(sf.FrictionCone(0.6).contains(forces))


def test_command_balances_the_robot_in_pinocchio() -> None:
    """At rest the torques and forces of the command leave no acceleration: M a = 0 by ABA with them."""
    for name in ("go2", "anymal_c", "solo12"):
        robot, q, controller = standing(name)
        command = controller.step(RobotState(q, np.zeros(robot.model.nv), 0.0))
        forces = [pin.Force.Zero() for _ in range(robot.model.njoints)]
        pin.forwardKinematics(robot.model, robot.data, q)
        stance = robot.stance(q)
        for foot, contact, f in zip(robot.feet, stance, command.forces, strict=True):
            joint = robot.model.frames[foot.frame].parentJoint
            world = contact.rotation_world_contact @ f
            wrench = pin.Force(world, np.cross(contact.position, world))
            forces[joint] += robot.data.oMi[joint].actInv(wrench)
        torque = np.concatenate([np.zeros(6), command.torques])
        a = pin.aba(robot.model, robot.data, q, np.zeros(robot.model.nv), torque, forces)
        # what is left is the force weight's bias, a share of g
        assert np.abs(a[:6]).max() < 5e-3 * GRAVITY
        assert command.attained
        assert (np.abs(command.torques) < robot.effort_limits).all()


def test_forces_stay_inside_every_cone_and_bound_whatever_the_state() -> None:
    robot, q, controller = standing(mu=0.3)
    rng = np.random.default_rng(1)
    low, high = controller.normal_min, controller.normal_max
    impossible = 0
    for _ in range(200):
        command = controller.step(RobotState(*random_state(robot, q, rng, 0.5), 0.0))
        assert np.all(sf.FrictionCone(0.3).margin(command.forces) > -1e-9)
        assert np.all(command.forces[:, 2] >= low - 1e-9)
        assert np.all(command.forces[:, 2] <= high + 1e-9)
        assert np.all(np.abs(command.torques) <= robot.effort_limits)
        assert np.isfinite(command.torques).all()
        impossible += not command.attained
    assert impossible > 20  # such states ask for what the ground cannot give, and are flagged


def test_lifted_foot_gets_exactly_zero_force() -> None:
    robot, q, controller = standing(lifts=(Lift("FL", 1.0, 2.0),))
    command = controller.step(RobotState(q, np.zeros(robot.model.nv), 1.5))
    assert np.all(command.forces[0] == 0.0)
    np.testing.assert_array_equal(command.active, [False, True, True, True])
    assert np.all(command.forces[1:, 2] > 1.0)


def test_light_robots_get_a_smaller_least_force() -> None:
    low, high = default_normal_bounds(sf.load_robot("go2"))
    assert low == 10.0
    assert high == pytest.approx(1.5 * 16.085 * GRAVITY, rel=1e-3)
    low, _ = default_normal_bounds(sf.load_robot("solo12"))
    assert 4 * low < 0.5 * sf.load_robot("solo12").mass * GRAVITY


@pytest.mark.long
def test_integral_takes_up_an_unknown_load_and_is_bounded() -> None:
    robot, q, controller = standing()
    low = q.copy()
    low[2] -= 0.01
    v = np.zeros(robot.model.nv)
    first = controller.step(RobotState(low, v, 0.0)).wrench_desired[2]
    for _ in range(20_000):
        last = controller.step(RobotState(low, v, 0.0)).wrench_desired[2]
    assert last > first + 10.0
    assert last - first <= 0.6 * robot.mass * GRAVITY + 1e-6
    controller.reset()
    assert controller.step(RobotState(low, v, 0.0)).wrench_desired[2] == pytest.approx(first)


# the state as a value


def commands(controller: StandingController, states: list[RobotState]) -> list[np.ndarray]:
    rows = []
    for state in states:
        c = controller.step(state)
        rows.append(np.concatenate([c.torques, c.forces.ravel(), c.wrench_desired, c.wrench_error]))
    return rows


def disturbed(robot: sf.Robot, q: np.ndarray) -> list[RobotState]:
    """States over a lift of FL from 0.6 to 0.9 s, some of which ask for more than nine tenths of friction."""
    rng = np.random.default_rng(3)
    return [RobotState(*random_state(robot, q, rng, 0.05), 0.005 * k) for k in range(240)]


@pytest.mark.parametrize("at", [0, 1, 60, 119, 121, 170])
@pytest.mark.parametrize("written", [False, True])
@pytest.mark.sampled(3)
def test_a_stand_that_is_resumed_goes_on_to_the_last_bit(at: int, written: bool) -> None:
    lifts = (Lift("FL", 0.6, 0.9),)
    robot, q, first = standing(lifts=lifts)
    states = disturbed(robot, q)
    commands(first, states[:at])
    state = first.state
    kept = first.state
    want = commands(first, states[at:])
    assert state == kept  # a copy: going on changes nothing in it
    assert (first.state == state) is (at == len(states))
    if written:
        arrays, facts = state.to_arrays()
        state = StandState.from_arrays(arrays, json.loads(json.dumps(facts)))
        assert state == kept
    *_, other = standing(lifts=lifts)
    commands(other, states[100:110])  # a past of its own, which is forgotten
    for _ in range(2):
        other.resume(state)
        assert other.state == kept
        np.testing.assert_array_equal(commands(other, states[at:]), want)


def test_resuming_nothing_is_the_beginning_and_a_blind_step_changes_nothing() -> None:
    robot, q, controller = standing()
    states = disturbed(robot, q)[:40]
    want = commands(controller, states)
    controller.resume(None)
    np.testing.assert_array_equal(commands(controller, states[:20]), want[:20])
    before = controller.state
    controller.step(RobotState(np.full(robot.model.nq, np.nan), states[0].v, 0.0))
    assert controller.state == before
    np.testing.assert_array_equal(commands(controller, states[20:]), want[20:])
    assert controller.state != before


def test_a_state_of_another_robot_is_refused_and_changes_nothing() -> None:
    robot, q, controller = standing()
    want = commands(controller, disturbed(robot, q)[:30])[20:]
    controller.reset()
    commands(controller, disturbed(robot, q)[:20])
    for state in (standing("g1")[2].state, StandState(np.zeros(6))):
        with pytest.raises(ProblemError, match=r"of 4 contact points, got one of (8|0)"):
            controller.resume(state)
    np.testing.assert_array_equal(commands(controller, disturbed(robot, q)[20:30]), want)


# kernels against plain NumPy and Pinocchio


def test_the_grasp_map_of_a_command_is_that_of_its_stance() -> None:
    robot, q, controller = standing()
    rng = np.random.default_rng(2)
    for _ in range(5):
        state, v = random_state(robot, q, rng)
        command = controller.step(RobotState(state, v, 0.0))
        np.testing.assert_allclose(
            command.grasp_map, robot.stance(state).grasp_map(robot.com(state)), atol=1e-12
        )


def test_the_wanted_wrench_is_that_of_a_critically_damped_rigid_body() -> None:
    rng = np.random.default_rng(4)
    now, reference = (pin.exp3(0.4 * rng.normal(size=3)) for _ in range(2))
    q, v, place, speed, change, integral = (rng.normal(size=size) for size in (19, 18, 3, 3, 3, 6))
    half = rng.normal(size=(3, 3))
    inertia, (mass, omega, turn) = half @ half.T + np.eye(3), (12.0, 7.0, 9.0)
    wrench, pull = pd_wrench(
        now, reference, q, v, place, speed, change, inertia, mass, omega, turn, GRAVITY, integral
    )
    world = now @ inertia @ now.T
    miss = pin.log3(reference @ now.T)
    stiff = np.concatenate([mass * omega**2 * (place - q[:3]), turn**2 * world @ miss])
    force = mass * (2 * omega * (speed - now @ v[:3]) + change + [0.0, 0.0, GRAVITY])
    moment = -2 * turn * world @ now @ v[3:6]
    np.testing.assert_allclose(pull, stiff, rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(wrench, stiff + integral + [*force, *moment], rtol=1e-12, atol=1e-10)


def test_a_lifted_foot_answers_as_a_unit_mass_on_a_critically_damped_spring() -> None:
    """By Pinocchio's Jacobian and mass matrix, in NumPy; no entry below the diagonal of M is read."""
    robot, q, _ = standing()
    rng = np.random.default_rng(5)
    for foot in robot.feet:
        state, v = random_state(robot, q, rng, 0.3)
        miss, velocity = 0.02 * rng.normal(size=3), rng.normal(size=3)
        M = np.triu(pin.crba(robot.model, robot.data, state))
        J = pin.computeJointJacobians(robot.model, robot.data, state)
        pin.updateFramePlacements(robot.model, robot.data)
        place = robot.data.oMf[foot.frame].act(foot.centre)
        rows = J[:3] - pin.skew(place) @ J[3:]
        support = robot.contact_points.foot_support[robot.feet.index(foot)]
        rows = np.where(support, rows, 0.0)
        legs = np.flatnonzero(support[6:]) + 6
        own = (M + np.triu(M, 1).T)[np.ix_(legs, legs)]
        mobility = rows[:, legs] @ np.linalg.inv(own) @ rows[:, legs].T
        mobility += 1e-3 * np.trace(mobility) * np.eye(3)
        want = np.zeros(12)
        force = np.linalg.solve(mobility, 30.0**2 * miss + 60.0 * (velocity - rows @ v))
        want[legs - 6] = rows[:, legs].T @ force
        got = foot_impedance(np.ascontiguousarray(J), support, M, v, place, miss, velocity, 30.0)
        np.testing.assert_allclose(got, want, rtol=1e-9, atol=1e-9)


# margin to the cones, and states that no command can be computed for


def test_forces_use_the_same_share_of_every_foots_friction() -> None:
    """A slope of 20 degrees takes 61 % of friction 0.6; a foot with little weight on it takes no more."""
    robot, terrain = sf.load_robot("go2"), sf.SlopeTerrain(20.0)
    q = sf.place(robot, terrain)
    plan = StandingPlan(robot, terrain, q, [Lift("FL", 1.0, 2.0)])
    controller = StandingController(robot, plan, terrain, q, 0.6)
    v = np.zeros(robot.model.nv)
    late = q.copy()
    late[:3] = plan.at(0.97).position  # the weight has moved, FL is about to leave
    for _ in range(3):
        command = controller.step(RobotState(late, v, 0.99))
    use = np.hypot(command.forces[:, 0], command.forces[:, 1]) / (0.6 * command.forces[:, 2])
    assert command.attained
    assert command.forces[0, 2] < 0.15 * command.forces[:, 2].sum()
    np.testing.assert_allclose(use, np.tan(np.radians(20.0)) / 0.6, rtol=0.03)


def test_a_tenth_of_the_friction_is_kept_as_long_as_the_rest_gives_the_wrench() -> None:
    weights = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
    mu = np.full(4, 0.6)
    allocation = ExactAllocation(mu, weights, 1e-3)
    A = sf.Stance([sf.PointContact(p) for p in FEET]).grasp_map(about=[0.0, 0.0, 0.3])
    low, high = np.full(4, 5.0), np.full(4, 250.0)
    for friction, most in ((0.3, 0.51), (0.5, 0.85), (0.53, 0.9), (0.58, 1.0), (0.9, 1.0)):
        wrench = np.array([friction * 160.0, 0.0, 160.0, 0.0, 0.0, 0.0])
        for _ in range(3):
            forces = allocation.share(A, wrench, low, high)
        use = np.hypot(forces[:, 0], forces[:, 1]) / (0.6 * forces[:, 2])
        assert use.max() <= most + 1e-6, friction
        left = np.linalg.norm(np.sqrt(weights) * (A @ forces.ravel() - wrench))
        assert (left <= 5e-3 * np.linalg.norm(np.sqrt(weights) * wrench)) == (friction < 0.6)
