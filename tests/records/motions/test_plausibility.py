"""Plausibility of motions: every part by hand on a robot of two feet without legs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

from surefoot.records.motions.plausibility import Plausibility, Ranges, judge, ranges_of, sample_pairs

CORNERS = np.array([[0.1, 0.1, 0.0], [0.1, -0.1, 0.0], [-0.1, -0.1, 0.0], [-0.1, 0.1, 0.0]])
REST = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])


def two_feet(centres: Any = CORNERS, feet: int = 2) -> Any:
    """Return a floating base with a foot that slides along x and one that pitches about y."""
    model = pinocchio.Model()
    base = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root")
    at = pinocchio.SE3(np.eye(3), np.array([0.0, 0.3, -0.5]))
    slide = model.addJoint(base, pinocchio.JointModelPX(), at, "slide")
    at = pinocchio.SE3(np.eye(3), np.array([0.0, -0.3, -0.5]))
    pitch = model.addJoint(base, pinocchio.JointModelRY(), at, "pitch")
    frames = [
        model.addFrame(pinocchio.Frame(f"foot {k}", k, 0, pinocchio.SE3.Identity(), pinocchio.FrameType.BODY))
        for k in (slide, pitch)
    ]
    made = [SimpleNamespace(frame=k, centres=centres, flat=len(centres) >= 3) for k in frames[:feet]]
    return SimpleNamespace(model=model, floating=True, feet=made, joints=2)


WIDE = Ranges(np.zeros(2), np.ones(2))


def pairs(q: Any) -> Any:
    first = np.arange(len(q) - 1)
    return first, first + 1


def judged(q: Any, robot: Any = None) -> Plausibility:
    robot = robot or two_feet()
    return judge(robot, WIDE, np.asarray(q), pairs(q))


def test_the_cost_weighs_slide_centre_and_lean() -> None:
    one = Plausibility(tilt=0.1, slide=0.02, excess=0.3, centre=0.04, lean=0.005)
    assert one.cost == pytest.approx(0.1 + 0.3 + 5.0 * 0.02 + 3.0 * 0.04 + 0.5 * 0.005)
    far = Plausibility(tilt=0.0, slide=0.0, excess=9.0, centre=7.0, lean=0.0)
    assert far.cost == pytest.approx(5.0 + 3.0 * 2.0)


def test_the_parts_are_told_in_percent_degrees_and_radians() -> None:
    text = str(Plausibility(tilt=0.5, slide=0.872, excess=0.456, centre=0.0, lean=0.0))
    assert "moves 87 % of what feet and base move and tilts 29°" in text
    assert text.endswith("joints leave their ranges by 0.46 rad")


def test_the_excess_of_angles_is_what_lies_beyond_either_end() -> None:
    ranges = Ranges(np.array([1.0, 0.0]), np.array([0.5, 2.0]))
    np.testing.assert_allclose(ranges.excess(np.array([[1.7, 1.9], [0.2, -2.3]])), [[0.2, 0.0], [0.3, 0.3]])


def test_columns_cost_by_their_place_in_each_range() -> None:
    ranges = Ranges(np.array([0.0, 1.0]), np.array([1.0, 0.5]))
    columns = np.array([[0.5, 1.25], [-0.5, 0.75]])
    # each place in each range: 0.5 and 1.25 in [-1, 1], then 0.5 and 1.25 in [0.5, 1.5], over two rows
    squares = np.array([[[0.25, 1.0], [1.5625, 0.25]], [[0.25, 2.0], [0.5625, 0.25]]])
    beyond = np.array([[[0.0, 0.0], [0.25, 0.0]], [[0.0, 1.0], [0.0, 0.0]]])
    expected = (3.0 * squares / 2.0 + beyond).mean(axis=0)
    np.testing.assert_allclose(ranges.column_costs(columns), expected)


def test_columns_are_judged_by_a_hundred_and_twenty_frames_evenly_over_them() -> None:
    ranges = Ranges(np.zeros(1), np.ones(1))
    columns = np.zeros((1191, 1))
    columns[::10] = 1.0  # frames 0, 10, ... 1190: all that are looked at
    np.testing.assert_allclose(ranges.column_costs(columns), [[3.0]])
    np.testing.assert_allclose(ranges.column_costs(columns[:3]), [[1.0]])


def test_ranges_are_the_models_and_a_turn_where_it_has_none() -> None:
    robot = two_feet()
    low, high = robot.model.lowerPositionLimit, robot.model.upperPositionLimit
    for limits, middle, half in (
        ((-0.5, 1.5), 0.5, 1.0),
        ((0.2, 0.26), 0.23, 0.05),  # narrow ones are widened
        ((-np.inf, 1.0), 0.0, np.pi),
        ((-1.0, np.inf), 0.0, np.pi),
        ((1.0, 1.0), 0.0, np.pi),
        ((1.0, 0.5), 0.0, np.pi),
        ((0.0, 12.5), 6.25, 6.25),
        ((8.0, 12.0), 10.0, 2.0),
        ((0.0, 12.6), 0.0, np.pi),
    ):
        low[7:], high[7:] = [limits[0], -1.0], [limits[1], 3.0]
        robot.model.lowerPositionLimit, robot.model.upperPositionLimit = low, high
        ranges = ranges_of(robot)
        np.testing.assert_allclose(ranges.middle, [middle, 1.0])
        np.testing.assert_allclose(ranges.half, [half, 2.0])


def test_pairs_are_a_fifteenth_of_a_second_apart() -> None:
    for count, rate, apart in (
        (301, 60.0, 4),
        (301, 150.0, 10),
        (301, 15.0, 2),  # never less than two frames
        (301, None, 2),
        (30, 300.0, 10),  # nor more than a third of the motion
        (2, None, 1),
    ):
        first, second = sample_pairs(count, rate)
        assert set(second - first) == {apart}
        assert first[0] == 0
        assert second[-1] == count - 1


def test_pairs_are_at_most_a_hundred_and_twenty_evenly_spread() -> None:
    first, _ = sample_pairs(1193, None)
    assert first.tolist() == list(range(0, 1191, 10))
    first, _ = sample_pairs(10, None)
    assert first.tolist() == [0, 1, 2, 3, 4, 5, 6, 7]


def test_angles_are_judged_in_the_first_frame_of_each_pair() -> None:
    q = np.tile(REST, (3, 1))
    q[:, 7], q[:, 8] = [0.5, 1.5, 9.0], [0.0, -1.2, 9.0]
    one = judged(q)
    assert one.excess == pytest.approx((0.5 + 0.2) / 2)
    assert one.centre == pytest.approx((0.5**2 + 1.5**2 + 1.2**2) / 4)


def test_places_in_the_ranges_are_counted_in_halves_from_their_middles() -> None:
    q, ranges = np.tile(REST, (2, 1)), Ranges(np.array([0.5, -1.0]), np.array([0.25, 2.0]))
    q[0, 7:] = [0.6, 2.0]
    one = judge(two_feet(), ranges, q, pairs(q))
    assert one.centre == pytest.approx((0.4**2 + 1.5**2) / 2)
    assert one.excess == pytest.approx(1.0)


def test_a_robot_that_is_bolted_down_is_judged_by_its_angles_alone() -> None:
    robot = two_feet()
    model = pinocchio.Model()
    for k in range(2):
        model.addJoint(k, pinocchio.JointModelRY(), pinocchio.SE3.Identity(), f"{k}")
    robot.model, robot.floating = model, False
    one = judge(robot, WIDE, np.array([[1.5, 0.5], [0.0, 0.0]]), pairs(np.zeros((2, 2))))
    assert one == Plausibility(0.0, 0.0, 0.5, (1.5**2 + 0.5**2) / 2, 0.0)


def test_the_lean_is_one_less_the_cosine_of_the_tilt() -> None:
    q = np.tile(REST, (4, 1))
    for row, angles in zip(
        q, ((0.3, 0.0, 0.0), (0.0, 0.5, 1.0), (0.3, 0.4, 2.0), (0.0, 0.0, 0.0)), strict=True
    ):
        row[3:7] = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(*angles)).coeffs()
    expected = np.median(1.0 - np.array([np.cos(0.3), np.cos(0.5), np.cos(0.3) * np.cos(0.4)]))
    assert judged(q).lean == pytest.approx(expected)
    footless = judged(q, two_feet(feet=0))
    assert footless == Plausibility(0.0, 0.0, 0.0, 0.0, footless.lean)
    assert footless.lean == pytest.approx(expected)


def test_the_tilt_is_that_of_the_flattest_sole() -> None:
    q = np.tile(REST, (4, 1))
    roll = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(0.2, 0.0, 0.0)).coeffs()
    q[:, 3:7] = roll
    q[:, 8] = [0.0, 0.3, 0.6, 0.0]
    assert judged(q).tilt == pytest.approx(0.2)
    q = np.tile(REST, (4, 1))
    lean = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(0.0, 0.3, 0.0)).coeffs()
    q[:, 3:7], q[:, 8] = lean, [-0.1, -0.2, -0.25, -0.3]
    assert judged(q).tilt == pytest.approx(0.1)
    assert judged(q, two_feet(CORNERS[:1])).tilt == 0.0


def test_the_slide_is_the_share_of_the_foot_that_moves_least() -> None:
    q = np.tile(REST, (3, 1))
    q[:, 0] = [0.0, 0.03, 0.06]  # the base and the foot that pitches go forward
    q[:, 7] = [0.0, -0.02, -0.04]  # the other one by a third of that
    assert judged(q).slide == pytest.approx(0.01 / (0.03 + 0.03 + 0.01 + 0.002))


def test_a_foot_moves_as_its_corners_do_on_the_average() -> None:
    turn, lever = 0.2, 0.1
    q = np.tile(REST, (2, 1))
    q[1, 8] = turn  # every corner is 0.1 from the axis of pitch
    q[:, 7] = [0.0, 0.5]
    chord = 2.0 * lever * np.sin(turn / 2.0)
    assert judged(q).slide == pytest.approx(chord / (chord + 0.5 + 0.002))


def test_a_foot_that_turns_back_as_the_base_goes_on_moves_less() -> None:
    q = np.tile(REST, (2, 1))
    q[1, [0, 7, 8]] = 0.05, 0.5, 0.4
    moved = np.hypot(0.05 - 0.1 * np.sin(0.4), 0.1 * (1.0 - np.cos(0.4)))
    one = judged(q, two_feet(np.array([[0.0, 0.0, -0.1]])))
    assert one.slide == pytest.approx(moved / (moved + 0.55 + 0.05 + 0.002))


def test_pairs_that_move_less_than_half_of_the_middle_tell_nothing() -> None:
    q = np.tile(REST, (6, 1))
    # of each step the base moves 1 and the foot that slides does not, or in the last one both do
    steps = np.array([0.1, 0.1, 0.1, 0.045, 0.045])
    q[1:, 0] = np.cumsum(steps)
    q[1:, 7] = np.cumsum([-0.1, -0.08, -0.06, 0.0, 0.0])
    parts = np.array([0.0, 0.02 / 0.222, 0.04 / 0.242])
    # the last two move by 0.135 each: more than half of the middle, 0.22 / 2
    parts = np.append(parts, [0.045 / 0.137] * 2)
    assert judged(q).slide == pytest.approx(np.median(parts))
    q[4:, 0] = q[3, 0] + np.array([0.03, 0.06])  # 0.09 each: less than half
    assert judged(q).slide == pytest.approx(np.median(parts[:3]))
