"""Contact schedules: both forms agree, phases match contacts, and wrong schedules are told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.base.errors import ProblemError
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait, ModeSchedule, mode_feet, mode_number
from surefoot.motion.gaits.library import PATTERNS, gait_names, named_gait

SHARES = st.floats(0.0, 0.999)


@st.composite
def gaits(draw: st.DrawFn) -> Gait:
    feet = draw(st.integers(1, 6))
    period = draw(st.floats(0.2, 1.0))
    duty = [draw(st.floats(0.4, 1.0)) for _ in range(feet)]
    offset = [draw(SHARES) for _ in range(feet)]
    return Gait.from_phases("drawn", period, duty, offset, max_flight=math.inf)


@given(st.integers(1, 8), st.data())
def test_mode_numbers_are_bits_with_the_first_foot_highest(feet: int, data: st.DataObject) -> None:
    number = data.draw(st.integers(0, 2**feet - 1))
    flags = mode_feet(number, feet)
    assert mode_number(flags) == number
    assert [bool(int(c)) for c in f"{number:0{feet}b}"] == flags.tolist()


@given(gaits(), st.floats(-3.0, 10.0))
@settings(max_examples=200, deadline=None)
def test_phase_and_contacts_agree(gait: Gait, time: float) -> None:
    for foot in range(gait.feet):
        on, begin, end = gait.phase(foot, time)
        assert on == gait.contacts(time)[foot]
        assert begin <= time + 2e-9
        assert end > time
        if math.isfinite(end):
            inside = np.linspace(begin + 1e-7, end - 1e-7, 7)
            assert (gait.contacts(inside)[:, foot] == on).all()
            assert gait.contacts(end + 1e-7)[foot] != on
            assert gait.contacts(begin - 1e-7)[foot] != on


@given(gaits())
@settings(max_examples=100, deadline=None)
def test_duty_is_the_share_of_time_on_the_ground(gait: Gait) -> None:
    cells = 4000
    times = (np.arange(cells) + 0.5) / cells * gait.period
    assert gait.contacts(times).mean(axis=0) == pytest.approx(gait.duty, abs=3.0 / cells)


def test_offsets_are_touchdowns() -> None:
    gait = Gait.from_phases("walk", 1.0, 0.75, [0.25, 0.75, 0.0, 0.5])
    assert gait.offset == pytest.approx([0.25, 0.75, 0.0, 0.5])
    assert gait.duty == pytest.approx([0.75] * 4)
    assert gait.swing_time == pytest.approx(0.25)
    assert gait.stance_time == pytest.approx(0.75)


def test_standing_never_ends() -> None:
    stand = named_gait("stand")
    assert stand.phase(0, 12.3) == (True, -math.inf, math.inf)
    assert stand.swing_time == 0.0


@pytest.mark.parametrize("feet", sorted(PATTERNS))
def test_every_named_gait_can_be_made(feet: int) -> None:
    for name in gait_names(feet):
        gait = named_gait(name, feet, leg=0.5)
        assert gait.feet == feet
        assert gait.period == pytest.approx(PATTERNS[feet][name].period * math.sqrt(0.5 / 0.3))
        assert gait.duty == pytest.approx([PATTERNS[feet][name].duty] * feet)


def test_only_the_flying_trot_flies() -> None:
    flying = {name for name in gait_names(4) if (named_gait(name).modes == 0).any()}
    assert flying == {"flying_trot"}


def test_mode_schedule_merges_runs_of_a_foot() -> None:
    schedule = ModeSchedule([0.2, 0.4, 0.6], [15, 9, 11, 15], feet=4)
    assert schedule.phase(0, 0.3) == (True, -math.inf, math.inf)
    assert schedule.phase(1, 0.3) == (False, 0.2, 0.6)
    assert schedule.phase(2, 0.3) == (False, 0.2, 0.4)
    assert schedule.phase(2, 0.5) == (True, 0.4, math.inf)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: ModeSchedule([0.5, 0.4], [15, 9, 15], feet=4),
            r"events overlap, time 1 \(0.4 s\) must be after",
        ),
        (lambda: ModeSchedule([0.5], [15, 9, 15], feet=4), "needs 2 modes between its events, got 3"),
        (lambda: ModeSchedule([0.5], [15, 16], feet=4), "mode number must be between 0 and 15"),
        (lambda: ModeSchedule([0.5], [15, 9]), "give the number of feet"),
        (lambda: ModeSchedule([0.5, 1.5], [15, 0, 15], feet=4), "no foot on the ground for 1 s"),
        (lambda: ModeSchedule([0.5], [15, 0], feet=4), "no foot on the ground for inf s"),
        (lambda: Gait("hop", [0.0, 0.2, 0.8], [15, 0], feet=4), "no foot on the ground for 0.6 s"),
        (lambda: Gait("limp", [0.0, 0.2, 0.4], [9, 8], feet=4), "foot 1 is never on the ground"),
        (lambda: Gait("late", [0.1, 0.2], [15], feet=4), "needs switching times"),
        (lambda: Gait("nan", [0.0, math.nan], [15], feet=4), "is NaN"),
        (lambda: Gait.from_phases("x", 0.5, 0.0, [0.0, 0.5]), "duty of gait x must be above 0"),
        (lambda: Gait.from_phases("x", -0.5, 0.5, [0.0, 0.5]), "period must be"),
    ],
)
def test_wrong_schedules_are_told(make: object, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        make()  # type: ignore[operator]


def test_flight_across_the_end_of_the_period_counts_once_around() -> None:
    with pytest.raises(ProblemError, match=r"no foot on the ground for 0\.4 s"):
        Gait("pronk", [0.0, 0.2, 0.4, 0.6], [0, 15, 0], feet=4, max_flight=0.35)


@pytest.mark.parametrize("seed", range(4))
def test_rows_of_a_repeated_table_are_those_of_the_schedule(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gait = Gait.from_phases("own", rng.uniform(0.3, 0.9), rng.uniform(0.3, 0.8, 4), rng.uniform(0.0, 1.0, 4))
    start, step = rng.uniform(-2.0, 5.0), rng.uniform(0.01, 0.06)
    middles = start + step * (np.arange(25) + 0.5)
    np.testing.assert_array_equal(gait.horizon(start, step, 25), gait.contacts(middles))


TROT = Gait.from_phases("trot", period=0.4, duty=0.6, offset=[0.0, 0.5, 0.5, 0.0])


@pytest.mark.parametrize(
    "schedule", [TROT, ModeSchedule([0.2, 0.4, 0.64], [15, 9, 6, 15], feet=4)], ids=["gait", "modes"]
)
def test_the_table_of_phases_is_what_the_schedule_says_of_each_foot(schedule: ContactSchedule) -> None:
    assert isinstance(schedule, (Gait, ModeSchedule))
    times = np.r_[np.arange(-0.1, 1.4, 7e-3), 0.2, 0.4, 0.64, 0.3]
    for time in times.tolist():
        said = np.array([schedule.phase(k, time) for k in range(4)], dtype=float)
        assert np.array_equal(schedule.phases(time), said)


def test_phases_are_remembered_until_a_foot_lifts_or_lands() -> None:
    gait = named_gait("trot")
    rows = gait.phases(0.1)
    until = float(rows[:, 2].min())
    assert gait.phases(0.1 + 0.4 * (until - 0.1)) is rows
    assert gait.phases(0.1 + 1.1 * (until - 0.1)) is not rows
