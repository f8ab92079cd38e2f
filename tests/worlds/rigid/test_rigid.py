"""The rigid world against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain.terrain import Terrain
from surefoot.worlds.rigid.bodies import ball, box
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.moving import advance, lifted
from tests.worlds.rigid.rigid_runs import NONE, on_slope, run


def tumbled(body, q, v, seconds):
    """A free body by Runge-Kutta in the world's axes, apart from Pinocchio's integration."""
    inertia = np.array(body.model.inertias[1].inertia)
    x = q[:3] + v[:3] * seconds - [0, 0, 0.5 * GRAVITY * seconds**2]  # starts level: body axes = world axes

    def rate(y):
        quaternion, w = y[:4], y[4:]
        a, b, c, s = quaternion
        cross = np.array([[s, -c, b], [c, s, -a], [-b, a, s], [-a, -b, -c]])
        return np.concatenate([0.5 * cross @ w, np.linalg.solve(inertia, -np.cross(w, inertia @ w))])

    y, h = np.concatenate([q[3:7], v[3:]]), 5e-4
    for _ in range(round(seconds / h)):
        k1 = rate(y)
        k2 = rate(y + 0.5 * h * k1)
        k3 = rate(y + 0.5 * h * k2)
        k4 = rate(y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return np.concatenate([x, y[:4] / np.linalg.norm(y[:4])])


@pytest.mark.parametrize("e", [0.0, 0.3, 0.7, 1.0])
def test_ball_bounces_with_its_restitution(e):
    body = ball(0.5, 0.1)
    world = RigidWorld(body, restitution=e)
    world.reset(lifted(body.nominal, 0.3))
    before = after = None
    for _ in range(600):
        _, last = world.q_v()
        world.step(NONE)
        if world.contacts().forces[0, 2] > 0:
            before, after = last[2], world.q_v()[1][2]
            if e:  # at the time of the touch
                before, after = world.last.impact.before[2], world.last.impact.after[2]
            break
    assert before == pytest.approx(-math.sqrt(2 * GRAVITY * 0.3), abs=2 * GRAVITY * world.dt)
    assert after == pytest.approx(-e * before, abs=1e-9 if e else 2.5)  # e = 0: what is left of the gap
    heights = [s[0][2] - 0.1 for s in run(world, 0.45)]
    assert min(heights) > -1e-9
    if e in (0.3, 0.7):
        assert max(heights) == pytest.approx(e**2 * 0.3, abs=3e-3)


@pytest.mark.parametrize("ratio", [0.4, 0.8])
def test_box_tips_at_the_right_angle(ratio):
    """A box of width b and height h tips over its lower edge when tan(slope) > b / h."""
    body = box(1.0, (0.2 * ratio, 0.2, 0.2))
    limit = math.degrees(math.atan(ratio))
    turned = []
    for degrees in (limit - 0.3, limit + 0.3):
        world = RigidWorld(body, sf.SlopeTerrain(degrees), mu=2.0)
        world.reset(on_slope(body, degrees))
        turned.append(abs(run(world, 0.4)[-1][1][4]))
    assert turned[0] < 1e-6
    assert turned[1] > 0.05


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_box_is_pushed_over_beyond_half_its_width(share):
    """A push F at half the height tips the box when F h / 2 > m g b / 2."""
    body = box(1.5, (0.1, 0.1, 0.3))
    world = RigidWorld(body, mu=1.0)
    world.reset(body.nominal)
    push = np.array([share * 1.5 * GRAVITY * 0.1 / 0.3, 0.0, 0.0])
    q, v = run(world, 0.3, push)[-1]
    assert (abs(v[4]) > 0.02) == (share > 1.0)
    if share < 1.0:
        assert np.abs(q - body.nominal).max() < 1e-9


@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_a_sliding_block_follows_the_closed_form(dt):
    """Friction acts in the middle of a step: a constant deceleration is exact at any dt."""
    body = box(2.0, (0.4, 0.4, 0.1))
    world = RigidWorld(body, mu=0.4, dt=dt)
    world.reset(body.nominal, np.array([3.0, 0, 0, 0, 0, 0]))
    q = run(world, 0.4)[-1][0]
    assert q[0] == pytest.approx(3.0 * 0.4 - 0.5 * 0.4 * GRAVITY * 0.4**2, abs=1e-9)


@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_a_tumbling_box_follows_runge_kutta(dt):
    body = box(1.0, (0.1, 0.2, 0.4))
    start, spin = body.nominal.copy(), np.array([1.0, 0, 3.0, 2.0, 3.0, 5.0])
    start[2] = 5.0
    world = RigidWorld(body, dt=dt)
    world.reset(start, spin)
    q = run(world, 0.4)[-1][0]
    assert np.abs(q - tumbled(body, start, spin, 0.4)).max() < 1e-6


def test_second_order_in_dt_under_a_push():
    """A push keeps the robot in steps with forces in their middle, whatever its limbs do."""
    robot, rng, ends = sf.load_robot("go2"), np.random.default_rng(0), []
    q, v, torques = robot.nominal.copy(), 3.0 * rng.normal(size=18), rng.normal(size=12)
    q[2] = 5.0
    for dt in (4e-3, 2e-3, 1e-3, 1.25e-4):
        world = RigidWorld(robot, dt=dt)
        world.reset(q, v)
        advance(world, round(0.08 / dt), torques, np.array([30.0, 10.0, 5.0]))
        ends.append(np.concatenate(world.q_v()))
    errors = [np.abs(end - ends[-1]).max() for end in ends[:3]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2.0) < 0.2)


def test_a_box_pivots_without_gain_or_loss():
    """About an edge that sticks, up and back: an edge without compensation would make 1e-5 at 1 ms."""
    body = box(1.0, (0.2, 0.2, 0.4))
    spin = np.array([0.0, 2.0, 0.0])
    v = np.concatenate([np.cross(spin, [-0.1, 0.0, 0.2]), spin])
    for dt, bound in ((4e-3, 1e-5), (1e-3, 2e-6)):
        world = RigidWorld(body, mu=2.0, dt=dt)
        world.reset(body.nominal, v)
        start = world.energy()
        run(world, 0.2)
        assert world.q_v()[1][4] == pytest.approx(-0.2348, abs=1e-3)
        assert world.energy() == pytest.approx(start, rel=bound)
        assert world.contacts().gaps.min() > -1e-6


def test_a_start_into_the_ground_stops_at_it():
    """The first impulses come half a step late; what would hit the ground before them is stopped at once."""
    body = box(1.0, (0.2, 0.2, 0.2))
    world = RigidWorld(body)
    world.reset(body.nominal, np.array([0, 0, -3.0, 0, 0, 0]))
    world.step(NONE)
    assert world.q_v()[0][2] == pytest.approx(0.1, abs=1e-9)
    assert np.abs(world.q_v()[1]).max() < 1e-6
    reading = world.contacts()
    assert world.dt * reading.forces[:, 2].sum() == pytest.approx(3.0 + GRAVITY * world.dt, rel=1e-6)
    assert reading.gaps.min() > -1e-9


class Bowl(Terrain):
    """z = (x² + y²) / (2 R), R = 2 m."""

    def height(self, xy):
        xy = np.asarray(xy)
        return (xy**2).sum(axis=-1) / 4.0

    def normal(self, xy):
        xy = np.asarray(xy)
        n = np.concatenate([-xy / 2.0, np.ones((*xy.shape[:-1], 1))], axis=-1)
        return n / np.linalg.norm(n, axis=-1, keepdims=True)


def test_ball_rolls_in_a_bowl_like_a_pendulum():
    """Rolling without slip in a bowl of radius R: frequency sqrt(5 g / (7 (R - r))) for small swings."""
    body = ball(1.0, 0.05)
    world = RigidWorld(body, Bowl(), mu=1.0, dt=5e-4)
    q = body.nominal.copy()
    normal = Bowl().normal(np.array([0.1, 0.0]))
    q[:3] = np.array([0.1, 0.0, 0.0025]) + 0.05 * normal
    world.reset(q)
    xs = np.array([s[0][0] for s in run(world, 2.5)])
    crossings = np.flatnonzero((xs[:-1] > 0) & (xs[1:] <= 0))
    quarter = (crossings[0] + 1) * world.dt
    assert quarter == pytest.approx(0.5 * math.pi / math.sqrt(5 * GRAVITY / (7 * 1.95)), rel=0.02)
    assert np.abs(xs).max() < 0.1 * 1.05


@pytest.mark.parametrize("tol", [None, 1e-3])
def test_a_terrain_that_gives_no_height_is_named(tol):
    class Hole(Bowl):
        def height(self, xy):
            return np.where(np.asarray(xy)[..., 0] < 0.3, super().height(xy), np.nan)

    world = RigidWorld(ball(1.0, 0.1), Hole(), dt=3e-3, tol=tol)
    world.reset(lifted(world.robot.nominal, 0.01), np.array([5.0, 0, 0, 0, 0, 0]))
    with pytest.raises(SimulationError, match="gap between feet and ground became non-finite") as lost:
        run(world, 0.2)
    assert np.isfinite(world.q_v()[0]).all()
    assert (lost.value.time, world.stepper.options.dt) == (world.time, 3e-3)
