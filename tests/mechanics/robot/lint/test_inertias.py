"""Rules on masses and inertias, each at the border of what it takes for a fault."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from surefoot.mechanics.robot.lint.facts import LinkFacts, ShapeFacts
from tests.mechanics.robot.lint.facts_by_hand import joint, link, offences, places, subject

REACH = [joint("neck", length=0.5, child="head")]
"""A joint that makes a reach of half a metre."""


def with_trace(name: str, mass: float, trace: float) -> LinkFacts:
    """Return a link whose moments have a sum [kg m²]."""
    return link(name, mass, (trace / 3.0, trace / 3.0, trace / 3.0))


def test_a_mass_below_zero_is_none() -> None:
    assert offences("mass-negative", subject((), [link("a", -0.2), link("b", 0.0), link("c")])) == [
        ("link a", "mass -0.2 kg", "no body has a mass below zero", "")
    ]


@pytest.mark.parametrize(
    ("calf", "foot", "kind", "found"),
    [
        (0.0, 0.0, "revolute", True), (0.0, 0.1, "revolute", False), (0.1, 0.0, "revolute", False),
        (0.0, -0.1, "revolute", True), (-0.1, 0.1, "revolute", False), (0.0, 0.0, "fixed", False),
    ],
)  # fmt: skip
def test_a_joint_must_move_some_mass(calf: float, foot: float, kind: str, found: bool) -> None:
    joints = [
        joint("knee", kind, child="calf"), joint("ankle", "fixed", parent="calf", child="foot"),
        joint("gone", child="nowhere"),
    ]  # fmt: skip
    links = [link("trunk"), link("calf", calf), link("foot", foot)]
    why = "joint knee moves no mass at all, and a simulated world refuses the robot"
    for legs, severity in (([], ""), (["knee"], "error")):
        told = [("link calf", "mass 0 kg", why, severity)] * found
        assert offences("mass-missing", subject(joints, links, legs=legs)) == told


@pytest.mark.parametrize(("trunk", "found"), [(450.0, True), (550.0, False)])
def test_a_limb_without_the_mass_of_its_kin_is_named_where_that_counts(trunk: float, found: bool) -> None:
    links = [link("trunk", trunk), link("left_calf", 0.0), link("right_calf", 0.5)]
    told = [("link left_calf", "mass 0 kg", "right_calf has 0.5 kg", "error")] * found
    assert offences("mass-missing", subject((), links)) == told


@pytest.mark.parametrize(("mass", "ratio"), [(31.0, "31"), (29.0, ""), (1.0 / 31, "0.0323"), (1.0 / 29, "")])
def test_a_mass_thirty_times_its_kin_s_is_named_and_its_kin_is_not(mass: float, ratio: str) -> None:
    links = [link("trunk"), link("head"), link("left_arm"), link("right_arm", mass)]
    told = [("link right_arm", f"mass {mass:g} kg", f"{ratio} times that of left_arm", "")] * bool(ratio)
    assert offences("mass-unlike-kin", subject((), links)) == told


def test_masses_of_shapes_and_of_nothing_have_no_kin() -> None:
    for other in ({"inertial": False}, {"mass": 0.0}, {"mass": -31.0}):
        links = [link("trunk"), link("head"), link("left_arm"), link("right_arm", **({"mass": 31.0} | other))]
        assert not offences("mass-unlike-kin", subject((), links))
    assert not offences("mass-unlike-kin", subject())


@pytest.mark.parametrize(
    ("mass", "trace", "found"),
    [(1e-3, 0.5, True), (1e-3, 0.4, False), (1.0, 500.0, False), (1e-3, -0.5, False)],
)
def test_a_radius_of_gyration_of_thirty_reaches_is_a_lost_mass(
    mass: float, trace: float, found: bool
) -> None:
    """sqrt(0.25 / 0.001) m beside a reach of 0.5 m."""
    links = [link("trunk"), link("head"), with_trace("tip", mass, trace)]
    why = "its inertia is that of a heavier body: a radius of gyration of 15.8 m"
    assert (
        offences("mass-unlike-kin", subject(REACH, links)) == [("link tip", "mass 0.001 kg", why, "")] * found
    )
    assert not offences("mass-unlike-kin", subject((), links))  # without any reach


@pytest.mark.parametrize(("mass", "ratio"), [(510.0, "51"), (490.0, "")])
def test_a_body_of_fifty_times_all_others_is_named(mass: float, ratio: str) -> None:
    """The link that weighs most of those that are welded together, with the mass of all of them."""
    joints = [joint("weld", "fixed", child="box"), joint("a", child="a"), joint("b", child="b")]
    links = [link("trunk", 1.0), link("box", mass - 1.0), link("a", 5.0), link("b", 5.0)]
    why = f"{ratio} times all other bodies together"
    for robot, severity in (
        (None, ""), (SimpleNamespace(floating=True), ""), (SimpleNamespace(floating=False), "warning")
    ):  # fmt: skip
        told = [("link box", f"mass {mass - 1.0:g} kg", why, severity)] * bool(ratio)
        assert offences("mass-unlike-kin", subject(joints, links, robot=robot)) == told
    two = subject(joints[:2], [link("trunk", 1.0), link("box", 599.0), link("a", 5.0)])
    assert not offences("mass-unlike-kin", two)
    below = subject(joints, [*links[:2], link("a", -5.0), link("b", 5.0)])
    assert not offences("mass-unlike-kin", below)  # a mass below zero is no body's


@pytest.mark.parametrize(("mass", "found"), [(9e-8, True), (2e-7, False), (0.0, False)])
def test_a_body_of_a_ten_millionth_of_the_usual_is_weightless(mass: float, found: bool) -> None:
    for name, counts in (("tip", True), ("world", False)):
        links = [link("trunk", 10.0), link("a"), link("b"), link(name, mass, 3 * (1e-12,))]
        told = [(f"link {name}", "mass 9e-08 kg", "9e-08 times that of usual bodies", "")]
        joints = [joint(one.name, child=one.name) for one in links[1:]]
        assert offences("mass-unlike-kin", subject(joints, links)) == told * (found and counts)


@pytest.mark.parametrize(
    ("least", "found"), [(-0.1, True), (-2e-7, True), (-5e-8, False), (0.0, False), (math.nan, False)]
)
def test_a_moment_below_zero_is_none_beyond_a_millionth_of_the_largest(least: float, found: bool) -> None:
    value, why = f"inertia {least:g} kg m²", f"principal moments ({least:.3g}, 0.1, 0.1): one is negative"
    moments = (0.1, 0.1, least)
    about = subject((), [link("a", 1.0, moments)])
    assert offences("inertia-negative", about) == [("link a", value, why, "")] * found
    for other in (link("a", 1.0, moments, inertial=False), link("a", 0.0, moments), link("a", -1.0, moments)):
        assert not offences("inertia-negative", subject((), [other]))


def test_moments_of_nothing_may_be_negative_by_rounding() -> None:
    links = [link("a", 1.0, (0.0, 0.0, -5e-19)), link("b", 1.0, (0.0, 0.0, -5e-18))]
    assert places("inertia-negative", subject((), links)) == ["link b"]


def test_principal_moments_are_those_of_the_symmetric_part() -> None:
    """[[2, 1], [1, 2]] has 1 and 3: the triangle 1 + 1 < 3 is broken, by half."""
    tensor = np.array([[2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]])
    body = LinkFacts("a", 1.0, inertia=tensor, inertial=True)
    why = "of the moments (1, 1, 3) the largest is 1.5 times the sum of the others"
    assert offences("inertia-triangle", subject((), [body])) == [("link a", "inertia 3 kg m²", why, "")]


@pytest.mark.parametrize(
    ("moments", "severity"),
    [
        ((1.0, 1.0, 2.003), ""), ((1.0, 1.0, 2.001), None), ((1.0, 1.0, 20.1), "error"),
        ((1.0, 1.0, 19.9), ""), ((0.0, 1.0, 2.0), None), ((math.nan, 1.0, 3.0), None),
    ],
)  # fmt: skip
def test_a_triangle_is_broken_by_a_thousandth_and_grossly_tenfold(
    moments: tuple[float, float, float], severity: str | None
) -> None:
    links = [link("a", 1.0, moments), link("b", 1.0, moments, inertial=False)]
    found = offences("inertia-triangle", subject((), links))
    assert [(place, told) for place, _, _, told in found] == [("link a", severity)] * (severity is not None)
    refused = offences("inertia-triangle", subject((), links, refusal="MuJoCo says no"))
    assert [told for *_, told in refused] == ["error"] * (severity is not None)


@pytest.mark.parametrize(
    ("mass", "trace", "trunk", "ratio", "severity"),
    [
        (1.0, 0.93, 1.0, "31", ""), (1.0, 0.87, 1.0, "", ""), (1.0, 0.03 / 31, 1.0, "0.0323", ""),
        (1.0, 0.03 / 29, 1.0, "", ""), (1.0, 0.03 / 31, 20.0, "0.0323", "warning"),
        (1.0, 0.93, 20.0, "31", ""), (1.0, 0.93, 1100.0, "31", "warning"), (0.01, 0.03, 1.0, "", ""),
    ],
)  # fmt: skip
def test_an_inertia_unlike_its_kin_s_is_named_unless_the_mass_alone_is(
    mass: float, trace: float, trunk: float, ratio: str, severity: str
) -> None:
    links = [
        with_trace("trunk", trunk, 0.03 * trunk), with_trace("head", 1.0, 0.03),
        with_trace("left_arm", 1.0, 0.03), with_trace("right_arm", mass, trace),
    ]  # fmt: skip
    value = f"inertia ({', '.join(3 * [f'{trace / 3.0:.3g}'])}) kg m²"
    told = [("link right_arm", value, f"{ratio} times that of left_arm, by mass", severity)] * bool(ratio)
    assert offences("inertia-unlike-kin", subject((), links)) == told
    assert not offences("inertia-unlike-kin", subject())


@pytest.mark.parametrize(
    ("mass", "trace", "trunk", "why", "severity"),
    [
        (1.0, 0.75, 2.0, "its radius of gyration, 0.612 m, is 1.22 times the robot's reach", ""),
        (1.0, 0.70, 2.0, "", ""),
        (1.0, 0.75, 17.0, "its radius of gyration, 0.612 m, is 1.22 times the robot's reach", ""),
        (1.0, 0.75, 20.0, "its radius of gyration, 0.612 m, is 1.22 times the robot's reach", "warning"),
        (1.0, 4e-7, 2.0, "its radius of gyration is 0.447 mm, a point beside a reach of 0.5 m", ""),
        (1.0, 6e-7, 2.0, "", ""),
        (1.0, 4e-7, 20.0, "its radius of gyration is 0.447 mm, a point beside a reach of 0.5 m", "warning"),
        (1.0, 4e-7, 120.0, "", ""),
        (1e-3, 0.5, 2.0, "", ""),  # the mass is what is wrong
        (3.0, 1500.0, 2.0, "its radius of gyration, 15.8 m, is 31.6 times the robot's reach", ""),
    ],
)
def test_a_radius_of_gyration_goes_with_the_robot_s_reach(
    mass: float, trace: float, trunk: float, why: str, severity: str
) -> None:
    links = [
        with_trace("trunk", trunk, 0.01 * trunk),
        with_trace("head", 0.5, 0.03),
        with_trace("a", mass, trace),
    ]
    value = f"inertia ({', '.join(3 * [f'{trace / 3.0:.3g}'])}) kg m²"
    found = offences("inertia-unlike-kin", subject(REACH, links))
    assert found == [("link a", value, why, severity)] * bool(why)
    assert not offences("inertia-unlike-kin", subject((), links))


def test_a_fault_of_kin_is_told_once() -> None:
    """Thirty-one times the inertia of the other arm, and beyond the robot's reach as well."""
    links = [link("trunk"), link("head"), link("left_arm"), with_trace("right_arm", 1.0, 1.0)]
    assert places("inertia-unlike-kin", subject(REACH, links)) == ["link right_arm"]


@pytest.mark.parametrize(
    ("size", "far", "found"), [(0.0, 1.6, True), (0.0, 1.4, False), (0.1, 3.2, True), (0.1, 2.8, False)]
)
def test_a_centre_of_mass_three_reaches_away_is_far(size: float, far: float, found: bool) -> None:
    """Beside joint offsets of 0.5 m, or of ten times the link's own size."""
    lost = joint("lost", origin=np.array([math.nan, 0.0, 0.0]))
    calf = link("calf", com=np.array([0.0, 0.0, far]))
    boxes = [ShapeFacts("calf", "box", (size, 0.01, 0.01), True)] * bool(size)
    why = f"{far / 0.5:.3g} times all joint offsets of the robot together; is it in millimetres?"
    told = [("link calf", f"centre of mass (0, 0, {far:g}) m", why, "")] * found
    assert offences("com-far", subject([*REACH, lost], [calf], shapes=boxes)) == told
    for quiet in (link("calf", com=calf.com, inertial=False), link("calf", com=np.full(3, math.nan))):
        assert not offences("com-far", subject(REACH, [quiet]))
    assert not offences("com-far", subject((), [calf]))
