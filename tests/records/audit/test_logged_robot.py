"""The robot of a log: the model of a recording's facts against geometry by hand, and what moves a contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.records.audit.logged_robot import LoggedRobot, build_model, from_recording, from_robot

OWNERS = np.array([0, 1])
SIDE = np.sqrt(0.5)
FACTS: dict[str, Any] = {
    "robot": "crab", "joints": ["lift", "turn", "reach"],
    "model_bodies": ["base", "arm", "hand"], "model_parents": [-1, 0, 1],
    "model_masses": [4.0, 2.0, 1.0], "model_inertias": [[1.0, 2.0, 3.0], [0.1, 0.2, 0.3], [0.4, 0.5, 0.6]],
    "model_centres": [[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]],
    "model_inertia_axes": [[1.0, 0.0, 0.0, 0.0], [SIDE, 0.0, 0.0, SIDE], [2.0, 0.0, 0.0, 0.0]],
    "model_positions": [[9.0, 9.0, 9.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]],
    "model_orientations": [[1.0, 0.0, 0.0, 0.0], [SIDE, 0.0, 0.0, SIDE], [1.0, 0.0, 0.0, 0.0]],
    "model_joint_bodies": [1, 1, 2], "model_joint_axes": [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    "model_joint_places": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.25], [0.1, 0.0, 0.0]],
    "model_joint_kinds": ["free", "slide", "hinge", "hinge"], "contact_body": ["hand", "base"],
}  # fmt: skip


def log_of(facts: dict[str, Any]) -> sf.Log:
    return sf.Log({"time": np.arange(2.0), "forces": np.zeros((2, 2, 3))}, facts)


def read(**changes: Any) -> LoggedRobot | str:
    facts = {name: value for name, value in {**FACTS, **changes}.items() if value is not None}
    return from_recording(log_of(facts), OWNERS)


def turn(axis: Any, angle: float) -> Any:
    return pinocchio.exp3(np.asarray(axis) * angle)


def test_a_recordings_robot_is_told_as_its_facts_say() -> None:
    robot = read()
    assert isinstance(robot, LoggedRobot)
    assert (robot.name, robot.joint_names) == ("crab", ("lift", "turn", "reach"))
    assert (robot.base_dof, robot.joints) == (6, 3)
    assert robot.mass == pytest.approx(7.0)
    np.testing.assert_array_equal(robot.owner, OWNERS)
    assert robot.support.astype(int).tolist() == [[1] * 9, [1] * 6 + [0] * 3]
    assert robot.leg(0).tolist() == [True] * 9
    assert robot.leg(1).tolist() == [True] * 6 + [False] * 3
    assert robot.is_foot.tolist() == [True, True]
    other = read(contact_is_foot=[0, 1], contact_body=["arm", "none such"], robot=None, joints=None)
    assert isinstance(other, LoggedRobot)
    assert other.is_foot.tolist() == [False, True]
    assert other.support.astype(int).tolist() == [[1] * 8 + [0], [1] * 6 + [0] * 3]
    assert (other.name, other.joint_names) == ("", ())


def test_links_move_about_the_places_of_their_joints() -> None:
    """The centre of mass by turning every link by hand, the last joint first."""
    model, joint_of = build_model(log_of(FACTS), FACTS["model_joint_kinds"])
    lift, angle, reach = 0.3, 0.7, -0.4
    q = np.r_[np.zeros(6), 1.0, lift, angle, reach]
    upright = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter about z
    middle, out = np.array([0.0, 0.0, 0.25]), np.array([0.1, 0.0, 0.0])

    def of_arm(point: Any) -> Any:
        turned = middle + turn([1, 0, 0], angle) @ (np.asarray(point) - middle)
        return np.array([0.5, 0.0, 0.0]) + upright @ (turned + np.array([0.0, 0.0, lift]))

    def of_hand(point: Any) -> Any:
        turned = out + turn([0, 1, 0], reach) @ (np.asarray(point) - out)
        return of_arm(turned + np.array([0.0, 0.0, 1.0]))

    base, arm, hand = np.array([0.1, 0.0, 0.0]), of_arm([0.0, 0.2, 0.0]), of_hand([0.0, 0.0, 0.3])
    com = (4.0 * base + 2.0 * arm + hand) / 7.0
    np.testing.assert_allclose(pinocchio.centerOfMass(model, model.createData(), q), com, atol=1e-12)
    assert joint_of == [1, 3, 4]


def test_moments_of_inertia_are_in_their_own_axes() -> None:
    model, joint_of = build_model(log_of(FACTS), FACTS["model_joint_kinds"])
    base, arm = model.inertias[joint_of[0]], model.inertias[joint_of[1]]
    np.testing.assert_allclose(base.inertia, np.diag([1.0, 2.0, 3.0]), atol=1e-12)
    np.testing.assert_allclose(base.lever, [0.1, 0.0, 0.0])
    np.testing.assert_allclose(arm.inertia, np.diag([0.2, 0.1, 0.3]), atol=1e-12)  # a quarter about z
    assert arm.mass == 2.0


def test_joints_have_the_ranges_that_the_log_tells() -> None:
    ranges = [[-1.0, 2.0], [-np.inf, 0.5], [-0.25, np.inf]]
    model, _ = build_model(log_of({**FACTS, "model_joint_ranges": ranges}), FACTS["model_joint_kinds"])
    np.testing.assert_array_equal(model.lowerPositionLimit[7:], [-1.0, -1e300, -0.25])
    np.testing.assert_array_equal(model.upperPositionLimit[7:], [2.0, 0.5, 1e300])
    free, _ = build_model(log_of(FACTS), FACTS["model_joint_kinds"])
    np.testing.assert_array_equal(free.lowerPositionLimit[7:], [-1e300] * 3)
    np.testing.assert_array_equal(free.upperPositionLimit[7:], [1e300] * 3)
    np.testing.assert_array_equal(free.velocityLimit[6:], [1e300] * 3)
    np.testing.assert_array_equal(free.effortLimit[6:], [1e300] * 3)


def test_what_cannot_be_built_says_why() -> None:
    for name in (name for name in FACTS if name.startswith("model_") or name == "contact_body"):
        assert read(**{name: None}) == f"the log does not keep its model ({name})"
    strange = "the robot has no free base with hinges and slides behind it"
    for kinds in (["hinge", "slide", "hinge", "hinge"], ["free", "slide", "ball", "hinge"]):
        assert read(model_joint_kinds=kinds) == strange


def test_a_recordings_contacts_are_found_on_a_robot_by_foot_or_link() -> None:
    robot = sf.load_robot("go2")
    names = list(robot.foot_names)
    facts = {"kind": "recording", "feet": [names[2], "stub"], "contact_body": ["", "FL_thigh"]}
    made = from_robot(robot, log_of(facts), OWNERS)
    assert isinstance(made, LoggedRobot)
    np.testing.assert_array_equal(made.support[0], robot.contact_points.foot_support[2])
    q = pinocchio.randomConfiguration(robot.model, np.full(19, -1.0), np.full(19, 1.0))
    data = robot.model.createData()
    frame = robot.model.getFrameId("FL_thigh", pinocchio.FrameType.BODY)
    J = pinocchio.computeFrameJacobian(robot.model, data, q, frame, pinocchio.ReferenceFrame.LOCAL)
    np.testing.assert_array_equal(made.support[1], np.abs(J).max(axis=0) > 1e-9)
    assert (made.name, made.joint_names) == (robot.name, tuple(robot.joint_names))
    for link in ("", "no such link"):
        lost = log_of({**facts, "contact_body": ["", link]})
        assert (
            from_robot(robot, lost, OWNERS) == f"the recording's stub is no foot and no link of {robot.name}"
        )
    short = log_of({**facts, "contact_body": [""]})
    assert from_robot(robot, short, OWNERS) == f"the recording's stub is no foot and no link of {robot.name}"


def test_contacts_of_another_log_are_the_robots_own() -> None:
    robot = sf.load_robot("go2")
    made = from_robot(robot, log_of({"feet": ["stub"]}), OWNERS)
    assert isinstance(made, LoggedRobot)
    np.testing.assert_array_equal(made.support, robot.contact_points.support)
    assert made.support.dtype == bool
    assert made.is_foot.tolist() == [True] * 4
