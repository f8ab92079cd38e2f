"""The compiled pieces of the feet's state machine and of the body's plan, foot by foot in plain Python."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.control.feet_kernels import follow_phases, set_timing
from surefoot.control.force_planner import ramp_shares
from surefoot.control.walking_kernels import advance_body, body_rise
from surefoot.stance.contact_schedule import ContactSchedule
from surefoot.stance.gait import Gait, ModeSchedule

N = 6
TROT = Gait.from_phases("trot", period=0.4, duty=0.6, offset=[0.0, 0.5, 0.5, 0.0])


def some(rng: np.random.Generator) -> np.ndarray:
    """Return a random mask of the feet."""
    return rng.random(N) < 0.5


@pytest.mark.parametrize("seed", range(40))
def test_feet_are_followed_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time, wait, early, lost = 1.0, 0.1 * rng.random(), 0.6, 0.03
    phases = np.column_stack([some(rng), time - 0.3 * rng.random(N), time + 0.1 + rng.random(N)])
    sensed, carrying, planned, late = (some(rng) for _ in range(4))
    share, sensed_at = rng.random(N), time - 0.06 * rng.random(N)
    retry = np.column_stack([np.full(N, 0.9), np.where(some(rng), 2.0, 0.5)])
    lifted = phases[:, 1] - rng.integers(0, 2, N)
    found = [a.copy() for a in (planned, late, share, sensed_at)]
    events = follow_phases(
        phases, time, wait, sensed, early, lost, carrying, found[0], found[1], found[2], found[3], retry,
        lifted,
    )  # fmt: skip
    for k in range(N):
        on, begin, end = bool(phases[k, 0]), phases[k, 1], phases[k, 2]
        felt = time if sensed[k] else sensed_at[k]
        happens, now_late, now_share = False, late[k], share[k]
        if not carrying[k] and time + wait < retry[k, 1]:
            happens = True
        elif on:
            happens = not carrying[k] or time - felt > lost
        else:
            now_late, now_share = False, (time - begin) / (end - begin)
            happens = begin > lifted[k] if carrying[k] else bool(sensed[k] and now_share > early)
        assert bool(events >> k & 1) == happens
        assert [a[k] for a in found] == [on, now_late, now_share, felt]
    assert events >> N == 0


def test_timing_tells_late_feet() -> None:
    timing = np.arange(18.0).reshape(3, 6)
    set_timing(
        timing, np.array([0.3, 1.0, 0.7]), np.array([False, True, True]), np.array([0.0, 1.4, 3.0]), 2.0
    )
    assert timing[0].tolist() == [0.0, 0.3, 2.0, 3.0, -1.0, 5.0]
    assert timing[1, 4] == pytest.approx(0.6)
    assert timing[1, 1] == pytest.approx(1.0 + 0.6 / 8.0)
    assert timing[2, [1, 4]].tolist() == [1.0, 0.0]


@pytest.mark.parametrize("seed", range(20))
def test_ramps_rise_and_fall(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time, step, length = 1.0, 1e-3, 0.03
    phases = np.column_stack([some(rng), np.full(N, 0.8), time + 0.06 * rng.random(N)])
    carrying, carried, landed = some(rng), some(rng), time - 0.06 * rng.random(N)
    felt, elapsed = rng.random(N) < 0.7, 1.5e-3
    shares, was, since = np.zeros(N), carried.copy(), landed.copy()
    early = ramp_shares(phases, carrying, felt, was, since, time, elapsed, step, length, shares)
    assert (was == carrying).all()
    for k in range(N):
        waits = not felt[k] and time - landed[k] + step < length
        begun = time if not carried[k] else landed[k] + elapsed * waits
        assert since[k] == (begun if carrying[k] else landed[k])
        assert bool(early >> k & 1) == bool(carrying[k] and not phases[k, 0])
        if not carrying[k]:
            assert shares[k] == 1.0
            continue
        used = time - since[k] + step
        left = phases[k, 2] - time if phases[k, 0] else math.inf
        assert shares[k] == pytest.approx(np.clip(min(used, left) / length, 0.0, 1.0))


@pytest.mark.parametrize("schedule", [TROT, TROT.schedule(1.0)], ids=["gait", "modes"])
def test_the_table_of_phases_is_what_the_schedule_says_of_each_foot(schedule: ContactSchedule) -> None:
    assert isinstance(schedule, (Gait, ModeSchedule))
    times = np.r_[np.arange(-0.1, 1.4, 7e-3), 0.2, 0.4, 0.64, 0.3]
    for time in times.tolist():
        said = np.array([schedule.phase(k, time) for k in range(4)], dtype=float)
        assert np.array_equal(schedule.phases(time), said)


def test_a_schedule_that_changes_is_asked_again() -> None:
    told = [0.0, 1.0]

    class Changing(ContactSchedule):
        feet = 1

        def contacts(self, times: object) -> np.ndarray:
            return np.ones(1, dtype=bool)

        def phase(self, foot: int, time: float) -> tuple[bool, float, float]:
            return True, told[0], told[1]

    schedule = Changing()
    assert schedule.phases(0.5)[0, 2] == 1.0
    told[1] = 0.8
    assert schedule.phases(0.5)[0, 2] == 1.0
    schedule._forget_phases()
    assert schedule.phases(0.5)[0].tolist() == [1.0, 0.0, 0.8]


@pytest.mark.parametrize("speed_over", [1.0, 4.0])
@pytest.mark.parametrize("seed", range(10))
def test_a_body_goes_where_it_should(seed: int, speed_over: float) -> None:
    rng = np.random.default_rng(seed)
    position, velocity, slope = rng.normal(size=3), rng.normal(size=3), 0.3 * rng.normal(size=2)
    velocity *= speed_over
    com, command, dt, height = position + 0.2 * rng.normal(size=3), rng.normal(size=3), 0.01, 0.3
    yaw, ground, lowered, most, dip, lead, lowering = 0.4, 0.1, 0.3, 5.0, 0.2, 0.05, 0.3
    place, speed = position.copy(), velocity.copy()
    found = advance_body(
        place, speed, slope, command, com, dt, height, yaw, ground, lowered, most, dip, lead, lowering
    )
    limits = np.array([most, most, most / height]) * dt
    wanted = velocity + np.clip(command - velocity, -limits, limits)
    turned = yaw + wanted[2] * dt
    R = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]])
    flow = R @ wanted[:2]
    ahead = position[:2] + dt * flow - com[:2]
    reach = lead * max(math.sqrt(9.81 * height), float(np.linalg.norm(flow)))
    ahead *= min(1.0, reach / np.linalg.norm(ahead))
    level, low = ground + slope @ flow * dt, lowered + (1.0 - lowered) * dt / lowering
    np.testing.assert_allclose(speed, wanted, atol=1e-13)
    np.testing.assert_allclose(found, (turned, level, low), atol=1e-13)
    np.testing.assert_allclose(place[:2], com[:2] + ahead, atol=1e-12)
    rise = body_rise(slope, turned, height, dip, low)
    assert place[2] == pytest.approx(level + rise, abs=1e-13)
    steep = float(np.linalg.norm(slope))
    climb = float(slope @ R[:, 0])
    sink = dip * min(max(-climb, 0.0), 0.4) * low
    power = 0.5 - 0.5 * low * (1.0 + climb / steep)
    assert rise == pytest.approx(height * (1.0 - sink) * (1.0 + steep**2) ** power)
    assert body_rise(np.zeros(2), yaw, height, dip, low) == height
