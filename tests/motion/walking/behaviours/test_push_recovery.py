"""After a push steps come when they are needed: quickly, where they catch the body, and only then."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from benchmarks.stacks.stack import Surefoot
from benchmarks.stacks.tasks import TASKS
from benchmarks.stacks.trial import carry_out
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain import read_terrain
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Request
from surefoot.motion.walking.behaviours.behaviour_settings import PushRecoverySettings
from surefoot.motion.walking.behaviours.push_recovery import PushRecovery
from surefoot.motion.walking.foothold import CATCH_REACH, catching_place
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.records.audit.laws import log_laws
from tests.motion.walking.behaviours.views import HEIGHT, motion, view_of, walk_of

UNIT = math.sqrt(GRAVITY * HEIGHT)


def test_a_body_near_its_wanted_velocity_is_left_to_its_gait() -> None:
    recovery = PushRecovery(walk_of())
    assert recovery.propose(view_of(now=motion(com_velocity=(0.2 * UNIT, 0.0, 0.0)))) is NOTHING
    fast = motion(com_velocity=(0.0, 0.0, 2.0 * UNIT))
    assert recovery.propose(view_of(now=fast)) is NOTHING  # a body that falls is not pushed
    pushed = motion(com_velocity=(0.0, UNIT, 0.0))
    assert recovery.propose(view_of(now=pushed, clock=-0.1)) is NOTHING


@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, -1.0), (-0.6, 0.8)])
def test_a_pushed_body_is_gone_with_in_quick_steps_until_it_is_caught(way: tuple[float, float]) -> None:
    recovery = PushRecovery(walk_of())
    wanted = np.array([0.0, 0.0, 0.2])

    def asked(share: float, velocity: np.ndarray = wanted) -> Request:
        flow = share * UNIT * np.array([*way, 0.0])
        return recovery.propose(view_of(now=motion(com_velocity=flow), velocity=velocity))

    assert asked(1.4).height == PushRecoverySettings().height * HEIGHT
    caught = asked(1.4).recovery
    assert caught is not None
    assert 1.0 < caught.rate <= PushRecoverySettings().quickest
    off = 1.4 * UNIT * np.array(way) - caught.velocity[:2]
    assert math.hypot(*off) == pytest.approx(PushRecoverySettings().give * UNIT)
    assert caught.velocity[2] == wanted[2]
    still = asked(0.35).recovery  # slower than what it begins at, and yet not caught
    assert still is not None
    assert still.rate == 1.0
    flow = 0.35 * UNIT * np.array([*way, 0.0])
    assert asked(0.35, flow + np.array([0.5 * PushRecoverySettings().end_error * UNIT, 0.0, 0.0])) is NOTHING
    assert asked(0.35) is NOTHING  # begins anew from a larger error alone


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_a_foot_catches_within_its_reach_and_on_its_own_side(yaw: float) -> None:
    c, s = math.cos(yaw), math.sin(yaw)
    turn, com = np.array([[c, -s], [s, c]]), np.array([0.4, -0.3, 0.3])
    for arm in np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1]]):
        for way in np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [-0.7, -0.7]]):
            flow = np.array([*(turn @ (3.0 * way)), 0.0])
            place = catching_place(com, flow, arm, yaw, np.zeros(3), 0.1, HEIGHT, 0.1)
            local = turn.T @ (place - com[:2]) - 0.3 * way
            assert np.linalg.norm(local - arm) <= CATCH_REACH * HEIGHT + 1e-9
            assert local[1] * arm[1] > 0.0
            assert (local - arm) @ way > -1e-9
    # a small error takes a foot where the body comes to rest over it, also if it is to go the other way
    slow = np.array([0.05, 0.0, 0.0])
    place = catching_place(np.zeros(3), slow, np.array([0.2, 0.1]), 0.0, -9.0 * slow, 0.0, HEIGHT, 0.0)
    assert place == pytest.approx([0.2 + 0.05 * math.sqrt(HEIGHT / GRAVITY), 0.1])


def test_a_body_leaps_that_was_thrown_aside_over_a_plane_until_it_is_slower() -> None:
    recovery = PushRecovery(walk_of())

    def leaps(x: float, y: float, behaviour: PushRecovery = recovery) -> bool:
        asked = behaviour.propose(view_of(now=motion(com_velocity=(x * UNIT, y * UNIT, 0.0)))).recovery
        return asked is not None and asked.leaps

    assert not leaps(
        PushRecoverySettings().leap_error,
        0.9 * PushRecoverySettings().aside * PushRecoverySettings().leap_error,
    )  # as much ahead,
    assert not leaps(0.0, 1.4)  # at first
    recovery.reset()
    assert not leaps(0.0, 0.9 * PushRecoverySettings().leap_error)
    assert leaps(0.2 * PushRecoverySettings().leap_error, -1.1 * PushRecoverySettings().leap_error)
    assert leaps(1.1 * PushRecoverySettings().leap_error, 0.0)  # on its way
    assert not leaps(0.0, 0.9 * PushRecoverySettings().leap_error)
    assert not leaps(0.0, 1.4, PushRecovery(walk_of(read_terrain("rough:1,0.04", "terrain"))))


@pytest.mark.long
def test_a_trot_that_is_thrown_to_its_left_leaps_and_stays_up_lawfully() -> None:
    task = TASKS["shove-400-left"]  # falls without leaps
    assert carry_out(Surefoot(), task, 1).survived(task.asked)


@pytest.mark.parametrize("phase", [pytest.param(0.0, marks=pytest.mark.long), 0.5])
def test_a_trot_that_is_pushed_hard_stays_up_lawfully_and_comes_back(phase: float) -> None:
    robot = sf.load_robot("go2")
    walker = WalkingController(robot, VelocityCommand.constant(0.5))
    time = walker.start + (2.0 + phase) * walker.schedule.period
    scenario = sf.Scenario(3.6, 0.6, [sf.Push(time, (400.0, 0.0, 0.0), 0.1)])
    log = sf.run(sf.MujocoWorld(robot, collision="full"), walker, scenario)
    assert log.fact("outcome") == "done"
    assert not log_laws(log).broken(robot.mass * GRAVITY)
    late = log["time"] > 3.2
    assert log["v"][late, :2].mean(axis=0) == pytest.approx([0.5, 0.0], abs=0.1)
    rank = log.fact("behaviours").index("push recovery")
    asked = (log["asked_by"] == rank).any(axis=1)
    assert not asked[log["time"] < time].any()
    assert asked[log["time"] > time].any()
