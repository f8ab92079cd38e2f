"""The feet's state machine: lift-off and touchdown by plan, early, late, and lost."""

import numpy as np
import pytest

from surefoot.base.arrays import BoolArray
from surefoot.mechanics.terrain import SlopeTerrain, StairsTerrain, rough_ground
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.feet_settings import FOOTHOLDS
from surefoot.motion.walking.foot_phases import EARLY, LOST_TIME, FootPhase
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walking_feet import Feet
from tests.motion.walking.walked_feet import CENTRES, WalkedFeet

DOWN, UP = np.ones(4, dtype=bool), np.array([True, False, False, True])


@pytest.fixture
def feet() -> WalkedFeet:
    return WalkedFeet()


def test_a_stage_takes_a_literal_and_returns_another(feet: WalkedFeet) -> None:
    before = feet.now.foot.copy()
    feet.update(0.05, UP, CENTRES)
    assert (before["phase"] == FootPhase.STANCE).all()
    stance, swing = FootPhase.STANCE, FootPhase.SWING
    assert feet.now.foot["phase"].tolist() == [stance, swing, swing, stance]
    assert feet.now.foot["share"].tolist() == pytest.approx([0.0, 0.25, 0.25, 0.0])


def test_feet_lift_and_land_by_plan(feet: WalkedFeet) -> None:
    assert feet.update(0.0, DOWN, CENTRES)
    assert feet.now.stance.tolist() == UP.tolist()
    assert not feet.update(0.05, UP, CENTRES)
    assert feet.now.foot["share"][1] == pytest.approx(0.25)
    assert feet.update(0.2, DOWN, CENTRES)  # the others lift as these land
    assert feet.now.stance.tolist() == (~UP).tolist()


def test_a_copy_swings_to_its_own_targets(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, CENTRES[1, :2])
    other = WalkedFeet()
    other.feet = Feet(feet.now.foot.copy())
    other.aim(1, CENTRES[1, :2] + [0.1, 0.0])
    for one in (feet, other):
        one.update(0.1, UP, CENTRES)
    assert feet.motions(0.1)[1, 0, 0] == pytest.approx(CENTRES[1, 0])
    assert other.motions(0.1)[1, 0, 0] > CENTRES[1, 0] + 0.03


def test_a_foot_that_touches_early_carries_until_its_next_swing(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    assert not feet.update(0.2 * EARLY - 0.01, DOWN, CENTRES)  # still brushing the ground: ignored
    assert feet.update(0.2 * EARLY + 0.01, DOWN, CENTRES)
    assert feet.now.stance.all()
    assert not feet.now.planned[1]
    feet.update(0.19, DOWN, CENTRES)
    assert feet.now.stance[1]
    feet.update(0.41, DOWN, CENTRES)
    assert not feet.now.stance[1]


def test_a_late_foot_goes_on_down_until_it_feels_the_ground(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, CENTRES[1, :2])
    feet.update(0.21, UP, CENTRES)
    assert feet.now.searching[1]
    assert not feet.now.stance[1]
    heights = []
    for time in (0.22, 0.26, 0.30):
        feet.update(time, UP, CENTRES)
        heights.append(feet.motions(time)[1, 0, 2])
    assert heights[0] < CENTRES[1, 2]
    assert np.diff(heights).max() < -1e-3
    low = CENTRES.copy()
    low[1, 2] -= 0.03
    assert feet.update(0.31, DOWN, low)
    assert feet.now.stance[1]
    assert feet.now.ground[1] == pytest.approx([0.2, -0.15, -0.03])


def test_a_foot_that_loses_the_ground_looks_for_it_below(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    feet.update(0.05, UP, CENTRES)
    gone = np.array([False, False, False, True])
    assert not feet.update(0.05 + 0.9 * LOST_TIME, gone, CENTRES)
    assert feet.update(0.051 + LOST_TIME, gone, CENTRES)
    assert feet.now.searching[0]
    assert not feet.now.stance[0]
    feet.update(0.12, gone, CENTRES)
    assert feet.motions(0.12)[0][0] == pytest.approx(CENTRES[0], abs=0.02)
    assert feet.motions(0.12)[0][1, 2] < 0.0


def test_an_aimed_foot_flies_to_its_target_over_its_apex(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, np.array([0.3, -0.1]))
    assert feet.now.target[1] == pytest.approx([0.3, -0.1, 0.02])
    heights = []
    for time in np.linspace(0.0, 0.199, 40):
        feet.update(float(time), UP, CENTRES)
        heights.append(feet.motions(float(time))[1, 0, 2])
    gain = 0.08 * feet.model.descent * 0.2  # which the descent takes
    assert max(heights) == pytest.approx(0.02 + 0.06 + gain, abs=3e-4)
    feet.aim(1, np.array([9.0, 9.0]))  # too late to change
    assert feet.now.target[1, 0] == pytest.approx(0.3)


@pytest.mark.parametrize("degrees", [0.0, 20.0, -20.0])
def test_a_swing_over_a_plane_is_as_high_above_it_whatever_its_slope(degrees: float) -> None:
    """The path's highest point over the ground, along the vertical, is the clearance."""
    ground, radius, clearance = SlopeTerrain(degrees), 0.02, 0.06  # the radius of such feet
    gait = Gait.from_phases("trot", 0.4, 0.5, (0.0, 0.5, 0.5, 0.0))
    places = np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]])
    centres = np.column_stack([places, ground.height(places) + radius / np.cos(np.radians(degrees))])
    feet = WalkedFeet(ground, gait, clearance, 0.0, centres)
    feet.update(0.201, np.ones(4, dtype=bool), centres)
    k = int(np.flatnonzero(~feet.now.stance)[0])
    feet.aim(k, centres[k, :2] + [0.2, 0.0])
    path = []
    for time in np.linspace(0.201, 0.399, 100):
        feet.now.foot["share"][k] = (time - 0.2) / 0.2
        path.append(feet.motions(float(time))[k, 0])
    above = np.array(path)[:, 2] - ground.height(np.array(path)[:, :2])
    assert above.max() - above[0] == pytest.approx(clearance, abs=2e-3)


def test_a_landing_that_is_taken_back_goes_on_or_down(feet: WalkedFeet) -> None:
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, CENTRES[1, :2] + [0.1, 0.0])
    goal = feet.now.target[1].copy()
    high = CENTRES.copy()
    high[1] += [0.05, 0.0, 0.04]
    assert feet.update(0.2 * EARLY + 0.01, DOWN, high)
    assert feet.now.target[1] == pytest.approx(high[1])
    feet.update(0.2 * EARLY + 0.011, UP, high, false=1)  # in its swing: goes on to where it was to stand
    assert not feet.now.stance[1]
    assert feet.now.target[1] == pytest.approx(goal)
    feet.update(0.17, UP, high)
    assert feet.motions(0.17)[1, 0, 0] == pytest.approx(goal[0], abs=0.03)
    assert feet.update(0.21, DOWN, high)
    assert feet.now.stance[1]
    feet.update(
        0.211, ~np.array([False, True, False, False]), high, false=1
    )  # in its stance: looked for below
    assert feet.now.searching[1]
    assert feet.motions(0.25)[1, 0, 2] < high[1, 2]


def test_with_a_heading_feet_move_off_edges_along_it() -> None:
    stairs = StairsTerrain(-0.12, 0.3)
    feet = WalkedFeet(stairs)
    feet.update(0.0, DOWN, CENTRES)
    feet.now.foot["start"][1, :2] = [0.4, -0.15]
    feet.request = feet.request._replace(heading=np.array([1.0, 0.0]))
    feet.aim(1, np.array([0.38, -0.2]))  # back and aside, 8 cm beyond the edge that it came down over
    assert feet.now.target[1, 0] - 0.3 == pytest.approx(FOOTHOLDS.shin, abs=0.01)
    assert feet.now.target[1, 1] == pytest.approx(-0.2)


@pytest.mark.parametrize("clearance", [0.03, 0.06])
def test_over_rough_ground_a_foot_is_moved_by_a_little_more_than_its_swing_is_high(clearance: float) -> None:
    places = np.random.default_rng(0).uniform(-2.0, 2.0, (80, 2))
    moved = []
    for place in places:
        feet = WalkedFeet(rough_ground(3, 0.1), clearance=clearance)
        feet.update(0.0, DOWN, CENTRES)
        feet.now.foot["start"][1, :2] = place  # straight up and down: no edges lie across its way
        feet.aim(1, place)
        moved.append(np.abs(feet.now.target[1, :2] - place).max())
    assert 1.0 <= max(moved) / clearance < 1.5
    assert min(moved) < 0.5 * clearance


def test_a_late_foot_slows_down_on_its_way_to_the_ground_without_a_jump(feet: WalkedFeet) -> None:
    feet.fastest = 0.7
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, CENTRES[1, :2])
    places, speeds, fastest = [], [], 0.7
    for t in np.arange(0.201, 0.399, 1e-3).tolist():
        if t > 0.3:
            before, fastest = fastest, max(fastest - 0.01, 0.05)
            ahead = np.array([5e-4, 0.0])
            feet.feet = feet.model.slow_search(feet.now, GaitClock(t), before, fastest, ahead)
            feet.fastest = fastest
        feet.update(t, UP, CENTRES)
        path = feet.motions(t)[1]
        places.append(path[0])
        speeds.append(path[1, 2])
    moved = 1e3 * np.diff(places, axis=0)
    assert moved[:, 2] == pytest.approx(0.5 * (np.array(speeds[1:]) + speeds[:-1]), abs=0.02)
    assert moved[-20:, 0] == pytest.approx(0.5, abs=1e-6)
    assert min(speeds) == pytest.approx(-0.8, abs=1e-6)
    assert speeds[-1] == pytest.approx(-0.15, abs=1e-6)
    assert (np.diff(speeds)[100:] >= -1e-9).all()


def test_a_foot_that_is_late_still_when_it_should_lift_swings_from_where_it_is(feet: WalkedFeet) -> None:
    feet.careful = True
    feet.update(0.0, DOWN, CENTRES)
    feet.aim(1, CENTRES[1, :2])
    for t in np.arange(0.01, 0.4, 0.01).tolist():
        feet.update(t, UP, CENTRES)
    assert feet.now.searching[1]
    low = CENTRES - [0.0, 0.0, 0.05]
    feet.update(0.41, UP, low)
    assert not feet.now.searching[1]
    assert feet.now.foot["start"][1].tolist() == low[1].tolist()
    assert feet.now.foot["duration"][1] == pytest.approx(0.2)


LOST = FootPhase.SEARCHING
TRANSITIONS = [
    # times of the schedule, which feet touch, and what happens to foot 1, which swings from 0 to 0.2 s
    ([(0.05, UP)], FootPhase.SWING),
    ([(0.05, UP), (0.15, DOWN)], FootPhase.STANCE),
    ([(0.05, UP), (0.10, DOWN)], FootPhase.SWING),  # brushes the ground
    ([(0.05, UP), (0.201, UP)], LOST),
    ([(0.05, UP), (0.201, UP), (0.22, DOWN)], FootPhase.STANCE),
    ([(0.05, UP), (0.201, UP), (0.41, UP)], FootPhase.SWING),
    ([(0.05, UP), (0.201, DOWN), (0.21, UP), (0.24, UP)], LOST),
    ([(0.05, UP), (0.10, "struck")], FootPhase.RESTARTED),
    ([(0.05, UP), (0.10, "struck"), (0.23, DOWN)], FootPhase.STANCE),
    ([(0.05, UP), (0.10, "struck"), (0.23, UP)], FootPhase.RESTARTED),  # for 0.7 of a swing
    ([(0.05, UP), (0.10, "struck"), (0.25, UP)], LOST),
    ([(0.05, UP), (0.15, DOWN), (0.155, "false")], FootPhase.SWING),
    ([(0.05, UP), (0.10, "struck"), (0.19, DOWN), (0.195, "false")], FootPhase.RESTARTED),
    ([(0.05, UP), (0.201, DOWN), (0.21, "false")], LOST),
]


@pytest.mark.parametrize(("events", "phase"), TRANSITIONS)
def test_the_table_of_phases(
    feet: WalkedFeet, events: list[tuple[float, BoolArray | str]], phase: FootPhase
) -> None:
    feet.update(0.001, UP, CENTRES)
    for time, what in events:
        named = what if isinstance(what, str) else ""
        touching = UP if isinstance(what, str) else what
        struck, false = 1 if named == "struck" else None, 1 if named == "false" else None
        feet.update(time, touching, CENTRES, struck=struck, false=false)
    assert FootPhase(int(feet.now.foot["phase"][1])) is phase


def test_feet_that_are_lowered_keep_the_others_ground(feet: WalkedFeet) -> None:
    before = feet.now.foot["ground"].copy()
    soles = before - [0.0, 0.0, 0.03]
    lower = feet.model.lowered(feet.now, UP, soles)
    assert lower.foot["ground"][UP] == pytest.approx(soles[UP])
    assert lower.foot["ground"][~UP] == pytest.approx(before[~UP])
    assert feet.now.foot["ground"] == pytest.approx(before)
