"""Rules on joints, each at the border of what it takes for a fault."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.mechanics.robot.lint.facts_by_hand import joint, link, offences, places, subject


def test_crossed_limits_are_told_with_their_unit() -> None:
    joints = [
        joint("knee", lower=0.5, upper=0.2),
        joint("shut", lower=0.5, upper=0.5),
        joint("slide", "prismatic", lower=0.5, upper=0.2),
        joint("wheel", "continuous", lower=0.5, upper=0.2),
    ]
    assert offences("limits-crossed", subject(joints)) == [
        ("joint knee", "lower 0.5 > upper 0.2 rad", "no angle is within both", ""),
        ("joint slide", "lower 0.5 > upper 0.2 m", "no angle is within both", ""),
    ]


def test_a_hinge_beyond_two_turns_limits_nothing() -> None:
    """Two turns are 12.566 rad."""
    joints = [
        joint("far", upper=12.6),
        joint("near", upper=12.5),
        joint("back", lower=-12.6),
        joint("half", lower=math.nan, upper=12.6),
        joint("none", upper=12.6, limited=False),
        joint("degrees", upper=90.0, lower=-90.0),
    ]
    assert offences("limits-absurd", subject(joints)) == [
        ("joint far", "range -1 to 12.6 rad", "beyond 12.6 rad it limits nothing", ""),
        ("joint back", "range -12.6 to 1 rad", "beyond 12.6 rad it limits nothing", ""),
        ("joint half", "range nan to 12.6 rad", "beyond 12.6 rad it limits nothing", ""),
    ]


def test_a_slide_beyond_ten_reaches_limits_nothing() -> None:
    """A reach of 0.5 m, and of a robot without any length 1 mm."""
    joints = [joint("far", "prismatic", 0.5, upper=5.1), joint("near", "prismatic", 0.5, upper=4.9)]
    assert offences("limits-absurd", subject(joints, [link("far_link")])) == [
        ("joint far", "range -1 to 5.1 m", "beyond 5 m it limits nothing", "")
    ]
    short = [
        joint("far", "prismatic", 0.0, lower=0.0, upper=0.011),
        joint("near", "prismatic", 0.0, lower=0.0, upper=0.009),
    ]
    assert places("limits-absurd", subject(short)) == ["joint far"]


@pytest.mark.parametrize(
    ("lower", "upper", "found"),
    [
        (-10.0, 10.0, False), (-11.0, 0.0, True), (0.0, 11.0, True), (-400.0, 0.0, True),
        (-401.0, 0.0, False), (-90.5, 90.0, False), (-90.0, 90.5, False), (-90.0, math.inf, False),
        (-math.inf, 90.0, False),
    ],
)  # fmt: skip
def test_whole_numbers_from_eleven_to_four_hundred_are_degrees(
    lower: float, upper: float, found: bool
) -> None:
    knee = joint("knee", lower=lower, upper=upper)
    value, why = f"range {lower:g} to {upper:g} rad", "whole numbers of that size are degrees"
    assert offences("limits-in-degrees", subject([knee])) == [("joint knee", value, why, "")] * found
    legs = subject([knee], legs=["knee"])
    assert offences("limits-in-degrees", legs) == [("joint knee", value, why, "error")] * found
    for other in (
        joint("knee", lower=lower, upper=upper, limited=False),
        joint("knee", "prismatic", lower=lower, upper=upper),
    ):
        assert not offences("limits-in-degrees", subject([other]))


def test_four_hinges_of_less_than_six_degrees_are_radians_read_as_degrees() -> None:
    """Six degrees are 0.1047 rad."""
    narrow = [joint(f"j{k}", lower=-0.1, upper=0.1) for k in range(4)]
    found = [
        (
            "joint j0", "range -0.1 to 0.1 rad",
            "all 4 hinges turn less than 6 deg: MJCF reads degrees unless compiler angle=radian", "error",
        )
    ]  # fmt: skip
    assert offences("limits-in-degrees", subject(narrow)) == found
    assert not offences("limits-in-degrees", subject(narrow[:3]))
    for wide in (joint("w", lower=-0.1, upper=0.11), joint("w", lower=-0.11, upper=0.1)):
        assert not offences("limits-in-degrees", subject([*narrow, wide]))
    others = [
        joint("shut", lower=0.5, upper=0.5), joint("free", limited=False), joint("slide", "prismatic"),
    ]  # fmt: skip
    assert offences("limits-in-degrees", subject([*others, *narrow])) == found


def test_a_range_is_missing_on_any_urdf_joint_and_on_an_mjcf_leg() -> None:
    joints = [joint("knee", limited=False), joint("tail", limited=False), joint("hip")]
    assert offences("limits-missing", subject(joints)) == [
        (f"joint {name}", "no <limit>", "URDF has none to leave out there", "error")
        for name in ("knee", "tail")
    ]
    assert offences("limits-missing", subject(joints, format="mjcf", legs=["knee", "hip"])) == [
        ("joint knee", "no range", "the leg may fold through itself", "")
    ]


def test_a_range_of_no_width_is_shut() -> None:
    joints = [
        joint("at", lower=0.3, upper=0.3), joint("none", lower=math.nan, upper=math.nan),
        joint("low", lower=math.nan, upper=0.0), joint("high", lower=math.nan, upper=0.1),
        joint("free", lower=0.3, upper=0.3, limited=False), joint("slide", "prismatic", lower=0.2, upper=0.2),
    ]  # fmt: skip
    found = offences("limits-shut", subject(joints))
    why = "it cannot move by its file, and worlds here take it as without limit"
    assert found == [
        ("joint at", "range 0.3 to 0.3 rad", why, ""), ("joint none", "range 0 to 0 rad", why, ""),
        ("joint low", "range 0 to 0 rad", why, ""), ("joint slide", "range 0.2 to 0.2 m", why, ""),
    ]  # fmt: skip


def test_efforts_and_speeds_of_nothing_are_missing_in_a_urdf() -> None:
    joints = [
        joint("zero", effort=0.0, speed=0.0), joint("none", effort=math.nan, speed=math.nan),
        joint("given"), joint("back", speed=-5.0), joint("fixed", "fixed", effort=0.0, speed=0.0),
        joint("free", "continuous", effort=0.0, speed=0.0, limited=False),
    ]  # fmt: skip
    why = "taken as without limit: no verdict counts its motor"
    assert offences("effort-missing", subject(joints)) == [
        ("joint zero", "effort 0", why, ""),
        ("joint none", "no effort", why, ""),
    ]
    assert offences("speed-missing", subject(joints)) == [
        ("joint zero", "velocity 0", "taken as without limit", ""),
        ("joint none", "no velocity", "taken as without limit", ""),
    ]
    assert not offences("effort-missing", subject(joints, format="mjcf"))
    assert not offences("speed-missing", subject(joints, format="mjcf"))
    assert offences("speed-negative", subject(joints)) == [
        ("joint back", "velocity -5", "no speed limit is below zero", "")
    ]


def test_efforts_are_measured_by_what_lifts_the_robot() -> None:
    """10 kg and 0.5 m: 98.1 N and 49.05 N m."""
    joints = [
        joint("strong", length=0.5, effort=1000.0), joint("fair", length=0.5, effort=980.0),
        joint("weak", length=0.5, effort=0.04), joint("able", length=0.5, effort=0.06),
        joint("tail", length=0.5, effort=0.04), joint("none", length=0.5, effort=0.0),
        joint("endless", length=0.5, effort=math.inf), joint("bare", length=0.5, effort=math.nan),
        joint("back", length=0.5, effort=-1.0), joint("fixed", "fixed", 0.5, effort=-1.0),
        joint("slide", "prismatic", 0.5, effort=1990.0), joint("lift", "prismatic", 0.5, effort=1950.0),
    ]  # fmt: skip
    about = subject(joints, [link("trunk", 10.0), link("weak_link", 0.0)], legs=["weak", "able", "none"])
    assert offences("effort-absurd", about) == [
        ("joint strong", "effort 1000 N m", "20.4 times what lifts the robot: no limit", ""),
        ("joint weak", "effort 0.04 N m", "0.00082 of what lifts the robot: it holds no leg", ""),
        ("joint back", "effort -1 N m", "no motor has a limit below zero", "error"),
        ("joint slide", "effort 1990 N", "20.3 times what lifts the robot: no limit", ""),
    ]
    assert not offences("effort-absurd", subject(joints[:1]))  # nothing is known of a robot without a mass


def test_an_axis_shorter_than_a_millionth_points_nowhere() -> None:
    joints = [
        joint("none", axis=np.zeros(3)), joint("tiny", axis=np.array([0.0, 5e-7, 0.0])),
        joint("small", axis=np.array([0.0, 2e-6, 0.0])), joint("fixed", "fixed", axis=np.zeros(3)),
    ]  # fmt: skip
    assert offences("axis-zero", subject(joints)) == [
        ("joint none", "axis (0, 0, 0)", "it points nowhere", ""),
        ("joint tiny", "axis (0, 5e-07, 0)", "it points nowhere", ""),
    ]


def posed(q: float, low: float, high: float, **other: Any) -> Any:
    """Return a robot with a base of seven coordinates and a joint at `q` between `low` and `high`."""
    joints = [SimpleNamespace(nq=0), SimpleNamespace(nq=7, idx_q=0), SimpleNamespace(nq=1, idx_q=7)]
    model = SimpleNamespace(
        names=["universe", "root", "knee"], joints=joints,
        lowerPositionLimit=np.array([*np.zeros(7), low]), upperPositionLimit=np.array([*np.zeros(7), high]),
    )  # fmt: skip
    given = {"floating": True, "feet": ["foot"]} | other
    return SimpleNamespace(model=model, nominal=np.array([*np.ones(7), q]), **given)


@pytest.mark.parametrize(
    ("q", "found"), [(0.5009, False), (0.502, True), (1.0, True), (-0.5009, False), (-0.502, True)]
)
def test_a_nominal_pose_is_outside_beyond_a_thousandth(q: float, found: bool) -> None:
    told = [
        (
            "joint knee", f"{q:.4g} outside -0.5 to 0.5",
            f"the nominal pose is {abs(q) - 0.5:.3g} beyond the range, against which an engine would push",
            "",
        )
    ]  # fmt: skip
    assert offences("pose-outside-limits", subject(robot=posed(q, -0.5, 0.5))) == told * found


def test_a_pose_counts_only_where_feet_or_a_pedestal_give_one() -> None:
    for robot, found in (
        (posed(1.0, -0.5, 0.5, feet=[]), False),
        (posed(1.0, -0.5, 0.5, feet=[], floating=False), True),
        (posed(1.0, 0.5, 0.5), False),
        (None, False),
    ):
        assert bool(offences("pose-outside-limits", subject(robot=robot))) is found


@pytest.mark.parametrize(
    ("length", "ratio"), [(3.1, "31"), (2.9, ""), (31.0, "310"), (0.1 / 31, "0.0323"), (0.1 / 29, "")]
)
def test_an_offset_thirty_times_its_twin_s_is_named_and_its_twin_is_not(length: float, ratio: str) -> None:
    joints = [joint("left_hip"), joint("right_hip", length=length), joint("neck"), joint("tail")]
    told = [
        ("joint right_hip", f"origin (0, 0, {length:.3g}) m", f"{ratio} times that of left_hip", "")
    ] * bool(ratio)
    assert offences("offset-unlike-kin", subject(joints)) == told


def test_an_offset_of_nothing_has_no_ratio() -> None:
    joints = [joint("left_hip"), joint("right_hip", length=0.0), joint("neck"), joint("tail")]
    assert not offences("offset-unlike-kin", subject(joints))


def test_an_offset_thirty_times_all_others_together_is_in_millimetres() -> None:
    others = [joint("neck"), joint("tail"), joint("lost", origin=np.array([math.nan, 0.0, 0.0]))]
    told = [("joint arm", "origin (0, 0, 6.2) m", "31 times all others together; is it in millimetres?", "")]
    assert offences("offset-unlike-kin", subject([*others, joint("arm", length=6.2)])) == told
    for quiet in (
        [*others, joint("arm", length=5.8)], [others[0], joint("arm", length=6.2)],
        [*others, joint("arm", "floating", length=6.2)], [*others, joint("arm", length=6.2, parent="world")],
        [*others, joint("arm", length=6.2, parent="")],
        [joint("neck", length=0.0), joint("tail", length=0.0), joint("arm", length=6.2)],
    ):  # fmt: skip
        assert not offences("offset-unlike-kin", subject(quiet))


@pytest.mark.parametrize(
    ("key", "unit", "own", "found"),
    [
        ("effort", "N m", 9.0, True), ("effort", "N m", 9.2, False), ("effort", "N m", 0.34, True),
        ("effort", "N m", 0.32, False), ("effort", "N m", 0.0, False), ("speed", "rad/s", 9.0, True),
        ("speed", "rad/s", 9.2, False), ("speed", "rad/s", -1.0, False),
    ],
)  # fmt: skip
def test_the_weaker_of_two_sides_is_named_from_a_tenth(key: str, unit: str, own: float, found: bool) -> None:
    joints = [joint("left_hip"), joint("right_hip")]
    setattr(joints[0], key, 10.0)
    setattr(joints[1], key, own)
    told = [("joint right_hip", f"{key} {own:g} {unit}", "left_hip has 10", "")] * found
    assert offences("sides-differ", subject(joints)) == told


def test_sides_that_do_not_move_or_have_no_limit_are_alike() -> None:
    endless = [joint("left_hip", effort=math.inf), joint("right_hip")]
    fixed = [joint("left_hip", "fixed", effort=20.0), joint("right_hip", "fixed")]
    free = [joint("left_hip", lower=-2.0), joint("right_hip", limited=False)]
    for joints in (endless, fixed, free):
        assert not offences("sides-differ", subject(joints))


@pytest.mark.parametrize(
    ("usual", "own", "found"), [(1.0, 0.9, True), (1.0, 0.92, False), (12.5, 10.0, True), (12.6, 10.0, False)]
)
def test_the_narrower_of_two_sides_is_named_below_four_turns(usual: float, own: float, found: bool) -> None:
    joints = [joint("left_hip", lower=-usual, upper=usual), joint("right_hip", lower=-own, upper=own)]
    told = [
        ("joint right_hip", f"range {-own:g} to {own:g} rad", f"left_hip has {-usual:g} to {usual:g}", "")
    ]
    assert offences("sides-differ", subject(joints)) == told * found
