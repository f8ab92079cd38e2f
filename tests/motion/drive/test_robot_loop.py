"""The loop of a real robot: what follows what, faults of readings, limits, and a whole outing in MuJoCo."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.modes import FOLLOWS, LoopMode
from surefoot.motion.drive.readings import ReadingLimits, ReadingWatch, RobotReadings
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.motion.drive.target_limits import TargetLimits
from surefoot.worlds.running.motor_robot import MotorRobot
from tests.motion.drive.loop_faults import DT, FAULTS, GO2, Stretch, answer, walking

walked = cache(walking)


def drive(
    loop: RobotLoop, robot: MotorRobot, seconds: float, goal: str = "", loss: float = 0.0,
    until: str = "", push: np.ndarray | None = None,
) -> float:  # fmt: skip
    """Go on for a while, or until a mode; return the largest torque asked for or given, over its limit."""
    if goal:
        loop.go(goal)
    rng, worst, begin = np.random.default_rng(1), 0.0, loop.time
    while loop.time - begin < seconds - 0.5 * DT and not (until and loop.mode == until):
        readings = robot.read()
        targets = loop.step(None if rng.random() < loss else readings)
        last = loop.watch.last
        asked = targets.torques(last.positions, last.speeds) if last else np.zeros(12)
        robot.take(targets)
        robot.step(push)
        worst = max(worst, float((np.abs([asked, robot.torques]) / GO2.effort_limits).max()))
    return worst


@pytest.mark.long
def test_an_outing_with_noise_and_4_ms_of_delay() -> None:
    """From its belly up, at 0.5 m/s with three in ten readings lost, lower and nose up, a stop, sit, lie."""
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT)
    robot.lie_down()
    worst = [drive(loop, robot, 0.3), drive(loop, robot, 3.2, "stand")]
    assert loop.mode is LoopMode.STAND
    assert loop.settled
    loop.steer([0.5, 0.0, 0.0])
    worst.append(drive(loop, robot, 2.0, "walk"))
    begin = robot.world.q_v()[0]
    worst.append(drive(loop, robot, 2.0, loss=0.3))
    q, _ = robot.world.q_v()
    assert q[0] - begin[0] == pytest.approx(1.0, abs=0.08)
    assert q[2] == pytest.approx(begin[2], abs=0.01)
    loop.steer([0.5, 0.0, 0.0], [-0.06, -0.15, 0.03])
    worst.append(drive(loop, robot, 2.0))
    q, _ = robot.world.q_v()
    assert q[2] == pytest.approx(begin[2] - 0.06, abs=0.015)
    assert np.arcsin(2.0 * (q[6] * q[4] - q[5] * q[3])) == pytest.approx(-0.15, abs=0.03)
    loop.steer([0.5, 0.0, 0.0])
    worst.append(drive(loop, robot, 2.0, "stand"))
    assert loop.settled
    worst.append(drive(loop, robot, 2.5, "sit"))
    assert loop.settled
    assert robot.world.q_v()[0][2] < 0.22
    worst += [drive(loop, robot, 3.0, "lie"), drive(loop, robot, 0.1, "passive")]
    assert loop.mode is LoopMode.PASSIVE
    assert not loop.fault
    assert max(worst) <= 1.0 + 1e-9


def judge(name: str, seed: int) -> bool:
    """Put one fault into the walk and check the answer; return whether control was impossible."""
    loop, readings = walked()
    rng, stretch = np.random.default_rng(seed), Stretch(readings)
    at = int(rng.integers(2, 20))
    wrong = FAULTS[name](stretch, at, rng)
    told = answer(loop, stretch)
    assert told.worst <= 1.0 + 1e-9, (name, seed)
    if wrong is not None:
        assert told.damped is not None, (name, seed)
        assert (told.damped - wrong) * DT <= 0.02, (name, seed, told)
        assert told.fault
    elif name in ("clock jumps", "a third lost"):
        assert told.damped is None, (name, seed, told)
    return wrong is not None


@pytest.mark.parametrize("name", FAULTS)
@pytest.mark.sampled(4)
def test_faults_are_damped_within_20_ms(name: str) -> None:
    judge(name, 1)


@pytest.mark.long
def test_a_thousand_faults() -> None:
    names = list(FAULTS)
    impossible = sum(judge(names[k % len(names)], k) for k in range(1000))
    assert impossible > 700


def test_what_may_follow_what() -> None:
    loop, readings = walked()
    assert set(FOLLOWS) == set(LoopMode)
    assert loop.mode is LoopMode.WALK
    with pytest.raises(ProblemError, match="walk is followed by damp or stand, not by sit"):
        loop.go("sit")
    with pytest.raises(ProblemError, match="unknown mode 'run'"):
        loop.go("run")
    fresh = RobotLoop(GO2, DT)
    with pytest.raises(ProblemError, match="cannot stand: there is no reading yet"):
        fresh.go("stand")
    assert not fresh.step(readings[0]).stiffness.any()
    with pytest.raises(ProblemError, match="pitch must be within"):
        fresh.steer([0, 0, 0], [0, 1.0, 0])


def test_motors_in_another_order() -> None:
    """FR, FL, RR, RL, as on Unitree's wire: the same targets, in that order."""
    legs, parts = ("FR", "FL", "RR", "RL"), ("hip", "thigh", "calf")
    motors = tuple(f"{leg}_{part}_joint" for leg in legs for part in parts)
    order = np.array([GO2.joint_names.index(name) for name in motors])
    _, readings = walked()
    first = readings[0]
    assert first is not None
    own, other = RobotLoop(GO2, DT), RobotLoop(GO2, DT, motors=motors)
    for _ in range(3):
        own.step(first)
        other.step(first.ordered(order))
        first = first._replace(time=first.time + DT)
    own.go("stand")
    other.go("stand")
    a, b = own.step(first), other.step(first.ordered(order))
    assert a.stiffness.any()
    assert all((x[order] == y).all() for x, y in zip(a, b, strict=True))
    with pytest.raises(ProblemError, match="FL_knee"):
        RobotLoop(GO2, DT, motors=("FL_knee", *motors[1:]))
    with pytest.raises(ProblemError, match="missing: FR_hip_joint"):
        RobotLoop(GO2, DT, motors=motors[1:])


def test_limits_have_the_last_word() -> None:
    rng, limits = np.random.default_rng(0), TargetLimits(GO2)
    for scale in (0.1, 1.0, 30.0, 1e6):
        wild = JointTargets(*(scale * rng.normal(size=(5, 12))))
        q, v = GO2.nominal[7:] + rng.normal(size=12), 10.0 * rng.normal(size=12)
        held = limits.hold(wild, q, v)
        assert (np.abs(held.torques(q, v)) <= GO2.effort_limits + 1e-9).all()
        assert (held.positions >= limits.low).all()
        assert (held.positions <= limits.high).all()
        assert (np.abs(held.velocities) <= GO2.speed_limits).all()
        assert (held.stiffness >= 0.0).all()
    spoiled = wild._replace(positions=np.full(12, np.nan))
    assert not limits.hold(spoiled, q, v).torques(q, v).any()
    sound = JointTargets(q, v, np.full(12, 20.0), np.ones(12), np.ones(12))
    inside = JointTargets(np.clip(q, limits.low, limits.high), *sound[1:])
    assert all(np.allclose(a, b) for a, b in zip(limits.hold(inside, q, v), inside, strict=True))


def test_a_posture_over_time() -> None:
    command = sf.VelocityCommand.constant(0.3, height=-0.05, pitch=0.1, clearance=0.02)
    assert command.posture_at(9.0).tolist() == [-0.05, 0.1, 0.02]
    walker = sf.WalkingController(GO2, command)
    assert walker.command.posture_at(0.0).tolist() == [-0.05, 0.1, 0.02]
    walker.steer([0.0, 0.0, 0.0], [0.01, 0.0, 0.0])
    assert walker.command.posture_at(0.0).tolist() == [0.01, 0.0, 0.0]
    with pytest.raises(ProblemError, match="postures"):
        sf.VelocityCommand(np.zeros(1), np.zeros((1, 3)), np.full((1, 3), np.nan))


def reading(k: int, rng: np.random.Generator, positions: np.ndarray, speeds: np.ndarray) -> RobotReadings:
    """The k-th of a robot that stands still but for its joints; all sensors are noisy."""
    turn, gyro = np.append(1e-6 * rng.normal(size=3), 1.0), 1e-3 * rng.normal(size=3)
    pull = np.array([0.0, 0.0, 9.81]) + 1e-2 * rng.normal(size=3)
    noisy = positions + 1e-5 * rng.normal(size=12), speeds + 1e-3 * rng.normal(size=12)
    return RobotReadings(k * DT, turn, gyro, pull, *noisy, np.zeros(12))


@pytest.mark.parametrize(("wrong", "faster"), [(False, 1.5), (True, 1.5), (True, np.inf)])
def test_speeds_that_jump_between_readings_contradict_no_angles(wrong: bool, faster: float) -> None:
    """The trapezoid is off by half of each jump, and all add up; an angle that is wrong is still found."""
    watch, rng = ReadingWatch(GO2, DT, ReadingLimits(faster=faster)), np.random.default_rng(0)
    q, thigh, said = GO2.nominal[7:].copy(), np.eye(12)[1], []
    for k in range(80):
        # for 8 readings the thigh goes on at 10 rad/s, and every other one finds it just turned back
        q += 10.0 * DT * thigh if 0 < k < 8 else 0.0
        v = 10.0 * (-1.0) ** k * thigh if k < 8 else np.zeros(12)
        told = q + 0.1 * thigh if wrong and k >= 75 else q
        watch.look(reading(k, rng, told, v), k * DT)
        said.append(watch.reason)
    assert not any(said[:75])
    assert said[75] == ("a joint's angles contradict its speeds" if wrong else "")


@pytest.mark.parametrize(("seconds", "said"), [(0.06, "a joint's angles contradict its speeds"), (0.3, "")])
def test_after_an_outage_joints_may_be_anywhere(seconds: float, said: str) -> None:
    """A robot sinks while its joints are damped; only a short silence is bridged by what speeds say."""
    watch, rng = ReadingWatch(GO2, DT, ReadingLimits()), np.random.default_rng(0)
    last = 19 + round(seconds / DT)
    for k in range(last + 1):
        came = reading(k, rng, GO2.nominal[7:] + (0.5 if k == last else 0.0), np.zeros(12))
        watch.look(came if k < 20 or k == last else None, k * DT)
    assert watch.reason == said
    for k in range(last + 1, last + 200):  # nor is a clock that was held up late for ever
        watch.look(reading(k, rng, GO2.nominal[7:] + 0.5, np.zeros(12)), k * DT + 0.05)
    assert not watch.reason
