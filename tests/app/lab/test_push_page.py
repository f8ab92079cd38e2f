"""The push page: choices hold while the robot walks, kicks move it, it stands up again."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.drawing import Arrows, Mesh
from surefoot.app.lab.page import Grip
from surefoot.app.lab.push import PULL, PushPage
from surefoot.app.lab.push_run import HARDEST, LIE, Choices, WalkRun
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.centroidal import momentum

EYE = np.array([1.5, -1.5, 0.9])


def go(run: WalkRun, steps: int) -> None:
    for _ in range(steps):
        run.step()


def test_choices_hold_while_it_walks(robot: sf.Robot) -> None:
    run = WalkRun(robot, Choices(velocity=(0.4, 0.0, 0.0)))
    go(run, 1500)
    assert run.world.q_v()[1][0] == pytest.approx(0.4, abs=0.15)
    run.choose(replace(run.choices, payload=3.0))
    assert run.world.payload == 3.0
    assert run.world.q_v()[0][0] > 0.2  # it is where it was
    for gait in ("walk", "trot", "stand"):
        run.choose(replace(run.choices, gait=gait))
        go(run, 600)
        assert not run.fallen
    assert np.abs(run.world.q_v()[1][:3]).max() < 0.1  # it stands still
    assert run.reading.forces[:, 2].sum() == pytest.approx((robot.mass + 3.0) * 9.81, rel=0.1)


def test_a_kick_changes_the_velocity_by_its_impulse(robot: sf.Robot) -> None:
    run = WalkRun(robot, Choices(gait="stand", mu=0.0))  # on ice nothing else pushes to the side
    before = run.world.q_v()[1]
    run.kick(np.array([0.0, 60.0, 0.0]), 0.02)
    go(run, 20)
    assert not run.push.any()
    q, v = run.world.q_v()
    gained = momentum(robot, q, v).linear - momentum(robot, q, before).linear
    assert gained[1] == pytest.approx(60.0 * 0.02, rel=0.05)


def test_a_kick_of_no_given_length_lasts_a_tenth_of_a_second(robot: sf.Robot) -> None:
    run = WalkRun(robot, Choices(gait="stand"))
    run.kick(np.array([0.0, 60.0, 0.0]))
    pushed = 0
    for _ in range(200):
        run.step()
        pushed += bool(run.push.any())
    assert pushed * run.world.dt == pytest.approx(0.1, abs=2.0 * run.world.dt)


def test_a_robot_that_fell_lies_and_stands_up_again(robot: sf.Robot) -> None:
    run = WalkRun(robot)
    go(run, 500)
    run.kick(np.array([0.0, 1e6, 0.0]), 0.3)
    np.testing.assert_allclose(run.push, [0.0, HARDEST, 0.0])
    for _ in range(2500):
        run.step()
        if run.fallen:
            break
    assert run.fallen
    go(run, int(LIE / run.world.dt) + 2)
    assert not run.fallen
    assert run.time < 0.1


def test_the_mouse_pulls_and_lets_go(robot: sf.Robot) -> None:
    run = WalkRun(robot)
    page = PushPage(run)
    start, point = np.array([0.1, 0.0, 0.3]), np.array([0.1, 0.2, 0.3])
    page.grip(Grip("/robot/root_joint", "update", start, point, EYE))
    arrow = page.drawing().shapes["/pull"]
    assert isinstance(arrow, Arrows)
    np.testing.assert_allclose(arrow.points[0, 1], point)
    page.grip(Grip("/robot/root_joint", "end", start, point, EYE))
    np.testing.assert_allclose(run.force, PULL * (point - start))
    assert "/pull" not in page.drawing().shapes
    page.change("force", 80.0)
    page.grip(Grip("/robot/root_joint", "click", start, start, EYE))
    away = (start - EYE)[:2]
    np.testing.assert_allclose(run.force, [*(80.0 * away / np.linalg.norm(away)), 0.0])
    with pytest.raises(ProblemError):
        page.press("nothing")
    with pytest.raises(ProblemError):
        page.grip(Grip("/ground", "update", start, point, EYE))


def test_it_walks_by_the_clock_and_is_drawn_around_the_middle(robot: sf.Robot) -> None:
    run = WalkRun(robot)
    page, patience = PushPage(run), time.monotonic() + 20.0
    assert run.steps == 0  # nobody has looked
    begin = time.perf_counter()
    while run.steps < 100:
        assert time.monotonic() < patience
        time.sleep(0.02)
        page.drawing()
    assert run.time <= time.perf_counter() - begin + run.world.dt
    page.change("mu", 0.3)
    page.change("gait", "walk")
    assert (run.choices.mu, run.choices.gait) == (0.3, "walk")
    shapes = page.drawing().shapes
    base = shapes["/robot/root_joint"]
    assert isinstance(base, Mesh)
    assert base.held
    assert base.position[:2] == (0.0, 0.0)
    cones = [name for name in shapes if name.startswith("/cones/")]
    assert len(cones) == int((np.abs(run.reading.forces).max(axis=1) > 0.0).sum()) >= 2
