"""After a fall: joints are damped, nothing thrashes unasked, and the robot gets up from wherever it lies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.mechanics import actuators_of
from surefoot.motion.drive.getting_up import FALLEN, FallRecovery, RollOver
from surefoot.motion.drive.modes import LoopMode
from surefoot.motion.drive.postures import BodyPostures, posture_gains
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.worlds.running.motor_robot import MotorRobot
from tests.motion.drive.loop_faults import DT, GO2
from tests.motion.drive.test_robot_loop import drive

LOW, HIGH = GO2.model.lowerPositionLimit[7:], GO2.model.upperPositionLimit[7:]
looped = cache(lambda: RobotLoop(GO2, DT))


def limp(seed: int) -> MotorRobot:
    """Return a robot let go 60 cm above the ground, in a random attitude, joints anywhere in their ranges."""
    rng, q, robot = np.random.default_rng(seed), GO2.nominal.copy(), MotorRobot(GO2, DT, seed=seed)
    turn = rng.normal(size=4)
    q[2], q[3:7], q[7:] = 0.6, turn / np.linalg.norm(turn), rng.uniform(LOW, HIGH)
    robot.reset(q)
    return robot


def gets_up(seed: int) -> tuple[float, float, float]:
    """Return how far a limp robot leans [rad], how long it takes to stand [s], and `drive`'s worst."""
    loop, robot = looped(), limp(seed)
    loop.reset()
    drive(loop, robot, 2.5)
    q, begin = robot.world.q_v()[0], loop.time
    worst = drive(loop, robot, 40.0, "stand", until="stand")
    took = loop.time - begin
    worst = max(worst, drive(loop, robot, 0.5))
    assert not loop.fault
    assert robot.world.q_v()[0][2] == pytest.approx(GO2.nominal[2], abs=0.03)
    assert worst <= 1.0 + 1e-9
    return float(np.arccos(1.0 - 2.0 * (q[3:5] ** 2).sum())), took, worst


@pytest.mark.parametrize("seeds", [[3], pytest.param(range(20), marks=pytest.mark.long)])
def test_from_random_poses(seeds: Sequence[int]) -> None:
    for seed in seeds:
        lean, took, worst = gets_up(seed)
        print(f"seed {seed}: leaned {np.degrees(lean):.0f} deg, up in {took:.1f} s, torque {worst:.2f}")
        assert took < 20.0


@pytest.mark.long
@pytest.mark.parametrize("recover", [False, True])
def test_a_push_fells_it_and_the_walk_goes_on(recover: bool) -> None:
    """450 N for 0.3 s; by itself it gets up and walks on only where `recover` says so."""
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT)
    loop.recover = recover
    robot.lie_down()
    drive(loop, robot, 0.2)
    drive(loop, robot, 5.0, "stand", until="stand")
    loop.steer([0.5, 0.0, 0.0])
    drive(loop, robot, 1.0)
    drive(loop, robot, 2.0, "walk")
    drive(loop, robot, 0.3, push=np.array([0.0, 450.0, 0.0]))
    drive(loop, robot, 2.0, until="damp")
    assert loop.fault == FALLEN
    drive(loop, robot, 8.0, until="stand up")
    assert loop.mode == ("stand up" if recover else "damp")
    drive(loop, robot, 25.0, "" if recover else "stand", until="stand")
    drive(loop, robot, 1.0)
    place = robot.world.q_v()[0][:2]
    drive(loop, robot, 3.0, "" if recover else "walk")
    assert loop.mode is LoopMode.WALK
    assert float(np.linalg.norm(robot.world.q_v()[0][:2] - place)) > 1.0


def test_a_body_that_sinks_upright_has_fallen() -> None:
    """Its drives do nothing any more: it never leans, and lies on the ground."""
    loop, robot = looped(), MotorRobot(GO2, DT)
    loop.reset()
    drive(loop, robot, 0.05)
    drive(loop, robot, 5.0, "stand", until="stand")
    while loop.mode is LoopMode.STAND and loop.time < 12.0:
        loop.step(robot.read())
        robot.take(None)
        robot.step()
    assert loop.fault == FALLEN


@pytest.mark.parametrize("number", [0, 1])
def test_rolling_over_keeps_clear_of_the_joints_stops(number: int) -> None:
    """By five degrees at least, although both ways use the whole range of a joint."""
    roll = RollOver(GO2, BodyPostures(GO2))
    passed = np.vstack([one.points[1:] for one in roll.motions(GO2.nominal[7:], number)[:-1]])
    clear = np.minimum(passed - LOW, HIGH - passed)
    assert np.radians(5.0) < clear.min() < np.radians(10.0)


def test_who_does_not_know_how() -> None:
    robot = sf.load_robot("a1")
    loop, still = RobotLoop(robot, DT), np.zeros(12)
    on_its_back = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, -9.81])
    loop.step(sf.RobotReadings(0.0, *on_its_back, robot.nominal[7:], still, still))
    with pytest.raises(
        sf.ProblemError, match="leans too much, and how a1 rolls over is not known; lay it on its belly"
    ):
        loop.go("stand")
    assert loop.mode is LoopMode.DAMP


def test_a_robot_gets_up_once_it_has_lain_still_for_a_second() -> None:
    recovery, zero = FallRecovery(), np.zeros(12)

    def rises(time: float, turning: float = 0.0, moving: float = 0.0, fault: str = FALLEN) -> bool:
        gyro, speeds = np.array([0.0, turning, 0.0]), np.append(zero[:11], moving)
        pose = np.array([0.0, 0.0, 0.0, 1.0]), gyro, np.array([0.0, 0.0, 9.81])
        readings = sf.RobotReadings(time, *pose, GO2.nominal[7:], speeds, zero)
        return recovery.rises(LoopMode.DAMP, fault, time, readings)

    recovery.fell(LoopMode.WALK, 0.0)
    assert not rises(0.9)
    assert not rises(1.1, turning=-0.4)
    assert not rises(2.0)
    assert not rises(2.2, moving=0.4)
    assert not rises(3.1, turning=0.2, moving=-0.2)
    assert not rises(3.3, fault="late")
    assert rises(3.3)
    assert not recovery.rises(LoopMode.DAMP, FALLEN, 9.0, None)
    for time in (10.0, 20.0, 30.0, 40.0):
        recovery.fell(LoopMode.WALK, time)
    assert not rises(60.0)


@pytest.mark.parametrize("name", ["go2", "g1", "solo12"])
@pytest.mark.parametrize("dt", [0.002, 0.005])
def test_gains_of_postures_shake_no_link(name: str, dt: float) -> None:
    """Each joint alone, its torques a step late: by the poles of the discrete loop."""
    robot = sf.load_robot(name)
    actuators = actuators_of(robot, "real")
    stiffness, damping = posture_gains(robot, dt, actuators)
    mass = pinocchio.crba(robot.model, robot.model.createData(), robot.nominal)
    mass = np.triu(mass) + np.triu(mass, 1).T
    if actuators is not None:
        mass[6:, 6:] += np.diag(actuators.armature)
    for j, inverse in enumerate(np.diag(np.linalg.inv(mass))[6:]):
        k, d = stiffness[j] * inverse * dt * dt, damping[j] * inverse * dt
        # v' = v - k q_last - d v_last, q' = q + v' (speeds per step): (z - 1)² z + d (z - 1) + k z = 0
        assert np.abs(np.roots([1.0, -2.0, 1.0 + d + k, -d])).max() < 0.995
    assert stiffness.min() > 0.0
