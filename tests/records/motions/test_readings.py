"""Readings of motions: configurations under conventions, and how far links are from where a file has them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

from surefoot.records.motions.fields import MotionFields
from surefoot.records.motions.joint_orders import JointOrder
from surefoot.records.motions.plausibility import Plausibility
from surefoot.records.motions.readings import Reading, Readings

NAMES = ("first", "second", "third")
STRAIGHT = JointOrder("straight", NAMES)
FRAMES = 15


def chain(floating: bool = True) -> Any:
    """Return three joints that slide along z, each with a link that it is named for, and a sensor's frame."""
    model, below = pinocchio.Model(), 0
    if floating:
        below = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root")
    for name in NAMES:
        below = model.addJoint(below, pinocchio.JointModelPZ(), pinocchio.SE3.Identity(), name)
        model.addBodyFrame(f"{name} link", below, pinocchio.SE3.Identity(), 0)
    away = pinocchio.SE3(np.eye(3), np.full(3, 50.0))
    model.addFrame(pinocchio.Frame("eye", below, 0, away, pinocchio.FrameType.SENSOR))
    ends = np.full(model.nq, np.inf)
    model.lowerPositionLimit, model.upperPositionLimit = -ends, ends
    nominal = np.r_[[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0][: 7 * floating], 0.1, 0.2, 0.3]
    return SimpleNamespace(
        model=model, floating=floating, feet=(), joints=3, joint_names=NAMES, nominal=nominal
    )


def fields(**more: Any) -> MotionFields:
    rng = np.random.default_rng(4)
    turns = rng.normal(size=(FRAMES, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    joints = rng.uniform(-1.0, 1.0, (FRAMES, 4))
    return MotionFields("", joints, rng.normal(size=(FRAMES, 3)), turns, **more)


def test_columns_go_to_the_joints_that_an_order_names() -> None:
    one, robot = fields(), chain()
    readings = Readings(robot, one, (3, 0), None)
    q = readings.configurations("xyzw", JointOrder("two", ("third", "first")))
    assert one.place is not None
    np.testing.assert_array_equal(q[:, :3], one.place)
    np.testing.assert_array_equal(q[:, 7], one.joints[:, 0])
    np.testing.assert_array_equal(q[:, 8], np.full(FRAMES, 0.2))
    np.testing.assert_array_equal(q[:, 9], one.joints[:, 3])


def test_a_robot_that_is_bolted_down_has_its_joints_first() -> None:
    one = MotionFields("", np.arange(6.0).reshape(2, 3))
    q = Readings(chain(floating=False), one, (0, 1, 2), 50.0).configurations("xyzw", STRAIGHT)
    np.testing.assert_array_equal(q, one.joints)


@pytest.mark.parametrize("quaternion", ["xyzw", "wxyz", "xyzw inverse", "wxyz inverse"])
def test_quaternions_are_turned_about_as_they_are_called(quaternion: str) -> None:
    one = fields()
    assert one.quaternion is not None
    q = Readings(chain(), one, (0, 1, 2), None).configurations(quaternion, STRAIGHT)
    for row, numbers in zip(q[:, 3:7], one.quaternion, strict=True):
        w, x, y, z = numbers if "wxyz" in quaternion else np.roll(numbers, 1)
        expected = pinocchio.Quaternion(w, x, y, z).matrix()
        expected = expected.T if "inverse" in quaternion else expected
        np.testing.assert_allclose(pinocchio.Quaternion(row).matrix(), expected, atol=1e-12)


def test_pairs_are_chosen_by_the_rate() -> None:
    first, second = Readings(chain(), fields(), (0, 1, 2), 60.0).pairs
    assert set(second - first) == {4}


def test_the_cost_adds_surprise_and_distance() -> None:
    plausible = Plausibility(0.25, 0.0, 0.0, 0.0, 0.0)
    order = JointOrder("odd", NAMES, surprise=0.5)
    q = np.zeros((2, 10))
    assert Reading("xyzw", order, q, plausible).cost == pytest.approx(0.75)
    assert Reading("xyzw", order, q, plausible, 0.03).cost == pytest.approx(0.75 + 1.5)
    assert Reading("xyzw", order, q, plausible, 0.9).cost == pytest.approx(0.75 + 10.0)


def upright(**more: Any) -> MotionFields:
    one = fields(**more)
    one.quaternion = np.tile([0.0, 0.0, 0.0, 1.0], (FRAMES, 1))
    return one


def links(one: MotionFields) -> Any:
    """Return places (FRAMES, 3, 3) of the links of a chain that stands upright."""
    assert one.place is not None
    places = np.tile(one.place[:, None], (1, 3, 1))
    places[:, :, 2] += np.cumsum(one.joints[:, :3], axis=1)
    return places


def read(one: MotionFields) -> Reading:
    return Readings(chain(), one, (0, 1, 2), None).read("xyzw", STRAIGHT)


def test_links_are_compared_with_the_bodies_of_their_names() -> None:
    one = upright()
    aside = np.array([0.4, 0.1, 0.2])  # the middle of the three counts
    places = links(one)
    places[:, :, 0] += aside
    strange = np.full((FRAMES, 1, 3), 9.0)
    one.bodies = np.concatenate([places[:, [2]], strange, places[:, [0, 1]]], axis=1)
    one.body_names = ("third link", "strange", "first link", "second link")
    reading = read(one)
    assert reading.distance == pytest.approx(0.2)
    assert reading.quaternion == "xyzw"
    assert reading.order is STRAIGHT


def test_bodies_without_names_are_compared_with_the_links_next_to_them() -> None:
    one = upright()
    one.joints[:, 1:3] = 5.0
    one.bodies = links(one)[:, ::-1] + [0.0, 0.03, 0.04]
    assert read(one).distance == pytest.approx(0.05)


def test_eight_frames_evenly_over_a_motion_are_compared() -> None:
    one = upright()
    places = links(one)
    places[::2] += [0.3, 0.0, 0.0]  # frames 0, 2, ... 14 of fifteen
    one.bodies, one.body_names = places, tuple(f"{name} link" for name in NAMES)
    assert read(one).distance == pytest.approx(0.3)
    one.bodies = places[::-1].copy()
    one.bodies[::2], one.bodies[1::2] = links(one)[::2], 9.0
    assert read(one).distance == pytest.approx(0.0, abs=1e-9)


def test_fewer_than_three_bodies_tell_nothing() -> None:
    one = upright()
    assert read(one).distance is None
    one.bodies = links(one)[:, :2]
    assert read(one).distance is None
    one.bodies, one.body_names = links(one), ("first link", "second link", "strange")
    assert read(one).distance is None


def test_a_reading_is_judged_by_the_ranges_of_its_joints() -> None:
    one, robot = upright(), chain()
    limits = np.r_[[-9.0] * 7, -0.5, -0.5, -0.5]
    robot.model.lowerPositionLimit, robot.model.upperPositionLimit = limits, -limits
    readings = Readings(robot, one, (0, 1, 2), None)
    beyond = np.maximum(np.abs(one.joints[readings.pairs[0], :3]) - 0.5, 0.0)
    assert readings.read("xyzw", STRAIGHT).plausibility.excess == pytest.approx(beyond.sum(axis=1).mean())
