"""A hop made by hand, executed: exact rigid contact and MuJoCo, expected and not."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.motion.planning.tracking import Reference, TrackingController
from surefoot.worlds.running.plan_execution import Surprise, execute

ROBOT = sf.load_robot("go2")


@pytest.mark.long
@pytest.mark.parametrize("world", ["mujoco", "rigid"])
def test_a_hop_lands_where_it_should(jump: Reference, world: str) -> None:
    done = execute(
        jump, world, dt=5e-4
    )  # at 1 ms exact impacts happen more than a millimetre above the ground
    assert done.landed, done.why
    assert done.verdict == "lawful"
    assert not done.laws
    planned = jump.feet[-1].mean(axis=0) - jump.feet[0].mean(axis=0)
    assert done.moved[0] == pytest.approx(planned[0], abs=0.05)
    assert abs(done.moved[1]) < 0.01
    assert done.torque_use_max <= 1.0
    assert done.speed_use_max <= 1.0
    phases = np.asarray(done.log["phase"])
    assert set(phases.tolist()) == {0.0, 1.0, 2.0}
    # nothing touches in flight but at its two ends
    flying = np.flatnonzero(phases == 1.0)
    assert not np.asarray(done.log["forces"])[flying[40:-40]].any()


@pytest.mark.long
def test_the_flight_ends_when_the_feet_touch(jump: Reference) -> None:
    """Not when the plan says so: robots that are lighter and heavier than it knows land when they touch."""
    light, heavy = (
        execute(jump, "mujoco", surprise=Surprise(mass=factor), dt=1e-3) for factor in (0.92, 1.08)
    )
    for done in (light, heavy):
        phases, feet = np.asarray(done.log["phase"]), np.asarray(done.log["forces"])[:, :, 2]
        touch = int(np.flatnonzero(phases == 2.0)[0])
        assert not feet[touch - 10 : touch - 2].any()
        assert feet[touch - 1].any()
        assert done.landed


def test_feet_that_scrape_while_the_body_rises_have_not_landed(jump: Reference) -> None:
    """Solo12's did after a third of the flight, and the landing's control threw it over."""
    controller = TrackingController(ROBOT, jump)
    every, (lift, land) = np.ones(4, dtype=bool), jump.airborne_phases()[0]
    controller.step(sf.RobotState(jump.start, np.zeros(18), 0.0, every))
    high = jump.at(0.5 * (lift + land)).q
    for time, climb, phase in ((lift + 1e-3, 1.0, 1.0), (lift + 0.1, 0.5, 1.0), (lift + 0.2, -0.5, 2.0)):
        v = np.zeros(18)
        v[2] = climb
        assert controller.step(sf.RobotState(high, v, time, every)).phase == phase


def test_a_wrong_state_is_no_crash(jump: Reference) -> None:
    controller = TrackingController(ROBOT, jump)
    state = sf.RobotState(np.full(19, np.nan), np.zeros(18), 0.0, np.ones(4, dtype=bool))
    command = controller.step(state)
    assert np.isfinite(command.torques).all()
    assert not command.attained
    good = controller.step(sf.RobotState(jump.start, np.zeros(18), 0.0, np.ones(4, dtype=bool)))
    assert good.attained
    assert good.forces[:, 2].sum() == pytest.approx(ROBOT.mass * 9.81, rel=0.2)


def test_without_contact_sensing_the_plan_is_believed(jump: Reference) -> None:
    controller = TrackingController(ROBOT, jump)
    command = controller.step(sf.RobotState(jump.start, np.zeros(18)))
    assert command.active.all()
