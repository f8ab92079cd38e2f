"""Fields of motions by the names of their arrays: one small file for each name, shape and refusal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.motions.field_reading import fields_of, motions_in
from surefoot.records.motions.fields import MotionFields

T, N = 4, 3
RNG = np.random.default_rng(8)
JOINTS, PLACE = RNG.normal(size=(T, N)), RNG.normal(size=(T, 3))
TURN = RNG.normal(size=(T, 4))
TURN /= np.linalg.norm(TURN, axis=1, keepdims=True)
WHOLE = np.hstack([PLACE, TURN, JOINTS])
PARTS = {"dof_pos": JOINTS, "root_pos": PLACE, "root_rot": TURN}
NAMES = ["a", "b", "c"]


def read(contents: dict[str, Any], floating: bool = True) -> MotionFields:
    return fields_of("walk", contents, floating)


def assert_whole(one: MotionFields) -> None:
    for got, expected in ((one.joints, JOINTS), (one.place, PLACE), (one.quaternion, TURN)):
        assert got is not None
        np.testing.assert_array_equal(got, expected)


def refused(contents: Any, words: str, floating: bool = True) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        read(contents, floating)
    assert str(caught.value) == words


def test_contents_are_one_motion_or_one_under_each_key() -> None:
    for contents, names in (
        (WHOLE, ["file"]),
        (WHOLE[0], ["file"]),
        (PARTS, ["file"]),
        ({"a": PARTS}, ["file"]),
        ([PARTS], ["file"]),
        ({"a": PARTS, "b": PARTS}, ["a", "b"]),
        ((PARTS, PARTS), ["0", "1"]),
        ({"times": [0.0, 1.0], "who": {}}, ["file"]),
        ({"rows": [[0.0], [1.0]], "who": {}}, ["file"]),
    ):
        assert [name for name, _ in motions_in(contents, "file")] == names
    assert list(dict(motions_in(WHOLE, "file"))["file"]) == [""]
    assert next(motions_in({"a": PARTS}, "file"))[1] is PARTS


@pytest.mark.parametrize(
    "contents",
    [
        np.array(3.0),
        {},
        [],
        5,
        {"a": 5},
        {"a": np.array(["x"])},
        {"a": np.array(1.0)},
        {"a": []},
        {"a": ["x"]},
    ],
)
def test_contents_without_arrays_of_a_motion_are_refused(contents: Any) -> None:
    with pytest.raises(sf.ProblemError, match="it has no arrays of a motion"):
        list(motions_in(contents, "file"))


@pytest.mark.parametrize(
    ("name", "turn"),
    [("qpos", "wxyz"), ("q", "xyzw"), ("", ""), ("motion", ""), ("data", ""), ("joint_pos", "wxyz")],
)
def test_whole_configurations_have_the_order_of_their_name(name: str, turn: str) -> None:
    one = read({name: WHOLE, "note": "x"})
    assert_whole(one)
    assert (one.name, one.turn, one.certain, one.extra) == ("walk", turn, False, {"note": "x"})
    bolted = read({name: WHOLE}, floating=False)
    np.testing.assert_array_equal(bolted.joints, WHOLE)
    assert bolted.place is None


def test_whole_configurations_have_more_than_seven_columns() -> None:
    refused({"q": WHOLE[:, :7]}, "'q' has 7 columns; place, quaternion and joints are more than 7")
    assert read({"q": WHOLE[:, :8]}).joints.shape == (T, 1)


def test_joint_pos_has_the_root_where_names_or_the_want_of_another_say_so() -> None:
    bodies = {
        "body_pos_w": np.tile(PLACE[:, None], (1, 2, 1)),
        "body_quat_w": np.tile(TURN[:, None], (1, 2, 1)),
    }
    assert_whole(read({"joint_pos": WHOLE, "joint_names": NAMES, **bodies}))
    for root in (bodies, {"root_pos": PLACE, "root_rot": TURN}):
        one = read({"joint_pos": WHOLE, **root})
        np.testing.assert_array_equal(one.joints, WHOLE)
        named = read({"joint_pos": JOINTS, "joint_names": NAMES, **root})
        assert_whole(named)
        assert named.names == ("a", "b", "c")


def test_names_must_be_as_many_as_the_joints() -> None:
    refused({**PARTS, "joint_names": ["a", "b"]}, "it names 2 joints and has angles of 3")


@pytest.mark.parametrize(("name", "turn", "certain"), [
    ("root_rot", "xyzw", False), ("root_quat_w", "wxyz", False), ("base_quat", "", False),
    ("root_quat_xyzw", "xyzw", True), ("root_rot_wxyz", "wxyz", True), ("Base_Orientation", "", False),
])  # fmt: skip
def test_the_name_of_the_quaternion_tells_its_order(name: str, turn: str, certain: bool) -> None:
    one = read({"dof_pos": JOINTS, "root_pos": PLACE, name: TURN})
    assert_whole(one)
    assert (one.turn, one.certain, one.extra) == (turn, certain, {})


def test_a_robot_that_is_bolted_down_needs_no_root() -> None:
    one = read({"dof": JOINTS}, floating=False)
    np.testing.assert_array_equal(one.joints, JOINTS)
    assert (one.place, one.quaternion) == (None, None)


def test_the_root_is_the_first_body_where_nothing_else_says_it() -> None:
    places, turns = RNG.normal(size=(T, 2, 3)), RNG.normal(size=(T, 2, 4))
    places[:, 0], turns[:, 0] = PLACE, TURN
    for place, turn in (
        ("body_pos_w", "body_quat_w"),
        ("body_positions", "body_rotations"),
        ("xpos", "xquat"),
    ):
        one = read({"dof_pos": JOINTS, place: places, turn: turns})
        assert_whole(one)
        assert one.turn == "wxyz"
        named = read({**PARTS, place: -places, turn: turns})
        assert_whole(named)
        assert named.turn == "xyzw"
        half = read({"dof_pos": JOINTS, "root_pos": -PLACE, place: places, turn: turns})
        assert_whole(half)


def test_bodies_of_other_shapes_are_no_root() -> None:
    places, turns = np.zeros((T, 2, 3)), np.ones((T, 2, 4))
    words = "body_pos_w and body_quat_w must have shapes (4, bodies, 3) and (4, bodies, 4), got {} and {}"
    for place, turn in ((places[1:], turns), (places, turns[1:]), (places[0], turns), (places, turns[0])):
        contents = {"dof_pos": JOINTS, "body_pos_w": place, "body_quat_w": turn}
        refused(contents, words.format(place.shape, turn.shape))


def test_what_is_missing_is_told_with_its_likely_names() -> None:
    refused(
        {"a": PLACE},
        "it has no joint angles under any of dof, dof_pos, dof_positions, joint_pos, joint_positions, "
        "joint_angles, ...; it holds a",
    )
    refused(
        {"dof": JOINTS, "root_rot": TURN, "body_pos_w": PLACE},
        "it has no place of the root under any of root_pos, root_trans_offset, root_trans, root_translation, "
        "root_position, ...; it holds body_pos_w, dof, root_rot",
    )
    refused(
        {"dof": JOINTS, "root_pos": PLACE, "body_quat_w": TURN},
        "it has no quaternion of the root under any of root_rot, root_quat, root_quat_w, root_orientation, "
        "root_ori, ...; it holds body_quat_w, dof, root_pos",
    )


def test_the_rate_is_told_by_itself_or_by_the_step() -> None:
    assert read({**PARTS, "fps": 30}).rate == 30.0
    assert read({**PARTS, "dt": np.array([[0.04]])}).rate == pytest.approx(25.0)
    both = read({**PARTS, "fps": [30], "dt": 0.04})
    assert (both.rate, both.extra) == (30.0, {})
    assert read(PARTS).rate is None
    refused({**PARTS, "dt": 0.0}, "dt must be positive and finite [s], got 0")


def test_times_are_taken_where_there_is_one_a_frame() -> None:
    times = np.array([0.0, 0.1, 0.3, 0.35])
    for shape in ((T,), (T, 1)):
        one = read({**PARTS, "time": times.reshape(shape)})
        assert one.times is not None
        np.testing.assert_array_equal(one.times, times)
        assert one.extra == {}
    short = read({**PARTS, "time": times[1:]})
    assert short.times is None
    assert list(short.extra) == ["time"]
    refused({**PARTS, "time": [0.0, 0.5, 0.25, 0.25]}, "its times do not rise: time[2] = 0.25 s after 0.5 s")
    refused({**PARTS, "time": [0.0, 0.5, 0.75, 0.75]}, "its times do not rise: time[3] = 0.75 s after 0.75 s")


@pytest.mark.parametrize(("name", "field"), [("dof_vel", "speeds"), ("qvel", "speeds"), ("tau", "torques")])
def test_velocities_and_torques_are_the_joints_last_columns(name: str, field: str) -> None:
    values = RNG.normal(size=(T, N + 6))
    np.testing.assert_array_equal(getattr(read({**PARTS, name: values}), field), values[:, 6:])
    np.testing.assert_array_equal(getattr(read({**PARTS, name: values[:, 6:]}), field), values[:, 6:])
    for strange in (values[:, 1:], values[1:], values[:, :2]):
        one = read({**PARTS, name: strange})
        assert getattr(one, field) is None
        assert list(one.extra) == [name]


def test_torques_that_fit_are_no_rest() -> None:
    assert read({**PARTS, "tau": JOINTS}).extra == {}


def test_bodies_are_taken_with_as_many_names() -> None:
    bodies = RNG.normal(size=(T, 2, 3))
    one = read({**PARTS, "xpos": bodies, "body_names": ["x", "y"]})
    assert one.bodies is not None
    np.testing.assert_array_equal(one.bodies, bodies)
    assert one.body_names == ("x", "y")
    assert read({**PARTS, "xpos": bodies, "body_names": ["x"]}).body_names == ()
    for strange in (bodies[1:], bodies[:, :, :2], bodies[:, 0]):
        assert read({**PARTS, "xpos": strange}).bodies is None


def test_a_table_of_named_columns_has_no_rest() -> None:
    columns = [f"root_{x}" for x in "xyz"] + [f"root_q{x}" for x in "xyzw"] + NAMES
    one = read({"time": 0.1 * np.arange(T), **dict(zip(columns, WHOLE.T, strict=True))})
    assert_whole(one)
    assert (one.names, one.extra) == (("a", "b", "c"), {})
    assert one.times is not None
