"""Steps that a blind robot feels: strikes, feeling ahead, what is no step, and Go2 on stairs."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.behaviours.steps_by_touch import soft_way
from surefoot.control.controller import RobotState
from surefoot.control.ground_belief import TouchedGround
from surefoot.control.swing import swing_motion
from surefoot.control.touched_steps import TouchedSteps
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.robot import load_robot
from surefoot.simulation.run import run
from surefoot.simulation.scenario import Scenario
from surefoot.simulation.walk_terrain import CLEARANCE, start_pose
from surefoot.spatial import rotation_from_quaternion
from surefoot.terrain import StairsTerrain

HEIGHT, RADIUS = 0.3, 0.022
HIPS = np.array([[0.19, 0.14], [0.19, -0.14], [-0.19, 0.14], [-0.19, -0.14]])
NONE, ALL = np.zeros(4, dtype=bool), np.ones(4, dtype=bool)
FORTH = np.array([0.8, 0.0, 0.0])


def state(time: float = 0.0, x: float = 0.0) -> RobotState:
    """Return a robot that stands level with its base 0.3 m above the ground."""
    q = np.zeros(19)
    q[0], q[2], q[6] = x, 0.3, 1.0
    return RobotState(q, np.zeros(18), time)


def begun() -> tuple[TouchedSteps, np.ndarray]:
    """Return a belief that has begun on flat ground, and where the feet stand."""
    ground, stands = TouchedSteps(), np.column_stack([HIPS, np.zeros(4)])
    ground.radius = RADIUS
    ground.begin(state(), stands, HEIGHT)
    return ground, stands


def strike(ground: TouchedSteps, x: float, z: float, time: float, velocity: np.ndarray = FORTH) -> None:
    """Let a foot strike something with its centre at x."""
    assert ground.may_strike(np.array([x, 0.1, z]), velocity)
    ground.stumbled(time)


def land(ground: TouchedSteps, stands: np.ndarray, foot: int, at: tuple[float, float], time: float) -> None:
    """Let a foot leave the ground and stand at (x, z)."""
    up = ALL.copy()
    up[foot] = False
    ground.observe(state(time), stands, up, NONE, stands)
    stands[foot, [0, 2]] = at
    ground.observe(state(time + 0.1), stands, ALL, NONE, stands)


def test_without_a_strike_the_ground_is_the_plane_of_touch() -> None:
    felt, stands = begun()
    touched = TouchedGround()
    touched.begin(state(), stands.copy(), HEIGHT)
    for step, at in enumerate([(0.3, 0.03), (0.25, 0.04), (-0.1, -0.02), (-0.05, 0.0)]):
        land(touched, stands.copy(), step, at, 0.2 * step)
        land(felt, stands, step, at, 0.2 * step)
        touched.observe(state(0.2 * step + 0.1), stands, ALL, NONE, stands)
    assert felt.height(HIPS).tolist() == touched.height(HIPS).tolist()
    assert (felt.unsure, felt.highest_step) == (False, 0.0)


@pytest.mark.parametrize(("rise", "tread"), [(0.08, 0.3), (0.12, 0.26), (0.14, 0.35)])
def test_two_risers_and_a_stand_tell_the_stairs(rise: float, tread: float) -> None:
    ground, stands = begun()
    strike(ground, 0.4 - RADIUS, 0.03, 0.1)
    assert ground.unsure
    land(ground, stands, 0, (0.48, rise), 0.2)
    assert ground.highest_step == pytest.approx(rise)
    strike(ground, 0.4 + tread - RADIUS, rise + 0.04, 0.6)
    assert not ground.unsure
    assert ground.steepness == pytest.approx(rise / tread)
    x = np.array([0.3, 0.5, 0.4 + 1.5 * tread, 0.4 + 2.5 * tread])
    wanted = [0.0, rise, 2.0 * rise, 3.0 * rise]
    assert ground.height(np.column_stack([x, 0.0 * x])) == pytest.approx(wanted, abs=1e-6)


def test_a_low_step_is_none_and_neither_are_the_next_ones_for_a_while() -> None:
    ground, stands = begun()
    strike(ground, 0.4, 0.01, 0.1)
    land(ground, stands, 0, (0.48, 0.04), 0.2)
    assert ground.flight is None
    assert not ground.unsure
    strike(ground, 0.7, 0.05, 1.0)
    assert ground.flight is None
    strike(ground, 0.7, 0.05, 9.0)
    assert ground.flight is not None


def test_a_strike_sideways_tells_of_no_riser_ahead() -> None:
    ground, _ = begun()
    strike(ground, 0.4, 0.03, 0.1, np.array([0.1, 0.5, 0.0]))
    assert ground.flight is None


def test_on_known_steps_only_what_is_higher_than_the_foot_is_struck() -> None:
    ground, stands = begun()
    strike(ground, 0.4 - RADIUS, 0.03, 0.1)
    land(ground, stands, 0, (0.48, 0.12), 0.2)
    strike(ground, 0.7 - RADIUS, 0.16, 0.6)
    assert ground.may_strike(np.array([0.67, 0.1, 0.2]), FORTH)  # below the edge of the tread ahead
    assert not ground.may_strike(np.array([0.67, 0.1, 0.25]), FORTH)  # above it
    assert not ground.may_strike(np.array([0.5, 0.1, 0.12]), FORTH)  # on its tread, the next one far ahead


def test_steps_that_nothing_fits_are_forgotten() -> None:
    ground, stands = begun()
    strike(ground, 0.4 - RADIUS, 0.03, 0.1)
    land(ground, stands, 0, (0.48, 0.12), 0.2)
    strike(ground, 0.7 - RADIUS, 0.16, 0.6)
    for step in range(4):
        land(ground, stands, 1, (0.85, 0.06), 1.0 + step)
    assert ground.flight is None


def test_a_deep_tread_is_the_end() -> None:
    ground, stands = begun()
    strike(ground, 0.4 - RADIUS, 0.03, 0.1)
    land(ground, stands, 0, (0.5, 0.12), 0.2)
    assert ground.unsure
    land(ground, stands, 1, (0.86, 0.12), 0.6)
    assert ground.flight is None


@pytest.mark.parametrize("duration", [0.18, 0.3])
@pytest.mark.parametrize("known", [0.0, 0.03, 0.1])
def test_a_foot_that_feels_ahead_is_slow_where_nothing_is_known(duration: float, known: float) -> None:
    most = 0.42
    more = soft_way(known, most * duration)
    assert more > 0.0
    target, shares = np.array([known + more, 0.0, 0.0]), np.linspace(0.0, 1.0, 1001)
    path = [swing_motion(np.zeros(3), target, 0.05, float(s), duration, 0.0)[:2, 0] for s in shares]
    beyond = max(speed for way, speed in path if way >= known)
    assert beyond <= 1.02 * most
    if known > 0.0:
        return
    assert beyond > 0.95 * most  # and no slower than it needs to be


def test_feet_feel_ahead_from_the_first_tread_on() -> None:
    ground, stands = begun()
    place = np.array([0.6, 0.14])
    assert ground.feel_ahead(place, np.array([0.3, 0.14, 0.0]), 0.2) is place
    strike(ground, 0.4 - RADIUS, 0.03, 0.1)
    land(ground, stands, 0, (0.48, 0.12), 0.2)
    first = ground.feel_ahead(place, np.array([0.3, 0.14, 0.0]), 0.2)
    assert 0.4 + 2.0 * RADIUS < first[0] < 0.4 + 0.2
    ahead = ground.feel_ahead(place, np.array([0.48, 0.14, 0.12]), 0.2)
    assert 0.48 < ahead[0] <= 0.48 + soft_way(0.0, 0.42 * 0.2) + 1e-9
    assert ahead[1] == place[1]


def test_go2_feels_its_way_up_stairs() -> None:
    mujoco = pytest.importorskip("mujoco")
    assert mujoco
    from surefoot.simulation.mujoco import MujocoWorld

    go2, stairs = load_robot("go2"), StairsTerrain(0.1, 0.28, 4)
    q = start_pose(go2, stairs)
    q[0] = stairs.approach(CLEARANCE * float(go2.nominal[2]))[0] + 0.3
    ground = TouchedSteps()
    walker = WalkingController(go2, VelocityCommand.constant(0.4), "trot", ground)
    log = run(MujocoWorld(go2, stairs, 0.6), walker, Scenario(6.5, 0.6, start=q), [])
    assert log.fact("outcome") == "done"
    assert ground.flight is not None
    assert ground.flight.rise == pytest.approx(0.1, abs=0.004)
    assert ground.flight.tread == pytest.approx(0.28, abs=0.01)
    last = log["q"][-1]
    assert last[2] > 0.2 + float(go2.nominal[2])
    assert rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2].min() > np.cos(np.radians(26.0))
