"""Ground that is only believed: the plane of touch, the map, feet that strike edges, and the plane ahead."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain, Terrain
from surefoot.motion.control.controller import HeightScan, RobotState
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.ground.mapped_ground import MappedGround
from surefoot.motion.ground.plane_ahead import plane_ahead
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.ground.touched_ground import TouchedGround
from surefoot.motion.walking.foot_phases import FootPhase
from surefoot.motion.walking.touchdown_detection import sort_touches
from surefoot.motion.walking.walking_feet import Feet, FeetModel
from surefoot.worlds.running.height_scan import ActiveRangeSensor, RangeSensor
from tests.motion.walking.behaviours.views import ALL, HEIGHT, HIPS, NONE, level


def march(belief: BeliefTerrain, ground: Terrain, steps: int, stride: float = 0.1) -> float:
    """Walk diagonal pairs of feet over a ground; return where the middle of the feet ends."""
    stands = np.column_stack([HIPS, ground.height(HIPS)])
    belief.begin(level(), stands, HEIGHT)
    x = 0.0
    for step in range(steps):
        x += stride
        pair = [0, 3] if step % 2 == 0 else [1, 2]
        up = ALL.copy()
        up[pair] = False
        belief.observe(level(0.2 * step), stands, up, NONE, stands)
        stands = stands.copy()
        for k in pair:
            xy = HIPS[k] + [x, 0.0]
            stands[k] = [*xy, float(ground.height(xy))]
        belief.observe(level(0.2 * step + 0.1), stands, ALL, NONE, stands)
    return x


def test_touch_finds_a_slope_and_expects_it_to_go_on() -> None:
    belief, slope = TouchedGround(), SlopeTerrain(15.0)
    x = march(belief, slope, 12)
    assert belief.gradient([x, 0.0]) == pytest.approx([math.tan(math.radians(15.0)), 0.0], abs=2e-3)
    assert belief.height([x + 0.4, 0.0]) == pytest.approx(slope.height([x + 0.4, 0.0]), abs=0.01)
    assert belief.bumps == 0.0


def test_stairs_make_a_blind_robot_lift_its_feet() -> None:
    flat, stairs = TouchedGround(), TouchedGround()
    march(flat, FlatTerrain(), 12)
    x = march(stairs, StairsTerrain(0.12, 0.3, 20), 12)
    assert flat.bumps == 0.0
    assert stairs.bumps > 0.02
    assert 0.2 < stairs.gradient([x, 0.0])[0] < 0.6  # 0.4 on average


def test_a_foot_that_finds_no_ground_lowers_the_plane() -> None:
    belief = TouchedGround()
    stands = np.column_stack([HIPS, np.zeros(4)])
    belief.begin(level(), stands, HEIGHT)
    soles, sought = stands.copy(), NONE.copy()
    soles[0, 2], sought[0] = -0.1, True
    belief.observe(level(0.1), stands, ~sought, sought, soles)
    assert belief.height([0.3, 0.14]) < -0.03


def test_a_late_scan_goes_where_the_base_was() -> None:
    belief = MappedGround()
    stands = np.column_stack([HIPS, np.zeros(4)])
    belief.begin(level(), stands, HEIGHT)
    # seen at 0 s from the origin, told at 0.05 s when the base is 0.1 m further: a box of 0.1 m at x = 0.6
    x = np.linspace(0.3, 0.8, 500)
    points = np.column_stack([x, 0.0 * x, 0.1 * (x > 0.55) - 0.3])
    for k in range(51):
        now = level(0.001 * k, scan=HeightScan(0.0, points, np.full(500, 1e-5)) if k == 50 else None)
        now.q[0] = 0.002 * k
        belief.observe(now, stands, ALL, NONE, stands)
    assert belief.height([0.45, 0.0]) == pytest.approx(0.0, abs=5e-3)
    assert belief.height([0.65, 0.0]) == pytest.approx(0.1, abs=5e-3)


@cache
def before_stairs(rise: float, yaw: float) -> MappedGround:
    """Return what a robot believes that has stood before stairs and looked at them for 0.7 s."""
    robot, belief = load_robot("go2"), MappedGround()
    stairs = StairsTerrain(rise, 0.3)
    looks = ActiveRangeSensor(RangeSensor(tilt=0.0, shift=0.0), robot, stairs, 1e-3, 0)
    q = robot.nominal.copy()
    q[0], q[5], q[6] = -0.4, math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    stands = np.column_stack([HIPS + q[:2], np.zeros(4)])
    belief.begin(RobotState(q, np.zeros(18)), stands, HEIGHT)
    for k in range(700):
        now = RobotState(q, np.zeros(18), 1e-3 * k, scan=looks.look(q, 1e-3 * k))
        belief.observe(now, stands, ALL, NONE, stands)
    return belief


@pytest.mark.parametrize("rise", [0.12, -0.12])
@pytest.mark.parametrize("yaw", [0.0, 0.15])
def test_stairs_that_are_seen_are_known_to_millimetres(rise: float, yaw: float) -> None:
    belief, stairs = before_stairs(rise, yaw), StairsTerrain(rise, 0.3)
    ahead = belief.steps_until(np.array([-0.5, 0.0]), np.array([math.cos(yaw), math.sin(yaw)]))
    assert ahead > 0.5 + 0.3 * math.cos(yaw) - 0.02  # two edges at least
    assert belief.highest_step == pytest.approx(abs(rise), abs=0.004)
    assert belief.steepness == pytest.approx(abs(rise) / 0.3, abs=0.02)
    x = np.arange(-0.15, 0.7, 0.005)
    for y in (-0.2, 0.0, 0.2):
        line = np.column_stack([x, y + 0.0 * x])
        off = np.abs(belief.height(line) - stairs.height(line))
        edges = np.abs(x[:, None] - [0.0, 0.3, 0.6]).min(axis=1) < 0.012
        assert off[~edges].max() < 0.01
    flat = np.array([[0.15, 0.1], [0.45, -0.1]])
    assert np.abs(belief.gradient(flat)).max() == 0.0
    assert belief.noise_at(flat[0]) < belief.noise_at(np.array([-0.6, 0.0])) == belief.noise


def test_a_foot_well_above_seen_ground_is_told_so() -> None:
    belief = before_stairs(-0.12, 0.0)
    soles = np.array([[0.15, 0.1, -0.12], [0.15, 0.1, -0.06], [0.15, 0.1, -0.06], [5.0, 0.0, 1.0]])
    above = belief.above(soles, np.array([True, True, False, True]))
    assert abs(above[0]) < 1.0
    assert above[1] * belief.noise == pytest.approx(0.06, abs=0.01)
    assert above[2:].tolist() == [0.0, 0.0]  # not asked, and not known


def test_a_foot_strikes_nothing_where_the_ground_before_it_is_low() -> None:
    ahead = np.array([1.0, 0.0, 0.5])
    assert before_stairs(0.12, 0.0).may_strike(np.array([-0.04, 0.1, 0.06]), ahead)  # a riser
    assert not before_stairs(0.12, 0.0).may_strike(np.array([-0.04, 0.1, 0.2]), ahead)  # over it
    assert not before_stairs(-0.12, 0.0).may_strike(np.array([0.12, 0.1, -0.05]), ahead)  # on the way down
    assert before_stairs(-0.12, 0.0).may_strike(np.array([9.0, 0.1, 0.5]), ahead)  # nobody knows
    assert TouchedGround().may_strike(np.zeros(3), ahead)


def test_the_names_of_knowledge() -> None:
    ground = FlatTerrain()
    assert controller_ground("exact", ground) is ground
    assert controller_ground("map", ground).learns
    assert controller_ground("blind", ground).learns
    with pytest.raises(ProblemError, match="valid names: blind, exact, map"):
        controller_ground("deaf", ground)


def test_an_edge_is_told_from_the_ground_by_the_force() -> None:
    centres = np.column_stack([HIPS, np.full(4, 0.02)])
    foot = FeetModel(FlatTerrain(), np.full(4, 0.02), 0.07, 0.1).standing(centres).foot
    foot["phase"], foot["share"] = FootPhase.SWING, [0.4, 0.8, 0.8, 0.4]
    feet = Feet(foot)
    ahead = np.tile([1.0, 0.0, 0.0], (4, 1))
    forces = np.array([[-40.0, 0.0, 5.0], [-10.0, 0.0, 40.0], [0.0, 0.0, 1.0], [40.0, 0.0, 5.0]])
    still = np.zeros((4, 3))
    sensed, struck = sort_touches(feet, ALL, forces, ahead, still, 160.0)
    assert sensed.tolist() == [False, True, False, False]  # a riser, a landing, noise, and a push from behind
    assert struck.tolist() == [True, False, False, False]
    assert not sort_touches(feet, ALL, forces, ahead, 0.7 * ahead, 160.0)[
        1
    ].any()  # it goes on: a leg that brakes
    assert sort_touches(feet, ALL, forces, ahead, -0.2 * ahead, 160.0)[1][0]  # thrown back
    feet.foot["restart"][0] = 0.05, 0.19
    assert not sort_touches(feet, ALL, forces, ahead, still, 160.0)[1].any()  # once in a swing


@pytest.mark.parametrize("degrees", [0.0, 12.0, -20.0])
def test_the_plane_ahead_of_a_plane_is_that_plane(degrees: float) -> None:
    slope = SlopeTerrain(degrees)
    level, gradient = plane_ahead(slope, np.array([0.3, 0.2]), 0.7, np.array([0.5, 0.1]), HEIGHT)
    assert level == pytest.approx(slope.height([0.3, 0.2]), abs=1e-3)
    assert gradient == pytest.approx([math.tan(math.radians(degrees)), 0.0], abs=0.01)


def test_the_plane_over_stairs_is_calm() -> None:
    stairs, still, ways = StairsTerrain(0.12, 0.3, 30), np.zeros(2), np.linspace(3.0, 5.0, 80)
    planes = [plane_ahead(stairs, np.array([x, 0.0]), 0.0, still, HEIGHT) for x in ways]
    level = np.array([p[0] for p in planes]) - 0.4 * np.linspace(3.0, 5.0, 80)
    slopes = np.array([p[1][0] for p in planes])
    assert np.ptp(level) < 0.012  # the treads themselves are off by 0.12
    assert np.ptp(slopes) < 0.05
    assert slopes.mean() == pytest.approx(0.4, abs=0.02)
