"""The parts of a biped's walking against closed forms and independent dynamics."""

from __future__ import annotations

import math

import numpy as np
import pinocchio
import pytest

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.robot.sole_plane import sole_plane
from surefoot.mechanics.terrain import SlopeTerrain, rough_ground
from surefoot.motion.control.posture import Posture, stretching
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.walking.biped.biped_settings import CATCHING
from surefoot.motion.walking.biped.catching import PACES, Catching
from surefoot.motion.walking.biped.footstep_planner import (
    Footstep,
    StepGeometry,
    StepPlanner,
    pressure_path,
    stances,
)
from surefoot.motion.walking.biped.leg_momentum import LegMomentum
from surefoot.motion.walking.biped.pendulum import PendulumPreview

OMEGA = 4.0


def _steady_offset(stride: float, width: float, side: float, step: float, double: float) -> FloatArray:
    """Return ξ over a foot at its touchdown in the periodic gait, in closed form.

    With E = exp(ω step) and γ = 1 - (1 - exp(-ω double)) / (ω double), ξ - foot goes from b to E (b + γ s)
    until the next touchdown, s being the step that led to the foot; the periodic gait repeats it.
    """
    E, spread = math.exp(OMEGA * step), OMEGA * double
    gamma = 1.0 - (1.0 - math.exp(-spread)) / spread
    return np.array([stride * (1.0 - E * gamma) / (E - 1.0), -side * width * (1.0 + E * gamma) / (E + 1.0)])


def test_the_preview_finds_the_periodic_gait() -> None:
    step, double, width, stride, dt = 0.4, 0.1, 0.2, 0.15, 0.0025
    steps = [
        Footstep(k % 2, k * step, (k + 1) * step + double, np.array([k * stride, width * (0.5 - k % 2)]), 0.0)
        for k in range(-1, 20)
    ]
    preview = PendulumPreview(OMEGA, dt, 1200)
    ahead = preview.divergent(pressure_path(steps, dt * (np.arange(1200, dtype=np.float64) + 0.5)))
    for touchdown, side in ((0, 1.0), (1, -1.0), (2, 1.0)):
        foot = np.array([touchdown * stride, 0.5 * side * width])
        offset = ahead[round(touchdown * step / dt)] - foot
        assert np.allclose(offset, _steady_offset(stride, width, side, step, double), atol=2e-4)


def test_the_preview_moves_as_a_pendulum() -> None:
    rng, dt = np.random.default_rng(3), 0.01
    pressure = rng.normal(size=(60, 2))
    preview = PendulumPreview(OMEGA, dt, 60)
    com, velocity = preview.motion(np.array([0.1, -0.2]), pressure)
    x, v = com[0].copy(), velocity[0].copy()
    for k in range(60):
        c, s = math.cosh(OMEGA * dt), math.sinh(OMEGA * dt)
        away = x - pressure[k]
        x, v = pressure[k] + c * away + s / OMEGA * v, OMEGA * s * away + c * v
        assert np.allclose(x, com[k + 1], atol=1e-9)
        assert np.allclose(v, velocity[k + 1], atol=1e-8)
    assert np.allclose(com[-1] + velocity[-1] / OMEGA, pressure[-1], atol=1e-9)  # it ends at rest over it


def test_standing_comes_before_the_gait() -> None:
    gait = named_gait("walk", 2, period=1.0)
    left, right = stances(gait, 0, -0.2, 2.0), stances(gait, 1, -0.2, 2.0)
    assert left[0] == (-math.inf, pytest.approx(0.6))
    assert right[0] == (-math.inf, pytest.approx(0.1))
    assert right[1] == (pytest.approx(0.5), pytest.approx(1.1))
    feet = [
        Footstep(0, *left[0], np.array([0.0, 0.1]), 0.0),
        Footstep(1, *right[0], np.array([0.0, -0.1]), 0.0),
    ]
    assert np.allclose(pressure_path(feet, np.array([-0.1, 0.05, 0.2])), [[0, 0], [0, 0], [0, 0.1]])


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_feet_do_not_cross(yaw: float) -> None:
    geometry = StepGeometry(0.2, 0.12, 0.5, 0.4)
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s], [s, c]])
    support, rng = np.array([1.0, 2.0]), np.random.default_rng(1)
    for wanted in rng.normal(size=(50, 2)):
        for side in (1.0, -1.0):
            got = turn.T @ (geometry.within_reach(support + wanted, support, yaw, side) - support)
            assert 0.12 - 1e-12 <= side * got[1] <= 0.5 + 1e-12
            # no step is long and wide at once
            assert math.hypot(got[0] / 0.4, max(side * got[1] - 0.2, 0.0) / 0.3) <= 1.0 + 1e-12
    inside = support + turn @ np.array([0.3, 0.2])
    assert np.allclose(geometry.within_reach(inside, support, yaw, 1.0), inside)


def _pushed(miss: FloatArray) -> tuple[Catching, list[Footstep], list[Footstep], FloatArray]:
    """Return a walk on the left foot that is pushed, its steps, and those that catch it with ξ of now."""
    gait = named_gait("walk", 2, period=0.8)
    planner = StepPlanner(gait, StepGeometry(0.2, 0.08, 0.5, 0.4), np.array([1.0, -1.0]), 0.9)
    catching = Catching(PendulumPreview(OMEGA, 0.02, 120), planner, 0.6)

    def ahead(pace: float) -> list[Footstep]:
        spans = [(-0.2, 0.3), *((0.2 + 0.4 * k, 0.7 + 0.4 * k) for k in range(8))]
        return [
            Footstep(k % 2, a / pace, b / pace, np.array([0.1 * k, 0.1 * (-1) ** k]), 0.0)
            for k, (a, b) in enumerate(spans)
        ]

    times = catching.preview.middles
    divergent = catching.preview.divergent(pressure_path(ahead(1.0), times))[0] + miss
    assert catching.notice(miss)
    steps = catching.steps(ahead, miss, divergent, 0.0)
    return catching, ahead(1.0), steps, divergent - catching.preview.divergent(pressure_path(steps, times))[0]


@pytest.mark.parametrize("miss", [(0.05, 0.0), (0.0, -0.04), (-0.06, 0.03)])
def test_steps_move_to_where_the_pendulum_is_caught(miss: tuple[float, float]) -> None:
    catching, plain, steps, left = _pushed(np.array(miss))
    assert catching.pace == 1.0  # within reach of the gait's own steps
    assert np.abs(left).max() < 2e-3
    moved = np.array([one.place - two.place for one, two in zip(steps, plain, strict=True)])
    assert (moved[0] == 0.0).all()  # it stands
    assert np.allclose(moved[1:], moved[1], atol=1e-9)  # and the walk goes on from there


def test_steps_come_sooner_where_legs_do_not_reach() -> None:
    catching, plain, steps, left = _pushed(np.array([0.2, 0.1]))  # outwards over the foot that stands
    assert catching.pace in PACES[1:]
    assert steps[1].begin == pytest.approx(plain[1].begin / catching.pace)
    assert np.hypot(*left) < 0.2 * np.hypot(0.2, 0.1)
    for _ in range(CATCHING.calm_plans - 1):
        assert catching.notice(np.zeros(2))
    assert not catching.notice(np.zeros(2))
    assert catching.pace == 1.0
    assert not catching.notice(
        np.array([0.9 * CATCHING.begin_miss * 0.6, 0.0])
    )  # begins from a larger miss alone


def test_leg_momentum_is_the_centroidal_one() -> None:
    robot = load_robot("g1")
    legs = LegMomentum(robot, np.zeros(robot.joints))
    model, data, q = robot.model, robot.model.createData(), robot.nominal
    speed = np.array([0.9, 0.1, 0.4])  # of the left foot, which does not turn; the base rests
    pinocchio.computeJointJacobians(model, data, q)
    frame = robot.feet[0].frame
    pinocchio.updateFramePlacement(model, data, frame)
    J = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED)[:, 6:12]
    v = np.zeros(model.nv)
    v[6:12] = np.linalg.solve(J, np.concatenate([speed, np.zeros(3)]))
    pinocchio.computeCentroidalMomentum(model, data, q, v)
    feet = np.zeros((1, 2, 3))
    feet[0, 0] = speed
    com = np.array([data.hg.linear / robot.mass])
    assert np.allclose(legs.momentum(feet, com, np.zeros(1))[0], data.hg.angular, atol=1e-9)
    c, s = math.cos(1.1), math.sin(1.1)  # turned with its heading
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned = legs.momentum(feet @ turn.T, com @ turn.T, np.array([1.1]))
    assert np.allclose(turned[0], turn @ data.hg.angular, atol=1e-9)


def test_arms_swing_against_the_legs() -> None:
    robot = load_robot("g1")
    posture = Posture(robot, 12.0, 1.0)
    names = np.array(robot.joint_names)[np.flatnonzero(posture.swing)]
    assert set(names) == {"left_shoulder_pitch_joint", "right_shoulder_pitch_joint"}
    assert LegMomentum(robot, posture.swing).balancing() > 0.0
    assert LegMomentum(robot, -posture.swing).balancing() == 0.0
    wanted = posture.accelerations(robot.nominal, np.zeros(robot.model.nv), 0.2, 0.0)
    assert (wanted[:12] == 0.0).all()


def test_only_crouching_robots_rise() -> None:
    assert stretching(load_robot("talos"), 0.83) == 0.0
    assert 0.0 < stretching(load_robot("g1"), 0.83) < 0.05


def test_soles_lie_on_rough_ground() -> None:
    ground, robot = rough_ground(1, 0.03), load_robot("g1")
    foot = robot.feet[0]
    corners = foot.centres - foot.centre
    for yaw, xy in ((0.3, np.array([0.2, 0.7])), (-1.0, np.array([-1.3, 0.1]))):
        frame, height = sole_plane(ground, corners, xy, yaw)
        at = np.array([*xy, height]) + corners @ frame.T
        gaps = at[:, 2] - ground.height(at[:, :2])
        assert gaps.min() == pytest.approx(0.0, abs=1e-12)
        assert gaps.max() < 0.006
    q = place(robot, ground)
    assert min(robot.sphere_bottoms(q)) > 0.0
    level = place(robot, SlopeTerrain(5.0))
    assert np.allclose(level[3:7], [0.0, 0.0, 0.0, 1.0], atol=1e-6)
