"""Live runs: pace on a clock of our own, keys to velocities, a window that is closed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import load_robot
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.records.log import Ending
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.live import Live, Pacer, Steering
from surefoot.worlds.running.run import Scenario, run

UP, DOWN, LEFT, RIGHT, SPACE = 265, 264, 263, 262, 32


class Clock:
    """Time that passes when somebody sleeps, or works."""

    def __init__(self) -> None:
        self.time, self.slept = 100.0, 0.0

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.time += seconds
        self.slept += seconds


def pace(work: float, steps: int) -> Clock:
    clock = Clock()
    pacer = Pacer(clock.now, clock.sleep)
    for k in range(steps):
        pacer.wait(0.01 * k)
        clock.time += work
    return clock


def test_a_fast_run_takes_as_long_as_what_it_shows() -> None:
    assert pace(0.002, 101).time - 100.0 == pytest.approx(1.0 + 0.002)


def test_a_run_that_was_held_up_does_not_hurry_afterwards() -> None:
    clock = Clock()
    pacer = Pacer(clock.now, clock.sleep)
    pacer.wait(0.0)
    clock.time += 5.0  # the window was being moved
    assert pacer.wait(0.01) == pytest.approx(4.99)
    before = clock.time
    for k in range(2, 102):
        pacer.wait(0.01 * k)
    assert clock.time - before == pytest.approx(1.0)
    clock.time += 0.1  # a little late is caught up
    assert pacer.wait(1.02) == pytest.approx(0.09)
    assert pacer.wait(1.2) == 0.0
    assert clock.time - before == pytest.approx(1.19)


def steering(most: float = 10.0) -> Steering:
    return Steering(lambda velocity: np.clip(velocity, -most, most), (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("keys", "velocity"),
    [
        ([UP, UP, UP, DOWN], (0.2, 0.0, 0.0)),
        ([ord("W"), ord("A"), ord("Q")], (0.1, 0.1, 0.2)),
        ([ord("S"), ord("D"), ord("E")], (-0.1, -0.1, -0.2)),
        ([LEFT, LEFT, RIGHT, RIGHT, RIGHT], (0.0, 0.0, -0.2)),
        ([UP, LEFT, SPACE], (0.0, 0.0, 0.0)),
    ],
)
def test_keys(keys: list[int], velocity: tuple[float, float, float]) -> None:
    steered = steering()
    assert all(steered.press(key) for key in keys)
    assert steered.velocity == pytest.approx(velocity)


class FakeView:
    """Shows nothing, presses keys at given times, and closes in the end."""

    def __init__(self, keys: dict[float, int], closes: float) -> None:
        self.keys, self.closes, self.open_now = sorted(keys.items()), closes, False
        self.shown: list[FloatArray] = []
        self.asked: list[FloatArray] = []

    def open(self, press: Callable[[int], object]) -> None:
        self.press, self.open_now = press, True

    def show(self, q: FloatArray, velocity: FloatArray) -> bool:
        self.shown.append(q.copy())
        self.asked.append(velocity.copy())
        time = (len(self.shown) - 1) / 58.8  # every 17th step
        while self.keys and self.keys[0][0] <= time:
            self.press(self.keys.pop(0)[1])
        return time < self.closes

    def close(self) -> None:
        self.open_now = False


@pytest.mark.long
def test_a_walk_follows_the_keys_and_ends_with_its_window() -> None:
    robot, clock = load_robot("go2"), Clock()
    controller = WalkingController(robot, VelocityCommand.constant(0.0))
    view = FakeView({0.35: UP, 0.4: UP, 0.45: UP, 0.8: SPACE}, closes=1.2)
    live = Live(view, Steering(controller.steer, (0.0, 0.0, 0.0)), pacer=Pacer(clock.now, clock.sleep))
    log = run(MujocoWorld(robot), controller, Scenario(5.0, 0.6), [live])
    assert log.fact("outcome") == Ending.INTERRUPTED
    assert log["time"][-1] == pytest.approx(1.2, abs=0.03)
    assert clock.slept == pytest.approx(log["time"][-1], abs=0.03)
    assert not view.open_now
    assert len(view.shown) == pytest.approx(58.8 * 1.2, abs=3)
    wanted = log["command"][:, 0]
    assert wanted[log["time"] < 0.35].max() == 0.0
    assert wanted[log["time"].searchsorted(0.79)] == pytest.approx(0.3)
    assert wanted[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(np.diff(wanted)).max() <= BODY_MOTION.acceleration * GRAVITY * 1e-3 + 1e-12, (
        "ramped as any other"
    )
    assert [tuple(v) for v in view.asked[-2:]] == [(0.0, 0.0, 0.0)] * 2


def test_steering_is_limited_as_any_command() -> None:
    robot = load_robot("go2")
    controller = WalkingController(robot, VelocityCommand.constant(0.0))
    limited = WalkingController(robot, VelocityCommand.constant(9.0, 0.0, 0.0)).command.at(0.0)
    assert controller.steer([9.0, 0.0, 0.0]) == pytest.approx(limited)
    assert controller.command.at(3.0) == pytest.approx(limited)
    assert controller.steer([0.3, 0.0, 0.1]) == pytest.approx([0.3, 0.0, 0.1])
    with pytest.raises(ProblemError, match="velocity"):
        controller.steer([np.nan, 0.0, 0.0])
