"""After a fall: joints are damped, nothing thrashes unasked, and the robot gets up from wherever it lies."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import surefoot as sf
from surefoot.drive.getting_up import FALLEN
from surefoot.drive.modes import Mode
from surefoot.drive.robot_loop import RobotLoop
from surefoot.simulation.motor_robot import MotorRobot
from tests.drive.loop_faults import DT, GO2

LOW, HIGH = GO2.model.lowerPositionLimit[7:], GO2.model.upperPositionLimit[7:]
LEFT = np.array([0.0, 450.0, 0.0])
looped = cache(lambda: RobotLoop(GO2, DT))


def limp(seed: int) -> MotorRobot:
    """Return a robot let go 60 cm above the ground, in a random attitude, joints anywhere in their ranges."""
    rng, q, robot = np.random.default_rng(seed), GO2.nominal.copy(), MotorRobot(GO2, DT, seed=seed)
    turn = rng.normal(size=4)
    q[2], q[3:7], q[7:] = 0.6, turn / np.linalg.norm(turn), rng.uniform(LOW, HIGH)
    robot.reset(q)
    return robot


def go_on(
    loop: RobotLoop, robot: MotorRobot, seconds: float, until: str = "", push: np.ndarray | None = None
) -> tuple[float, float]:
    """Go on for a while, or until a mode; return the time, and the largest torque or speed over its limit."""
    begin, worst = loop.time, 0.0
    while loop.time - begin < seconds and not (until and loop.mode == until):
        targets = loop.step(robot.read())
        last = loop.watch.last
        assert last is not None
        asked = targets.torques(last.positions, last.speeds)
        robot.take(targets)
        robot.step(push)
        speeds = np.abs(robot.world.state()[1][6:]) / GO2.speed_limits
        if loop.mode is not Mode.DAMP:
            worst = max(worst, float((np.abs([asked, robot.torques]) / GO2.effort_limits).max()), *speeds)
    return loop.time - begin, worst


def gets_up(seed: int) -> tuple[float, float, float]:
    """Return how far a limp robot leans [rad], how long it takes to stand [s], and `go_on`'s worst."""
    loop, robot = looped(), limp(seed)
    loop.reset()
    assert go_on(loop, robot, 2.5)[1] == 0.0
    attitude = robot.world.state()[0][3:7]
    loop.go("stand")
    took, worst = go_on(loop, robot, 40.0, "stand")
    assert not loop.fault
    go_on(loop, robot, 0.5)
    assert robot.world.state()[0][2] == pytest.approx(GO2.nominal[2], abs=0.03)
    return float(np.arccos(1.0 - 2.0 * (attitude[:2] ** 2).sum())), took, worst


def test_from_its_back() -> None:
    lean, took, worst = gets_up(3)
    assert lean > 2.0
    assert took < 10.0
    assert worst <= 1.0 + 1e-9


@pytest.mark.long
def test_from_twenty_random_poses() -> None:
    rows = [gets_up(seed) for seed in range(20)]
    for seed, (lean, took, worst) in enumerate(rows):
        print(f"seed {seed}: leaned {np.degrees(lean):.0f} deg, stood after {took:.1f} s, worst {worst:.2f}")
    assert max(worst for _, _, worst in rows) <= 1.0 + 1e-9


@pytest.mark.long
@pytest.mark.parametrize("recover", [False, True])
def test_a_push_fells_it_and_the_walk_goes_on(recover: bool) -> None:
    """450 N for 0.3 s at the trunk; by itself it gets up only where `recover` says so."""
    loop, robot = RobotLoop(GO2, DT, recover=recover), MotorRobot(GO2, DT)
    robot.lie_down()
    go_on(loop, robot, 0.2)
    loop.go("stand")
    go_on(loop, robot, 5.0, "stand")
    loop.steer([0.5, 0.0, 0.0])
    go_on(loop, robot, 1.0)
    loop.go("walk")
    go_on(loop, robot, 2.0)
    go_on(loop, robot, 0.3, push=LEFT)
    go_on(loop, robot, 2.0, "damp")
    assert loop.fault == FALLEN
    go_on(loop, robot, 3.0, "stand up")
    assert loop.mode == ("stand up" if recover else "damp")
    if not recover:
        loop.go("stand")
    go_on(loop, robot, 25.0, "stand")
    go_on(loop, robot, 1.0)
    if not recover:
        loop.go("walk")
    assert loop.mode is Mode.WALK
    place = robot.world.state()[0][:2]
    go_on(loop, robot, 3.0)
    assert float(np.linalg.norm(robot.world.state()[0][:2] - place)) > 1.0


def test_a_body_that_sinks_upright_has_fallen() -> None:
    """Its drives do nothing any more: it never leans, and lies on the ground."""
    loop, robot = looped(), MotorRobot(GO2, DT)
    loop.reset()
    robot.reset(GO2.nominal)
    go_on(loop, robot, 0.05)
    loop.go("stand")
    go_on(loop, robot, 5.0, "stand")
    while loop.mode is Mode.STAND and loop.time < 12.0:
        loop.step(robot.read())
        robot.take(None)
        robot.step()
    assert loop.fault == FALLEN


def test_who_does_not_know_how() -> None:
    robot = sf.load_robot("a1")
    loop, still = RobotLoop(robot, DT), np.zeros(12)
    on_its_back = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, -9.81])
    loop.step(sf.RobotReadings(0.0, *on_its_back, robot.nominal[7:], still, still))
    with pytest.raises(sf.ProblemError, match="leans too much, and how to roll over is not known for a1"):
        loop.go("stand")
    assert loop.mode is Mode.DAMP
