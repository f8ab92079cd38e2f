"""Motion between impulses: its order, its invariants, and against other integrators."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.mechanics.dynamics import free_motion as rules
from surefoot.mechanics.dynamics.free_motion import ERROR, STAGES, FreeMotion
from surefoot.mechanics.robot.centroidal import momentum
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.mechanics.dynamics.test_derivative import paired_arms


def thrown(robot, seed: int, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A pose 6 m up, and joint velocities of standard deviation `speed` [rad/s]."""
    rng = np.random.default_rng(seed)
    turn = np.concatenate([np.zeros(3), rng.normal(size=3), 0.3 * rng.normal(size=robot.joints)])
    q = pinocchio.integrate(robot.model, robot.nominal, turn)
    q[2] = 6.0
    return q, np.concatenate([rng.normal(size=6), speed * rng.normal(size=robot.joints)])


def whirl(robot, q, v) -> tuple[np.ndarray, float]:
    """Angular momentum and kinetic energy about the centre of mass; the fall is in neither."""
    h = momentum(robot, q, v)
    kinetic = pinocchio.computeKineticEnergy(robot.model, robot.data, q, v)
    return h.angular, kinetic - 0.5 * h.linear @ h.linear / robot.mass


@pytest.mark.parametrize(
    ("name", "seed"), [(n, s) for n in ("go2", "g1", "anymal_c", "solo12") for s in range(2)] + [("g1", 2)]
)
@pytest.mark.sampled(2)
def test_limp_robot_keeps_momentum_and_energy(name, seed):
    """Joint speeds of 15 rad/s, 1 ms, 0.5 s; measured: both to 3e-8 (semi-implicit Euler: 43 %, 14 %)."""
    robot = sf.load_robot(name)
    q, v = thrown(robot, seed, 15.0)
    world = RigidWorld(robot)
    world.reset(q, v)
    (spin, kinetic), off = whirl(robot, q, v), np.zeros((50, 2))
    for row in off:
        for _ in range(10):
            world.step(np.zeros(robot.joints))
        now = whirl(robot, *world.q_v())
        row[:] = np.linalg.norm(now[0] - spin) / np.linalg.norm(spin), abs(now[1] / kinetic - 1.0)
    assert off[:, 0].max() < 1e-6
    assert off[:, 1].max() < 1e-6
    fall = momentum(robot, *world.q_v()).linear - momentum(robot, q, v).linear
    weight = np.array([0.0, 0.0, 9.81 * robot.mass])
    assert np.abs(fall + 0.5 * weight).max() < 1e-6 * np.abs(fall).max()


def test_torques_in_the_air_change_energy_by_their_work_and_no_momentum():
    robot = sf.load_robot("go2")
    world, rng, work = RigidWorld(robot), np.random.default_rng(5), 0.0
    q, v = thrown(robot, 5, 5.0)
    world.reset(q, v)
    start, spin = world.energy(), whirl(robot, q, v)[0]
    for _ in range(200):
        before, torques = world.q_v()[0], 5.0 * rng.normal(size=12)
        world.step(torques)
        work += torques @ (world.q_v()[0] - before)[7:]
    assert abs(work) > 1.0
    assert world.energy() - start == pytest.approx(work, abs=1e-6 * start)
    assert np.abs(whirl(robot, *world.q_v())[0] - spin).max() < 1e-6 * np.linalg.norm(spin)


def test_pair_is_of_fifth_order():
    """Single pieces of given length; the sums that order five needs hold in the tableau too."""
    assert STAGES[6].sum() == pytest.approx(1.0)
    assert ERROR.sum() == pytest.approx(0.0, abs=1e-15)
    robot = sf.load_robot("go2")
    start, none, ends = thrown(robot, 2, 4.0), np.zeros(18), []
    motion = FreeMotion(robot.model, True)
    for pieces in (4, 8, 16, 128):
        q, v = start
        for _ in range(pieces):
            _, q, v = motion._piece(q, v, 0.08 / pieces, motion.acceleration(q, v, none), none)
        ends.append(np.concatenate([q, v]))
    errors = [np.abs(end - ends[-1]).max() for end in ends[:3]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 4.5) & (orders < 6.5))


@pytest.mark.parametrize("speed", [1e-3, 0.02, 0.3, 1.0])
def test_cheap_ways_keep_the_tolerance(speed, monkeypatch):
    """Constant and even accelerations against the pair; the second call goes on where the first ended."""
    robot = sf.load_robot("go2")
    q, v = thrown(robot, 3, 1.0)
    cheap, pair = FreeMotion(robot.model, True), FreeMotion(robot.model, True)
    for motion in (cheap, pair):
        motion.model = robot.model.copy()
        motion.model.gravity.setZero()
    here = there = (q, speed * v, None)
    for _ in range(2):
        here = cheap.advance(here[0], here[1], 5e-4, rate=here[2])
    monkeypatch.setattr(rules, "TOLERANCE", 1e-15)
    monkeypatch.setattr(rules, "PIECES", 5000)
    for _ in range(2):
        there = pair.advance(there[0], there[1], 5e-4, rate=there[2])
    assert np.abs(here[1] - there[1]).max() < 3e-8 * np.abs(speed * v).max()
    assert np.abs(here[0] - there[0]).max() < 3e-8 * np.abs(speed * v).max()


def test_ball_joints_move_as_rotations():
    """Tumbling bodies on a ball joint: Pinocchio's own derivative of q ⊕ ξ stands in for the series."""
    model = paired_arms().model
    model.gravity.setZero()
    data, motion = model.createData(), FreeMotion(model, True)
    q, v = pinocchio.neutral(model), 4.0 * np.random.default_rng(0).normal(size=model.nv)

    def kept():
        h = pinocchio.computeCentroidalMomentum(model, data, q, v)
        return np.append(h.np, pinocchio.computeKineticEnergy(model, data, q, v))

    start, rate = kept(), None
    for _ in range(200):
        q, v, rate = motion.advance(q, v, 2e-3, rate=rate)
    assert np.abs(kept() - start).max() < 1e-6 * np.abs(start).max()


@pytest.mark.parametrize("speed", [1e6, 1e200, np.nan, np.inf])
def test_a_motion_that_cannot_be_resolved_ends(speed):
    robot = sf.load_robot("go2")
    assert FreeMotion(robot.model, True).advance(robot.nominal, np.full(18, speed), 1e-3) is None
