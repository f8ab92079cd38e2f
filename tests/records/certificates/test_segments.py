"""Segments of a motion from tables made by hand: which frames belong together, their cause and their cure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from surefoot.records.certificates.segments import Segment, find_segments

G, MASS, FRAMES, LIMIT = 9.81, 10.0, 12, 0.2
LINKS = ("toe", "heel", "hand")


def table(bad: Any = (), causes: Any = "friction", shares: Any = 0.5, **more: Any) -> Any:
    """Return the table of a motion at 50 Hz whose `bad` frames are impossible."""
    made: dict[str, Any] = {
        "time": np.arange(FRAMES) / 50.0, "verdict": np.full(FRAMES, "possible", dtype="U12"),
        "cause": np.full(FRAMES, "", dtype="U24"), "share": np.zeros(FRAMES), "detour": np.zeros(FRAMES),
        "gap": np.zeros(FRAMES), "joint": np.full(FRAMES, "", dtype="U8"),
    }  # fmt: skip
    bad = list(bad)
    made["verdict"][bad], made["cause"][bad], made["share"][bad] = "impossible", causes, shares
    for name, values in more.items():
        made[name][bad] = values
    return SimpleNamespace(**made)


def answer() -> Any:
    return SimpleNamespace(
        wrench=np.zeros((FRAMES, 6)), needed=np.zeros((FRAMES, 6)), torques=np.zeros((FRAMES, 2))
    )


class Data:
    """A motion that is possible from a pace on."""

    def __init__(self, pace: float = -1.0, step: float = 0.02) -> None:
        self.asked: list[tuple[int, float]] = []
        self._pace = pace
        points = SimpleNamespace(
            gaps=np.full((FRAMES, 4), 0.5), slides=np.zeros((FRAMES - 1, 4, 3)), owner=np.array([2, 0, 1, 1])
        )
        rules = SimpleNamespace(mass=MASS, clearance=0.03)
        self.model: Any = SimpleNamespace(window=SimpleNamespace(step=step), rules=rules, points=points)

    def solve(self, frames: Any, pace: float) -> Any:
        assert frames.shape == (1,)
        self.asked.append((int(frames[0]), pace))
        share = np.full(FRAMES, np.nan)
        share[frames] = LIMIT if pace <= self._pace else LIMIT + 0.01
        return SimpleNamespace(share=share)


def found(data: Any, one: Any, given: Any = None) -> tuple[Segment, ...]:
    return find_segments(data, given or answer(), one, LINKS, LIMIT)


def test_a_possible_motion_has_no_segments() -> None:
    assert found(Data(), table()) == ()


@pytest.mark.parametrize(("step", "groups"), [
    (0.02, [(1, 6)]), (0.021, [(1, 1), (6, 6)]), (0.5, [(1, 1), (6, 6)]),
])  # fmt: skip
def test_frames_a_tenth_of_a_second_apart_are_one_segment(step: float, groups: Any) -> None:
    assert [(one.first, one.last) for one in found(Data(step=step), table([1, 6]))] == groups


def test_neighbours_are_one_segment_where_steps_are_long() -> None:
    assert [(one.first, one.last) for one in found(Data(step=0.5), table([1, 2, 4]))] == [(1, 2), (4, 4)]


def test_a_segment_has_its_times_and_its_worst() -> None:
    one = table([2, 3, 4], shares=[0.3, 0.7, 0.4], detour=[0.1, 0.2, 0.6], joint="knee")
    (segment,) = found(Data(pace=0.6), one)
    assert segment == Segment(0.04, 0.08, 2, 4, "friction", 0.7, 0.6, "knee", "slow to 0.6")
    assert str(segment) == "0.04 to 0.08 s: friction (knee), 0.70 m g: slow to 0.6"
    assert str(found(Data(), table([2]))[0]) == (
        "0.04 to 0.04 s: friction, 0.50 m g: no pace helps: press the feet on the ground from above"
    )


def test_the_cause_is_that_of_the_largest_shares() -> None:
    one = table([2, 3, 4, 5], ["speed", "friction", "friction", "speed"], [0.5, 0.3, 0.4, 0.1])
    one.joint[[2, 3, 4, 5]] = ["a", "b", "c", "d"]
    data = Data(pace=0.9)
    (segment,) = found(data, one)
    assert (segment.cause, segment.where, segment.worst) == ("friction", "c", 0.5)
    assert data.asked == [(4, 0.9)]


@pytest.mark.parametrize(("pace", "cure", "count"), [
    (0.9, "slow to 0.9", 1), (0.85, "slow to 0.8", 2), (0.7, "slow to 0.7", 3), (0.5, "slow to 0.5", 5),
    (0.4, "slow to 0.4", 6), (0.3, "slow to 0.3", 7), (0.1, "slow down: standing still there is possible", 8),
])  # fmt: skip
def test_the_fastest_pace_that_is_possible_is_the_cure(pace: float, cure: str, count: int) -> None:
    data = Data(pace=pace)
    assert found(data, table([3]))[0].cure == cure
    paces = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.0]
    assert data.asked == [(3, one) for one in paces[:count]]


def test_feet_that_hang_are_lowered_by_the_middle_of_their_gaps() -> None:
    (segment,) = found(Data(), table([3, 4, 5], "hangs", gap=[0.04, 0.09, 0.3], joint="knee"))
    assert (segment.where, segment.cure) == ("", "lower the root by 9 cm")


def test_a_flight_is_played_as_gravity_has_it() -> None:
    given = answer()
    given.needed[[3, 4, 5], 2] = MASS * np.array([5.81, 1.0, 9.0])  # it falls at 4 m/s²
    (segment,) = found(Data(), table([3, 4, 5], "dynamics in flight"), given)
    pace = np.sqrt(9.81 / 4.0)
    assert segment.cure == (f"it falls at 4.0 m/s², not at 9.81: play the flight at {pace:.2f} of its speed")
    given.needed[3:6, 2] = MASS * 9.9
    assert found(Data(), table([4], "dynamics in flight"), given)[0].cure == (
        "it does not fall in the air: shorten the flight"
    )


def test_the_slowest_point_near_the_ground_is_what_slides() -> None:
    data = Data()
    points = data.model.points
    points.gaps[5] = [0.02, 0.031, 0.03, 0.01]
    points.slides[5, :, 0] = [0.9, 0.1, 0.6, 0.8]
    points.slides[5, 2, 1] = 0.8
    (segment,) = found(data, table([5], "slides"))
    assert (segment.where, segment.cure) == ("heel", "hold it in place: it slides 0.8 m/s")
    points.slides[5, 2] = [0.0, -0.3, 0.0]
    points.slides[5, 3] = [0.0, 0.0, 0.0]
    points.gaps[5, 3] = 1.0
    assert found(data, table([5], "slides"))[0].cure == "hold it in place: it slides 0.3 m/s"


def test_where_nothing_is_near_the_lowest_point_slides_and_the_last_step_counts_for_the_last_frame() -> None:
    data = Data()
    data.model.points.gaps[FRAMES - 1] = [0.2, 0.1, 0.3, 0.4]
    data.model.points.slides[FRAMES - 2, :, 2] = [0.1, 0.7, 0.2, 0.3]
    (segment,) = found(data, table([FRAMES - 1], "slides"))
    assert (segment.where, segment.cure) == ("toe", "hold it in place: it slides 0.7 m/s")


def test_what_tips_is_brought_nearer_by_its_moment_over_its_weight() -> None:
    given = answer()
    given.wrench[4] = MASS * G * np.array([9.0, 9.0, 9.0, 0.03, 0.04, 9.0])
    (segment,) = found(Data(), table([4], "tips over the sole", joint="foot"), given)
    assert (segment.where, segment.cure) == (
        "foot", "no pace helps: bring the centre of mass 5 cm nearer"
    )  # fmt: skip


def test_what_a_joint_lacks_is_the_largest_of_its_torques() -> None:
    given = answer()
    given.torques[4] = [3.0, -12.0]
    (segment,) = found(Data(), table([4], "torque of a joint", joint="knee"), given)
    assert (segment.where, segment.cure) == ("knee", "no pace helps: it lacks 12 N m")
