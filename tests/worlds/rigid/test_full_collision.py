"""A robot that may touch the ground and itself with all it has."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.laws import SpringDamper
from surefoot.worlds.rigid.bodies import ball
from surefoot.worlds.rigid.rigid_world import RigidWorld

ROBOT = sf.load_robot("go2")
HOLD = ROBOT.nominal[7:]


def pulled(world, goal=HOLD, stiffness=60.0, damping=2.0, limit=23.0):
    q, v = world.q_v()
    return np.clip(stiffness * (goal - q[7:]) - damping * v[6:], -limit, limit)


@pytest.mark.parametrize(
    ("axis", "degrees", "height", "lowest"),
    [((1, 0, 0), 180.0, 0.3, 0.09), ((1, 0, 0), 90.0, 0.3, 0.09), ((0, 1, 0), 180.0, 0.3, 0.09)],
)
def test_a_dropped_go2_lies_on_its_trunk(axis, degrees, height, lowest):
    """On feet alone it falls through the ground; with all of it the ground carries its weight."""
    half = math.radians(degrees) / 2.0
    q = ROBOT.nominal.copy()
    q[2], q[3:6], q[6] = height, math.sin(half) * np.array(axis), math.cos(half)
    world, deepest, normal = RigidWorld(ROBOT, collision="full"), 0.0, []
    world.reset(q)
    for k in range(1500):
        world.step(pulled(world))
        deepest = min(deepest, float(world.last.gaps.min()))
        if k >= 1000:
            normal.append(sum(t.force[2] for t in world.touches()))
    assert world.unsolved == 0
    assert deepest > -2e-6
    assert abs(np.mean(normal) - ROBOT.mass * GRAVITY) < 0.02 * ROBOT.mass * GRAVITY
    assert lowest < world.q_v()[0][2] < 0.2
    assert "base_0" in {t.body for t in world.touches()}
    through = RigidWorld(ROBOT)
    through.reset(q)
    for _ in range(600):
        through.step(pulled(through))
    assert through.q_v()[0][2] < 0.0


def test_its_shins_meet_the_edge_of_a_stair():
    """Pushed against a stair with its shins over the edge: they hold it, where feet alone let it pass."""
    stairs, found = sf.StairsTerrain(0.12, 0.3, 1), {}
    for collision in ("feet", "full"):
        world = RigidWorld(ROBOT, stairs, collision=collision)
        q = ROBOT.nominal.copy()
        q[0] = -0.03 - ROBOT.foot_positions()[0, 0]
        world.reset(q)
        touched = {}
        for k in range(900):
            world.step(pulled(world, stiffness=80.0), np.array([60.0, 0.0, 0.0]) if k > 200 else None)
            touched |= {(t.body, t.other): t for t in world.touches()}
        found[collision] = world, touched
    world, touched = found["full"]
    assert world.unsolved == 0
    for leg in ("FL", "FR"):
        touch = touched[f"{leg}_calf_0", "ground:1"]
        # on the edge of the step, pushed back and up
        assert abs(touch.position[0]) < 0.01
        assert abs(touch.position[2] - 0.12) < 0.03
        assert touch.force[0] < 0.0
    assert not any("calf" in body for body, _ in found["feet"][1])
    assert world.q_v()[0][0] < found["feet"][0].q_v()[0][0] - 0.1


def test_legs_do_not_pass_through_each_other():
    """Both front hips are drawn in: the feet meet in the middle, and the forces between them are internal."""
    goal, across = HOLD.copy(), {}
    goal[0], goal[3] = -1.0, 1.0
    for collision in ("feet", "full"):
        world = RigidWorld(ROBOT, collision=collision)
        q = ROBOT.nominal.copy()
        q[2] += 5.0
        world.reset(q)
        com = ROBOT.com(q)
        for _ in range(400):
            world.step(pulled(world, goal, 40.0, 1.0, 20.0))
        assert world.unsolved == 0
        q, others = world.q_v()[0], world.contacts().others
        if others is not None:
            assert np.abs(others[:6]).max() < 1e-9 * np.abs(others[6:]).max()
        left, right = ROBOT.foot_positions(q)[:2]
        across[collision] = left[1] - right[1]
        fall = np.array([0, 0, -0.5 * GRAVITY * world.time**2])
        np.testing.assert_allclose(ROBOT.com(q), com + fall, atol=1e-5)
    assert across["feet"] < -0.3  # crossed
    radii = ROBOT.foot("FL_foot").radius + ROBOT.foot("FR_foot").radius
    assert across["full"] == pytest.approx(radii, abs=1e-4)


def test_feet_alone_are_what_they_were():
    """Standing, a whole robot's forces are those of its feet."""
    worlds = [RigidWorld(ROBOT, collision=collision) for collision in ("feet", "full")]
    for _ in range(50):
        for world in worlds:
            world.step(pulled(world))
    feet, full = worlds
    np.testing.assert_allclose(full.q_v()[0], feet.q_v()[0], atol=1e-9)
    np.testing.assert_allclose(full.contacts().forces, feet.contacts().forces, atol=1e-5)
    assert full.contacts().positions.shape == (4, 3)
    assert [t.body for t in feet.touches()] == [t.body for t in full.touches()] == list(ROBOT.foot_names)
    assert {t.other for t in feet.touches()} == {"ground"}


@pytest.mark.long
def test_soft_ground_is_of_feet_and_derivatives_are_of_all_that_touches():
    with pytest.raises(ProblemError, match="rigid"):
        RigidWorld(ROBOT, law=SpringDamper(2e4, 100.0), collision="full")
    full, feet = (RigidWorld(ROBOT, collision=name) for name in ("full", "feet"))
    for world in (full, feet):
        world.step(np.zeros(12))
    np.testing.assert_allclose(full.derivative().A, feet.derivative().A, atol=1e-7)
    bare = RigidWorld(ball(), collision="full")
    bare.step(np.zeros(0))
    assert [t.body for t in bare.touches()] == ["ball"]
