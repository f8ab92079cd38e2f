"""The rate of a motion: by its times, its velocities and its falls, each judged by hand-made numbers."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.records.motions.fields import MotionFields
from surefoot.records.motions.rates import Falls, falls_of, find_rate, rate_by_speeds, stated_rate

G = 9.81


@dataclass
class Ball:
    """A free body with its centre of mass at its origin; the first column is the height of its foot."""

    floating: bool = True
    feet: tuple[str, ...] = ("foot",)

    def __post_init__(self) -> None:
        self.model = pinocchio.Model()
        joint = self.model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root")
        sphere = pinocchio.Inertia.FromSphere(2.0, 0.1)
        self.model.appendBodyToJoint(joint, sphere, pinocchio.SE3.Identity())
        self.nominal = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])

    def sphere_bottoms(self, row: Any) -> Any:
        return np.array([row[0] + 0.5, row[0]])


BALL: Any = Ball()
FIXED: Any = Ball(floating=False)


def jumps(bends: Any, length: int = 12, stance: int = 4, base: float = 3.0) -> Any:
    """Return configurations that leave the ground once for each bend [m per frame squared]."""
    parts = []
    for bend in bends:
        t = np.arange(length)
        parts += [np.tile([0.0, base], (stance, 1)), np.stack([np.ones(length), base - 0.5 * bend * t**2], 1)]
    low, height = np.vstack([*parts, np.tile([0.0, base], (stance, 1))]).T
    q = np.zeros((len(low), 7))
    q[:, 0], q[:, 2], q[:, 6] = low, height, 1.0
    return q


def bends(*rates: float) -> list[float]:
    """Return how much the centre of mass falls per frame squared at some rates."""
    return [G / rate**2 for rate in rates]


def fields(**more: Any) -> MotionFields:
    return MotionFields("", np.zeros((5, 1)), **more)


def moving(rate: float) -> MotionFields:
    """Return a joint that moves as its velocities say at a rate."""
    t = np.arange(9) / rate
    return MotionFields("", (t**2)[:, None], speeds=(2.0 * t)[:, None])


def test_falls_are_the_second_differences_of_the_height() -> None:
    falls = falls_of(BALL, jumps([0.004, 0.02], length=9))
    np.testing.assert_allclose(falls.accelerations, [0.004, 0.02], rtol=1e-9)
    assert falls.frames.tolist() == [9, 9]
    assert falls.frames.dtype == np.int64


@pytest.mark.parametrize(("length", "cut"), [(5, 0), (7, 0), (8, 1), (15, 1)])
def test_first_and_last_frame_of_a_phase_are_left_out_where_it_has_eight(length: int, cut: int) -> None:
    q = jumps([0.01], length)
    wave = 1e-3 * np.sin(2.3 * np.arange(length) + 0.4)
    q[4 : 4 + length, 2] += wave
    heights = q[4 + cut : 4 + length - cut, 2]
    expected = -2.0 * np.polyfit(np.arange(len(heights)), heights, 2)[0]
    assert falls_of(BALL, q).accelerations == pytest.approx([expected], rel=1e-9)


def test_phases_of_four_frames_tell_nothing() -> None:
    assert len(falls_of(BALL, jumps([0.01], 4)).frames) == 0
    assert len(falls_of(BALL, jumps([0.01], 5, stance=1)).frames) == 1
    assert len(falls_of(BALL, jumps([0.01], 5, stance=1)[:-1]).frames) == 0


def test_phases_that_begin_or_end_beyond_the_motion_tell_nothing() -> None:
    q = jumps([0.01, 0.01, 0.01])
    assert len(falls_of(BALL, q[5:]).frames) == 2
    assert len(falls_of(BALL, q[:-5]).frames) == 2
    assert len(falls_of(BALL, q[3:-3]).frames) == 3


@pytest.mark.parametrize(("share", "count"), [(0.093, 1), (0.107, 0)])
def test_a_tenth_of_the_rise_may_be_left_beside_a_parabola(share: float, count: int) -> None:
    length, bend = 12, 0.01
    t = np.arange(length - 2)
    wave = np.cos(1.7 * t)
    wave -= np.polyval(np.polyfit(t, wave, 2), t)
    wave *= share * bend * len(t) ** 2 / 8.0 / np.sqrt((wave**2).mean())
    q = jumps([bend], length)
    q[5 : 3 + length, 2] += wave
    assert len(falls_of(BALL, q).frames) == count


@pytest.mark.parametrize(("bend", "count"), [(0.5e-4, 0), (2e-4, 1), (-0.01, 0)])
def test_what_hardly_bends_does_not_fall(bend: float, count: int) -> None:
    assert len(falls_of(BALL, jumps([bend])).frames) == count


@pytest.mark.parametrize(("height", "count"), [(0.035, 0), (0.045, 1)])
def test_feet_are_in_the_air_from_four_centimetres(height: float, count: int) -> None:
    q = jumps([0.001])
    q[:, 0] = height * q[:, 0] + 3.0
    q[:, 2] += 3.0
    assert len(falls_of(BALL, q).frames) == count


@pytest.mark.parametrize(("base", "count"), [(0.65, 1), (0.55, 0)])
def test_a_base_that_lies_low_is_not_in_the_air(base: float, count: int) -> None:
    assert len(falls_of(BALL, jumps([2e-4], base=base)).frames) == count


def test_the_floor_near_by_is_that_of_sixty_frames_before_and_after() -> None:
    q = jumps([], stance=60)
    q = np.tile(q[0], (240, 1))
    q[:, 0], q[:, 2] = 1.0, 20.0 - 0.0005 * np.arange(240.0) ** 2
    q[120, 0] = 0.0
    falls = falls_of(BALL, q)
    assert falls.frames.tolist() == [59, 60]
    assert falls.accelerations == pytest.approx([0.001, 0.001])


@pytest.mark.parametrize(("end", "count"), [(3999, 1), (4000, 0)])
def test_the_first_four_thousand_frames_are_searched(end: int, count: int) -> None:
    q = np.tile(jumps([])[0], (4010, 1))
    q[end - 12 : end, 0] = 1.0
    q[end - 12 : end, 2] -= 0.005 * np.arange(12) ** 2
    assert len(falls_of(BALL, q).frames) == count


def test_a_robot_that_is_bolted_down_or_has_no_feet_does_not_fall() -> None:
    footless: Any = Ball(feet=())
    for robot in (FIXED, footless):
        assert len(falls_of(robot, jumps([0.01])).accelerations) == 0


def test_the_rate_of_falls_is_that_of_the_middle_one() -> None:
    falls = Falls(np.array(bends(20.0, 50.0, 400.0)), np.full(3, 9))
    assert falls.rate == pytest.approx(50.0)
    assert np.isnan(falls_of(FIXED, jumps([])).rate)


def test_velocities_tell_the_rate_of_a_parabola_exactly() -> None:
    for rate in (0.5, 1.5, 120.0):
        assert rate_by_speeds(moving(rate)) == pytest.approx(rate)
    assert rate_by_speeds(fields()) is None
    backwards = moving(50.0)
    assert backwards.speeds is not None
    backwards.speeds = -backwards.speeds
    assert rate_by_speeds(backwards) is None


@pytest.mark.parametrize(("share", "known"), [(0.24, True), (0.26, False)])
def test_a_quarter_of_the_velocities_may_be_left(share: float, known: bool) -> None:
    steps = np.array([1.0, 1.0, 1.0, 1.0])
    aside = np.array([1.0, -1.0, -1.0, 1.0]) * np.sqrt(share / (1.0 - share))
    ends = np.array([0.0, *np.cumsum(2.0 * (steps + aside) * [1.0, -1.0, 1.0, -1.0])])
    speeds = ends * [1.0, -1.0, 1.0, -1.0, 1.0] * -1.0  # whose middles are 1 + aside
    np.testing.assert_allclose(0.5 * (speeds[1:] + speeds[:-1]), steps + aside, atol=1e-12)
    one = MotionFields("", np.arange(5.0)[:, None], speeds=30.0 * speeds[:, None])
    assert rate_by_speeds(one) == (pytest.approx(30.0) if known else None)


@pytest.mark.parametrize(("size", "known"), [(0.9e-8, False), (1.2e-8, True)])
def test_joints_that_hardly_move_tell_no_rate(size: float, known: bool) -> None:
    one = moving(50.0)
    assert one.speeds is not None
    scale = np.sqrt(size / float((np.diff(one.joints, axis=0) ** 2).sum()))
    one.joints, one.speeds = one.joints * scale, one.speeds * scale
    assert (rate_by_speeds(one) is not None) == known


def test_times_tell_the_rate_before_the_file_does() -> None:
    times = np.array([1.0, 1.1, 1.2, 1.3, 1.8])
    assert stated_rate(fields(rate=30.0, times=times)) == pytest.approx(4 / 0.8)
    assert stated_rate(fields(rate=30.0)) == 30.0
    assert stated_rate(fields()) is None


def found(one: MotionFields, given: float | None = None, q: Any = None) -> tuple[float, list[str]]:
    return find_rate(FIXED if q is None else BALL, one, jumps([]) if q is None else q, given)


@pytest.mark.parametrize(
    ("factor", "doubted"), [(1.015, False), (0.985, False), (1.025, True), (0.975, True)]
)
def test_rates_two_percent_apart_are_two(factor: float, doubted: bool) -> None:
    times = np.arange(5) / (50.0 * factor)
    rate, notes = found(fields(rate=50.0, times=times))
    assert rate == pytest.approx(50.0 * factor)
    said = f"doubt: rate: the file says 50 Hz, its times {50 * factor:.6g}; the times are used"
    assert notes == [said] * doubted
    rate, notes = found(fields(rate=50.0 * factor), 50.0)
    assert rate == 50.0
    said = f"doubt: rate: fps=50 was given, the file says {50 * factor:.6g} Hz"
    assert notes == [said] * doubted


def test_a_file_that_says_one_rate_is_taken_at_its_word() -> None:
    assert found(fields(rate=37.0)) == (37.0, [])
    assert found(fields(), 37.0) == (37.0, [])
    with pytest.raises(sf.ProblemError, match="fps must be positive"):
        found(fields(), 0.0)


@pytest.mark.parametrize("usual", [24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 120.0, 200.0, 240.0])
def test_velocities_near_a_usual_rate_tell_that_rate(usual: float) -> None:
    rate, notes = found(moving(1.015 * usual))
    assert rate == usual
    assert notes == [
        f"rate: guessed as {usual:.6g} Hz by the file's velocities, which give {1.015 * usual:.4g}"
    ]


@pytest.mark.parametrize(("speeds", "rate"), [(31.4, 30.0), (31.8, 31.8), (39.0, 39.0), (77.0, 77.0)])
def test_velocities_five_percent_off_a_usual_rate_tell_their_own(speeds: float, rate: float) -> None:
    assert found(moving(speeds))[0] == pytest.approx(rate)


@pytest.mark.parametrize(("speeds", "doubted"), [(59.0, False), (61.0, True), (41.0, False), (39.0, True)])
def test_velocities_a_fifth_off_the_rate_are_doubted(speeds: float, doubted: bool) -> None:
    rate, notes = found(moving(speeds), 50.0)
    assert rate == 50.0
    assert notes == [f"doubt: rate: 50 Hz, by the file's velocities {speeds:.4g}"] * doubted


def test_three_falls_tell_a_usual_rate() -> None:
    rate, notes = found(fields(), q=jumps(bends(50.0, 52.0, 48.0)))
    assert rate == 50.0
    assert notes == [
        "doubt: rate: guessed as 50 Hz, its 3 airborne phases would fall as gravity has it at 50 Hz"
    ]
    assert found(fields(), q=jumps(bends(52.0, 52.0, 52.0)))[0] == 50.0


@pytest.mark.parametrize(
    ("rates", "told"),
    [
        ((50.0,), "; its 1 airborne phase would fall as gravity has it at 50 Hz"),
        ((50.0, 50.0), "; its 2 airborne phases would fall as gravity has it at 50 Hz"),
        ((50.0, 50.0, 53.0), "; its 3 airborne phases would fall as gravity has it at 50 Hz"),
        ((53.5, 53.5, 53.5), "; its 3 airborne phases would fall as gravity has it at 53.5 Hz"),
        ((), ""),
    ],
)
def test_falls_that_are_few_apart_or_unusual_tell_no_rate(rates: tuple[float, ...], told: str) -> None:
    with pytest.raises(sf.ProblemError) as caught:
        found(fields(), q=jumps(bends(*rates)))
    assert str(caught.value) == f"nothing in it says the rate: give fps=, frames per second{told}"


@pytest.mark.parametrize(("count", "fall", "doubted"), [
    (3, 0.72, False), (3, 0.68, True), (3, 1.28, False), (3, 1.32, True), (2, 2.0, False),
])  # fmt: skip
def test_three_falls_a_third_off_gravity_are_doubted(count: int, fall: float, doubted: bool) -> None:
    q = jumps([fall * G / 30.0**2] * count)
    rate, notes = found(fields(rate=30.0), q=q)
    assert rate == 30.0
    told = (
        f"doubt: rate: at 30 Hz its 3 airborne phases fall at {fall * G:.2g} m/s² (median), at "
        f"{30.0 / np.sqrt(fall):.3g} Hz as gravity has it"
    )
    assert notes == [told] * doubted


def test_a_motion_without_falls_is_not_doubted() -> None:
    nothing: Any = SimpleNamespace(floating=True, feet=())
    assert find_rate(nothing, fields(rate=500.0), jumps([]), None) == (500.0, [])
