"""Logs from sources made by hand: units, clocks, axes and orders, and one line for what does not fit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.records.log.channels import Channel
from surefoot.records.log.from_source import log_from_source, take_friction
from surefoot.records.log.mapping import LogMapping, Take
from surefoot.records.log.source import Source, Topic

RNG = np.random.default_rng(2)
TIMES = np.array([0.0, 0.1, 0.2, 0.3])
TURNS = RNG.normal(size=(4, 4))
TURNS /= np.linalg.norm(TURNS, axis=1, keepdims=True)
VECTORS = RNG.normal(size=(4, 3))
ROTATIONS = np.array([pinocchio.Quaternion(row).matrix() for row in TURNS])


def table(**fields: Any) -> Source:
    return Source({"": Topic(None, {"time": TIMES, **fields})})


def log_of(source: Source, feet: tuple[str, ...] = (), /, **takes: Take) -> sf.Log:
    time = {} if "" not in source.topics else {"time": Take(("time",))}
    return log_from_source(source, LogMapping({**time, **takes}, feet), "here")


def refused(words: str, source: Source, /, **takes: Take) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        log_of(source, **takes)
    assert str(caught.value) == words


def test_units_and_scales_multiply() -> None:
    log = log_of(table(a=VECTORS), imu_acceleration=Take(("a",), unit="g", scale=-2.0))
    np.testing.assert_allclose(log["imu_acceleration"], -2.0 * 9.80665 * VECTORS)
    assert log.facts["source"] == "here"
    assert log.facts["dt"] == pytest.approx(0.1)
    assert "start" not in log.facts
    assert "feet" not in log.facts


def test_the_step_is_the_middle_one_of_those_that_go_on() -> None:
    times = np.array([0.0, 0.0, 0.0, 0.1, 0.2, 0.9])
    source = Source({"": Topic(None, {"time": times, "x": np.arange(6.0)})}, start=12.5)
    log = log_of(source, energy=Take(("x",)))
    assert log.facts["dt"] == pytest.approx(0.1)
    assert log.facts["start"] == 12.5
    still = Source({"": Topic(None, {"time": times[:1], "x": np.arange(1.0)})})
    assert "dt" not in log_of(still, energy=Take(("x",))).facts


def test_axes_are_turned_by_the_orientation() -> None:
    source = table(q=TURNS, u=VECTORS)
    base = {"base_orientation": Take(("q",))}
    log = log_of(source, **base, base_velocity=Take(("u",), frame="base"))
    np.testing.assert_allclose(log["base_velocity"], np.einsum("tij,tj->ti", ROTATIONS, VECTORS))
    log = log_of(source, **base, base_angular_velocity=Take(("u",), frame="world"))
    np.testing.assert_allclose(log["base_angular_velocity"], np.einsum("tji,tj->ti", ROTATIONS, VECTORS))
    log = log_of(source, base_velocity=Take(("u",), frame="world"))
    np.testing.assert_array_equal(log["base_velocity"], VECTORS)
    refused(
        "channel base_velocity in base axes needs the channel base_orientation",
        source, base_velocity=Take(("u",), frame="base"),
    )  # fmt: skip


def test_forces_in_other_axes_are_those_of_level_ground() -> None:
    forces = RNG.normal(size=(4, 6))
    source = table(q=TURNS, f=forces)
    turn = {"base_orientation": Take(("q",))}
    log = log_of(source, forces=Take(("f",), frame="world"))
    np.testing.assert_array_equal(log["forces"], forces.reshape(4, 2, 3))
    told = "forces: contact axes are taken to be the world's, as on level ground"
    assert told in log.facts["doubts"]
    log = log_of(source, **turn, forces=Take(("f",), frame="base"))
    expected = np.einsum("tij,tpj->tpi", ROTATIONS, forces.reshape(4, 2, 3))
    np.testing.assert_allclose(log["forces"], expected)
    refused(
        "channel com is in world axes and cannot be turned from those of the contacts",
        table(u=VECTORS), com=Take(("u",), frame="contact"),
    )  # fmt: skip
    refused(
        "channel energy cannot be turned from base axes",
        table(u=VECTORS[:, 0]), energy=Take(("u",), frame="base"),
    )  # fmt: skip


def test_quaternions_that_are_zero_turn_nothing() -> None:
    turns = 3.0 * TURNS
    turns[1] = 0.0
    log = log_of(table(q=turns, u=VECTORS), base_orientation=Take(("q",)), com=Take(("u",), frame="base"))
    assert np.isnan(log["com"]).all(axis=1).tolist() == [False, True, False, False]
    np.testing.assert_allclose(log["com"][2], ROTATIONS[2] @ VECTORS[2])


def test_quaternions_with_w_first_are_turned_about() -> None:
    q = np.hstack([VECTORS, np.roll(TURNS, 1, axis=1), VECTORS[:, :2]])
    log = log_of(table(q=q, o=np.roll(TURNS, 1, axis=1)), q=Take(("q",), quaternion="wxyz"),
                 base_orientation=Take(("o",), quaternion="wxyz"))  # fmt: skip
    np.testing.assert_array_equal(log["q"], np.hstack([VECTORS, TURNS, VECTORS[:, :2]]))
    np.testing.assert_array_equal(log["base_orientation"], TURNS)
    refused("channel q holds no quaternion", table(q=q[:, :6]), q=Take(("q",), quaternion="wxyz"))
    refused("channel com holds no quaternion", table(u=VECTORS), com=Take(("u",), quaternion="wxyz"))
    assert log_of(table(q=q[:, :7]), q=Take(("q",), quaternion="wxyz"))["q"].shape == (4, 7)


def test_velocities_of_mujoco_are_put_into_base_axes() -> None:
    q, v = np.hstack([VECTORS, TURNS]), RNG.normal(size=(4, 7))
    takes = {"v": Take(("v",), frame="world")}
    log = log_of(table(q=q, v=v), q=Take(("q",)), **takes)
    linear = np.einsum("tji,tj->ti", ROTATIONS, v[:, :3])
    np.testing.assert_allclose(log["v"], np.hstack([linear, v[:, 3:]]))
    words = "channel v in world axes (of its linear part) needs q with a floating base"
    refused(words, table(v=v), **takes)
    refused(words, table(q=q[:, :6], v=v), q=Take(("q",)), **takes)
    refused(words, table(q=q, v=v[:, :5]), q=Take(("q",)), **takes)
    assert log_of(table(q=q, v=v[:, :6]), q=Take(("q",)), **takes)["v"].shape == (4, 6)


def test_configurations_are_made_of_their_parts() -> None:
    joints, rates = RNG.normal(size=(4, 2)), RNG.normal(size=(4, 2))
    parts = {"base_position": VECTORS, "base_orientation": TURNS, "joint_positions": joints}
    more = {"base_velocity": -VECTORS, "base_angular_velocity": 2.0 * VECTORS, "joint_velocities": rates}
    log = log_of(table(**parts, **more), **{name: Take((name,)) for name in (*parts, *more)})
    np.testing.assert_array_equal(log["q"], np.hstack([VECTORS, TURNS, joints]))
    linear = np.einsum("tji,tj->ti", ROTATIONS, -VECTORS)
    np.testing.assert_allclose(log["v"], np.hstack([linear, 2.0 * VECTORS, rates]))
    for gone in parts:
        some = {name: Take((name,)) for name in parts if name != gone}
        assert "q" not in log_of(table(**parts), **some).arrays
    own = np.zeros((4, 9))
    kept = log_of(table(**parts, own=own), q=Take(("own",)), **{name: Take((name,)) for name in parts})
    np.testing.assert_array_equal(kept["q"], own)


def topics(slow: Any, fast: Any = TIMES) -> Source:
    return Source({
        "/fast": Topic(np.asarray(fast, float), {"x": np.arange(float(len(fast)))}),
        "/slow": Topic(np.asarray(slow, float), {"y": 10.0 * np.arange(float(len(slow)))}),
    })  # fmt: skip


BOTH = {"energy": Take(("/fast.x",)), "solver_error": Take(("/slow.y",))}


def test_the_topic_of_most_messages_is_the_clock_and_others_are_held() -> None:
    log = log_of(topics([0.05, 0.2], np.arange(0.0, 0.65, 0.1)), **BOTH)
    np.testing.assert_allclose(log["time"], [0.1, 0.2, 0.3, 0.4, 0.5])
    np.testing.assert_array_equal(log["energy"], [1.0, 2.0, 3.0, 4.0, 5.0])
    np.testing.assert_array_equal(log["solver_error"], [0.0, 10.0, 10.0, 10.0, 10.0])
    assert "/slow comes every 150 ms and is held for rows every 100 ms" not in log.facts["doubts"]
    log = log_of(topics([0.0, 0.2]), **BOTH)
    assert "/slow comes every 200 ms and is held for rows every 100 ms" in log.facts["doubts"]


@pytest.mark.parametrize(("slow", "told"), [([0.0, 0.144, 0.288], False), ([0.0, 0.156, 0.312], True)])
def test_topics_slower_by_half_are_told(slow: list[float], told: bool) -> None:
    doubts = log_of(topics(slow), **BOTH).facts["doubts"]
    assert any("/slow comes every" in doubt for doubt in doubts) == told


def test_topics_out_of_order_are_sorted_and_equal_clocks_kept() -> None:
    log = log_of(topics([0.2, 0.0]), **BOTH)
    np.testing.assert_array_equal(log["solver_error"], [10.0, 10.0, 0.0, 0.0])
    log = log_of(topics([0.0, 0.1, 0.1, 0.3], [0.0, 0.1, 0.1, 0.3]), **BOTH)
    np.testing.assert_array_equal(log["solver_error"], [0.0, 10.0, 20.0, 30.0])


def test_topics_without_a_time_in_common_are_refused() -> None:
    refused("the topics /fast, /slow have no time in common", topics([5.0, 6.0]), **BOTH)


@pytest.mark.parametrize("stamp", [np.nan, np.inf, 2e30, -2e30])
def test_stamps_are_finite(stamp: float) -> None:
    source = Source({"": Topic(None, {"time": [0.0, 0.1, stamp], "x": np.arange(3.0)})})
    refused("the time stamp of row 2 is no finite number", source, energy=Take(("x",)))


def test_tables_without_rows_time_or_channels_are_refused() -> None:
    empty = Source({"": Topic(None, {"time": np.zeros(0), "x": np.zeros(0)})})
    refused("the file has no rows", empty, energy=Take(("x",)))
    refused("the mapping takes no channel", table())
    refused("the time is one number per row, got 3", Source({"": Topic(None, {"time": VECTORS, "x": TIMES})}),
            energy=Take(("x",)))  # fmt: skip
    untimed = Source({"t": Topic(None, {"x": TIMES})})
    with pytest.raises(sf.ProblemError, match="the mapping must say which column is the time"):
        log_of(untimed, energy=Take(("t.x",)))


def test_a_rate_is_the_time_of_rows_without_stamps() -> None:
    mapping = LogMapping({"energy": Take(("x",))}, rate=20.0)
    log = log_from_source(table(x=TIMES), mapping)
    np.testing.assert_allclose(log["time"], [0.0, 0.05, 0.1, 0.15])
    log = log_from_source(table(x=TIMES), LogMapping({"energy": Take(("x",))}), rate=40.0)
    np.testing.assert_allclose(log["time"], [0.0, 0.025, 0.05, 0.075])
    stamped = LogMapping(BOTH, rate=20.0)
    one = LogMapping({"energy": BOTH["energy"]}, rate=20.0)
    for each in (stamped, one):
        with pytest.raises(sf.ProblemError, match="a rate is for a table without stamps"):
            log_from_source(topics(TIMES), each)


def named(names: tuple[str, ...], width: int = 2) -> Source:
    values = np.arange(4.0 * width).reshape(4, width)
    return Source({"/j": Topic(TIMES, {"position": values}, {"name": names})})


JOINTS = {"joint_positions": Take(("/j.position",))}


def test_joints_are_in_the_mappings_order() -> None:
    source = named(("a", "b"))
    log = log_from_source(source, LogMapping(JOINTS, joints=("b", "a")))
    np.testing.assert_array_equal(log["joint_positions"][0], [1.0, 0.0])
    assert log.facts["joints"] == ["b", "a"]
    assert log_from_source(source, LogMapping(JOINTS)).facts["joints"] == ["a", "b"]
    with pytest.raises(sf.ProblemError) as caught:
        log_from_source(source, LogMapping(JOINTS, joints=("a", "c")))
    assert str(caught.value) == "/j has no joint 'c'; it has: a, b"
    refused("/j names a joint twice: a, a", named(("a", "a")), **JOINTS)
    refused("channel joint_positions is taken from no field", source, joint_positions=Take(()))


def test_names_of_another_number_are_told_once() -> None:
    source = named(("a", "b", "c"))
    log = log_of(source, **JOINTS, joint_velocities=Take(("/j.position",)))
    assert log.facts["doubts"].count("/j names 3 joints for 2 numbers: its names are not used") == 1
    assert "joints" not in log.facts


def test_rows_have_the_shape_of_their_channel() -> None:
    refused("channel com has the row shape (3), its fields give 2 numbers", table(u=VECTORS[:, :2]),
            com=Take(("u",)))  # fmt: skip
    refused("channel forces has the row shape (p, 3), its fields give 4 numbers", table(u=TURNS),
            forces=Take(("u",)))  # fmt: skip
    refused("channel forces has the row shape (p, 3), its fields give 0 numbers", table(u=TURNS[:, :0]),
            forces=Take(("u",)))  # fmt: skip
    twice = Channel("both", ("a", "b"), meaning="two free sizes")
    with pytest.raises(sf.ProblemError, match="channel both cannot be made of a flat row"):
        log_from_source(
            table(u=TURNS),
            LogMapping({"time": Take(("time",)), "both": Take(("u",))}, define={"both": twice}),
        )


def test_flags_are_zero_and_one() -> None:
    log = log_of(table(u=np.array([0.0, 1.0, 1.0, 0.0])), saturated=Take(("u",)))
    assert log["saturated"].tolist() == [False, True, True, False]
    refused("channel saturated must hold true and false", table(u=TIMES), saturated=Take(("u",)))


def test_contacts_are_the_feet_where_they_are_as_many() -> None:
    source = table(f=np.zeros((4, 6)))
    log = log_of(source, ("left", "right"), forces=Take(("f",)))
    assert (log.facts["feet"], log.facts["contact_foot"]) == (["left", "right"], [0, 1])
    assert "contact_foot" not in log_of(source, ("one",), forces=Take(("f",))).facts


def test_friction_is_one_number_or_one_a_contact() -> None:
    fields: dict[str, Any] = {"time": TIMES, "forces": np.zeros((4, 2, 3))}
    facts: dict[str, Any] = {"mu": 0.5}
    take_friction(facts, fields)
    assert facts == {}
    np.testing.assert_array_equal(fields.pop("mu"), [0.5] * 4)
    take_friction({"mu": [1, 2]}, fields)
    np.testing.assert_array_equal(fields.pop("contact_friction"), [[1.0, 2.0]] * 4)
    take_friction({"mass": 1.0}, fields)
    assert set(fields) == {"time", "forces"}


@pytest.mark.parametrize(("mu", "more", "words"), [
    (0.5, {"mu": TIMES}, "mu is given as an array and as a fact: give one of them"),
    (0.5, {"contact_friction": TIMES}, "mu is given as an array and as a fact: give one of them"),
    ("x", {}, "the fact mu must hold real numbers, got 'x'"),
    ([0.5], {}, "the fact mu must be a number or one for each of 0 contacts, got the shape (1,)"),
    ([0.5], {"forces": np.zeros((4, 2, 3))},
     "the fact mu must be a number or one for each of 2 contacts, got the shape (1,)"),
    ([[0.5, 0.5]], {"forces": np.zeros((4, 2, 3))},
     "the fact mu must be a number or one for each of 2 contacts, got the shape (1, 2)"),
])  # fmt: skip
def test_friction_that_is_none_is_refused(mu: Any, more: dict[str, Any], words: str) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        take_friction({"mu": mu}, {"time": TIMES, **more})
    assert str(caught.value) == words


def test_a_guess_leaves_out_channels_of_other_joints() -> None:
    columns = {"a_pos": TIMES, "b_pos": TIMES, "fl_tau": TIMES}
    mapping = LogMapping(
        {"time": Take(("time",)), "joint_positions": Take(("a_pos", "b_pos")), "torques": Take(("fl_tau",))},
        joints=("a", "b", "c"), guessed=True,
    )  # fmt: skip
    log = log_from_source(table(**columns), mapping)
    assert "torques" not in log.arrays
    assert "joints" not in log.facts
    doubts = log.facts["doubts"]
    told = "the mapping was guessed (time, joint_positions, torques): look at the fact mapping"
    assert doubts[0] == told
    assert "torques: 1 numbers for 2 joints, left out" in doubts
    two = LogMapping(
        {**mapping.channels, "torques": Take(("a_pos", "b_pos"))}, joints=("a", "b"), guessed=True
    )
    log = log_from_source(table(**columns), two)
    assert (log.facts["joints"], log["torques"].shape) == (["a", "b"], (4, 2))
    alone = LogMapping({"time": Take(("time",)), "torques": Take(("fl_tau",))}, joints=("a",), guessed=True)
    assert log_from_source(table(**columns), alone).facts["joints"] == ["a"]


def test_friction_that_a_source_says_once_gives_way_to_an_array() -> None:
    source = table(x=TIMES, m=np.full(4, 0.7))
    source.facts = {"mu": 0.5, "mass": 3.0}
    log = log_of(source, energy=Take(("x",)))
    np.testing.assert_array_equal(log["mu"], [0.5] * 4)
    assert log.facts["mass"] == 3.0
    np.testing.assert_array_equal(log_of(source, mu=Take(("m",)))["mu"], [0.7] * 4)
