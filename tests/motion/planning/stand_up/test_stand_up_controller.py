"""The controller that gets up, stage by stage: what clock and attitude decide, and its joint targets."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from surefoot.motion.control.controller import RobotState
from surefoot.motion.planning.stand_up.stand_up_controller import (
    StandUpController,
    StandUpPhase,
    controller_of,
)
from surefoot.motion.planning.tracking.reference import Reference
from surefoot.motion.planning.tracking.tracker import TrackCommand, TrackingController
from surefoot.records import Log
from tests.robots import go2

ROBOT = go2()
ROLLING, RISING, STANDING, FOLDING = StandUpPhase
STIFFNESS, DAMPING = 20.0, 0.5
OFFSETS = np.array([0.075, 0.1, -0.1, 0.2, -0.2])
"""How far the joints of each posture are from the nominal ones [rad]."""
LAIN = 0.15
"""How far those of the lying robot are [rad]."""
BEGIN = 5.0
"""Time of the first step [s]."""


def pose(lean: float, joints: float) -> Any:
    """Return q that leans by an angle [deg], with joints so far from the nominal ones [rad]."""
    q = ROBOT.nominal.copy()
    q[3:7] = Rotation.from_euler("x", lean, degrees=True).as_quat()
    q[7:] += joints
    return q


def plan(**less: Any) -> Log:
    """Return a plan of five postures, of which three roll."""
    q = np.array([pose(180.0, LAIN), pose(180.0, LAIN)])
    nv, points = ROBOT.model.nv, len(ROBOT.contact_points)
    arrays = {
        "time": np.array([0.0, 0.01]), "q": q, "v": np.zeros((2, nv)), "forces": np.zeros((2, points, 3)),
    }  # fmt: skip
    facts = {
        "dt": 0.01, "end_q": ROBOT.nominal.tolist(), "end_v": np.zeros(nv).tolist(),
        "posture_times": [0.25, 0.5, 1.0, 1.5, 2.0],
        "posture_targets": (ROBOT.nominal[7:] + OFFSETS[:, None]).tolist(),
        "posture_stiffness": STIFFNESS, "posture_damping": DAMPING,
    }  # fmt: skip
    return Log(arrays, {name: value for name, value in facts.items() if name not in less})


@pytest.fixture(name="control")
def _control() -> StandUpController:
    return StandUpController(ROBOT, plan())


def step(
    control: StandUpController, after: float, lean: float = 180.0, joints: float = 0.0, speed: float = 0.0,
    contact: list[bool] | None = None,
) -> TrackCommand:  # fmt: skip
    """Return the command at a time after the first step, for a body that leans and moves [deg, rad/s]."""
    v = np.zeros(ROBOT.model.nv)
    v[3] = speed
    touching = None if contact is None else np.array(contact)
    return control.step(RobotState(pose(lean, joints), v, BEGIN + after, touching))


def target(command: TrackCommand, joints: float = 0.0) -> float:
    """Return how far from the nominal joints the torques pull [rad], the same for all of them."""
    offsets = command.torques / STIFFNESS + joints
    assert np.ptp(offsets) < 1e-9
    assert not command.forces.any()
    assert not command.active.any()
    return float(offsets.mean())


def test_postures_are_played_by_the_clock_from_where_the_joints_were(control: StandUpController) -> None:
    """On straight lines: from 0.05 by 0.075 to 0.1 in half a second, to -0.1 in another, and held there."""
    for after, joints, expected in (
        (0.0, 0.05, 0.05), (0.25, 0.0, 0.075), (0.5, 0.02, 0.1), (0.75, 0.0, 0.0), (1.0, 0.0, -0.1),
        (1.3, 0.0, -0.1), (1.59, 0.0, -0.1),
    ):  # fmt: skip
        command = step(control, after, joints=joints)
        assert target(command, joints) == pytest.approx(expected, abs=1e-9)
        assert command.phase == ROLLING
    assert step(control, 1.61).phase == FOLDING


def test_joint_speeds_are_damped(control: StandUpController) -> None:
    step(control, 0.0)
    v = np.zeros(ROBOT.model.nv)
    v[6:] = 0.8
    command = control.step(RobotState(pose(180.0, 0.0), v, BEGIN + 0.5))
    np.testing.assert_allclose(command.torques, STIFFNESS * 0.1 - DAMPING * 0.8, atol=1e-9)


@pytest.mark.parametrize(
    ("lean", "speed", "after", "phase"),
    [
        (14.9, 0.59, 1.0, RISING), (14.9, -0.59, 1.0, RISING), (15.1, 0.0, 1.0, ROLLING),
        (0.0, 0.61, 1.0, ROLLING), (0.0, -0.61, 1.0, ROLLING), (0.0, 0.0, 0.99, ROLLING),
        (-14.9, 0.0, 1.7, RISING), (15.1, 0.0, 1.61, FOLDING), (0.0, 0.61, 1.61, FOLDING),
        (15.1, 0.0, 1.59, ROLLING),
    ],
)  # fmt: skip
def test_the_body_rises_once_it_is_level_and_still(
    control: StandUpController, lean: float, speed: float, after: float, phase: StandUpPhase
) -> None:
    step(control, 0.0)
    assert step(control, after, lean, speed=speed).phase == phase
    assert control.phase == phase


def risen(control: StandUpController, joints: float = 0.0) -> None:
    """Bring a controller to the beginning of its rise, a second after the first step."""
    step(control, 0.0)
    assert step(control, 1.0, lean=0.0, joints=joints).phase == RISING


def test_the_rise_goes_on_from_the_last_rolling_posture(control: StandUpController) -> None:
    """From -0.1 to 0.2 in half a second and on to -0.2."""
    risen(control)
    for after, expected in ((1.0, -0.1), (1.25, 0.05), (1.5, 0.2), (1.75, 0.0), (1.99, -0.192)):
        assert target(step(control, after, lean=0.0)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    ("after", "lean", "contact", "phase"),
    [
        (1.99, 0.0, 4 * [True], RISING), (2.0, 0.0, 4 * [True], STANDING),
        (2.0, 0.0, [True, True, True, False], RISING),
        (2.0, 0.0, None, RISING), (2.0, 16.0, 4 * [True], FOLDING), (1.99, 16.0, 4 * [True], RISING),
    ],
)  # fmt: skip
def test_a_risen_body_stands_when_all_feet_do_and_folds_when_it_leans(
    control: StandUpController, after: float, lean: float, contact: list[bool] | None, phase: StandUpPhase
) -> None:
    risen(control)
    assert step(control, after, lean, contact=contact).phase == phase


def test_folding_lies_down_in_half_a_second_and_waits_as_long(control: StandUpController) -> None:
    """From where the joints were to where the plan lies, as a straight line."""
    step(control, 0.0)
    assert target(step(control, 1.61, joints=0.03), 0.03) == pytest.approx(0.03, abs=1e-9)
    for after, share in ((0.25, 0.5), (0.4, 0.8), (0.5, 1.0), (0.99, 1.0)):
        command = step(control, 1.61 + after)
        assert command.phase == FOLDING
        assert target(command) == pytest.approx((1.0 - share) * 0.03 + share * LAIN, abs=1e-9)


@pytest.mark.parametrize(("lean", "phase"), [(10.0, RISING), (90.0, ROLLING)])
def test_after_folding_the_body_tries_again(
    control: StandUpController, lean: float, phase: StandUpPhase
) -> None:
    step(control, 0.0)
    step(control, 1.61)
    command = step(control, 2.62, lean, joints=0.02)
    assert command.phase == phase
    begin = 0.02 if phase == ROLLING else -0.1
    assert target(command, 0.02) == pytest.approx(begin, abs=1e-9)


def stood(control: StandUpController) -> None:
    risen(control)
    assert step(control, 2.0, 0.0, contact=4 * [True]).phase == STANDING


def test_standing_feet_carry_the_weight(control: StandUpController) -> None:
    stood(control)
    command = step(control, 2.1, 0.0, contact=4 * [True])
    assert command.phase == STANDING
    assert command.active.all()
    assert command.forces[:, 2].sum() == pytest.approx(ROBOT.mass * 9.81, rel=0.2)
    lifted = step(control, 2.2, 0.0, contact=[True, True, True, False])
    assert lifted.active.tolist() == [True, True, True, False]
    assert not lifted.forces[3].any()
    assert np.linalg.norm(lifted.torques) > 1.0


def test_a_standing_body_in_the_air_is_held_in_the_last_posture(control: StandUpController) -> None:
    stood(control)
    assert target(step(control, 2.1, 0.0)) == pytest.approx(-0.2, abs=1e-9)
    assert target(step(control, 3.5, 0.0, contact=4 * [False])) == pytest.approx(-0.2, abs=1e-9)


@pytest.mark.parametrize(("lean", "phase"), [(59.0, STANDING), (61.0, FOLDING)])
def test_a_standing_body_that_leans_by_sixty_degrees_folds(
    control: StandUpController, lean: float, phase: StandUpPhase
) -> None:
    stood(control)
    assert step(control, 2.1, lean).phase == phase


def test_a_state_that_is_none_is_damped_and_begins_nothing(control: StandUpController) -> None:
    v = np.zeros(ROBOT.model.nv)
    command = control.step(RobotState(np.full(ROBOT.model.nq, math.nan), v, 1.0))
    assert command.phase == ROLLING
    assert np.isfinite(command.torques).all()
    assert not command.active.any()
    assert target(step(control, 0.25)) == pytest.approx(0.0, abs=1e-9)  # its first step, whatever the time


def test_a_reset_begins_anew(control: StandUpController) -> None:
    stood(control)
    control.reset()
    assert control.phase == ROLLING
    command = step(control, 9.0, joints=0.01)
    assert command.phase == ROLLING
    assert target(command, 0.01) == pytest.approx(0.01, abs=1e-9)


def test_the_facts_name_friction_and_no_least_force(control: StandUpController) -> None:
    assert control.facts["kind"] == "track"
    assert control.facts["normal_min"] == 0.0
    assert control.facts["normal_max"] == math.inf


def test_a_plan_with_postures_is_executed_by_them() -> None:
    assert isinstance(controller_of(plan(), ROBOT), StandUpController)
    tracked = plan(posture_times=None)
    assert isinstance(controller_of(tracked, ROBOT, 2e-3), TrackingController)
    reference = Reference.of(tracked, ROBOT)
    follower = controller_of(reference, ROBOT, 2e-3)
    assert isinstance(follower, TrackingController)
    assert follower.planned is reference
    assert follower.dt == 2e-3
