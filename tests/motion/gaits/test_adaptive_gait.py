"""Schedules that follow the speed: stances that never change once told, swings that keep their time."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from surefoot.motion.gaits.adaptive_gait import AdaptiveGait, Pace, Stride
from surefoot.motion.gaits.gait import Gait

TROT, WALK = np.array([0.0, 0.5, 0.5, 0.0]), np.array([-0.125, 0.375, 0.625, 0.125])
SLOW, QUICK, FAST = Pace(0.8, 0.78, 0.06), Pace(0.4, 0.55, 0.06), Pace(0.28, 0.36, 0.03)


def stride(velocity: np.ndarray, now: str) -> Stride:
    v = float(velocity[0])
    if v == 0.0:
        return Stride(now, SLOW, WALK, moving=False)
    if v < 0.3:
        return Stride("walk", SLOW, WALK)
    return Stride("trot", QUICK if v < 1.0 else FAST, TROT)


def record(speed: Callable[[float], float], until: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
    """Return times and who carries, as a controller sees them that looks 0.3 s ahead every 20 ms."""
    gait = AdaptiveGait("auto", stride, stride(np.array([speed(0.0), 0.0, 0.0]), "walk"))
    times, rows = np.arange(0.0, until, 1e-3), []
    promised: dict[float, list[bool]] = {}
    for i, t in enumerate(times.tolist()):
        if i % 20 == 0:
            gait.follow(t, np.array([speed(t), 0.0, 0.0]))
            ahead = gait.horizon(t, 0.02, 15)
            promised.update({round(t + 0.02 * j + 0.01, 6): row.tolist() for j, row in enumerate(ahead)})
        told = gait.phases(t).tolist()
        now = [gait.phase(k, t) for k in range(4)]
        assert told == [list(row) for row in now]
        rows.append([on for on, _, _ in now])
        assert all(begin <= t + 1e-6 and end > t for _, begin, end in now)
        assert gait.contacts(t).tolist() == rows[-1]
        if round(t, 6) in promised and speed(t) and speed(max(t - 0.4, 0.0)):  # resting ends stances later
            assert promised[round(t, 6)] == rows[-1]
    return times, np.array(rows)


def swings(on: np.ndarray) -> np.ndarray:
    """Return the lengths of all whole swings [s]."""
    out = []
    for column in on.T:
        lifts, lands = np.flatnonzero(column[:-1] & ~column[1:]), np.flatnonzero(~column[:-1] & column[1:])
        out += [1e-3 * float(lands[lands > lift][0] - lift) for lift in lifts if (lands > lift).any()]
    return np.array(out)


def test_at_one_speed_it_is_the_gait() -> None:
    times, on = record(lambda t: 0.5, 3.0)
    plain = Gait.from_phases("trot", QUICK.period, QUICK.duty, TROT.tolist()).contacts(times)
    late = times > 0.5
    lag = int(np.flatnonzero(~plain[:, 1])[0]) - int(np.flatnonzero(~on[:, 1])[0])
    shifted = np.roll(on, lag, axis=0)
    assert (shifted[late][:2000] == plain[late][:2000]).mean() > 0.99


@pytest.mark.parametrize("other", [0.5, 2.0])
def test_from_a_walk_to_a_trot_and_back_no_swing_is_cut_short(other: float) -> None:
    times, on = record(lambda t: 0.1 if t < 2.0 or t > 5.0 else other)
    assert (on.sum(axis=1)[(times > 1.0) & (times < 2.0)] >= 3).all()  # the walk has three feet down
    trotting = (times > 4.2) & (times < 5.0)
    assert (on[trotting, 0] == on[trotting, 3]).mean() > 0.98  # diagonal feet together
    assert (on.sum(axis=1)[times > 9.0] >= 3).all()
    lengths = swings(on)
    assert lengths.min() > 0.9 * min(0.22 * SLOW.period, 0.45 * QUICK.period)
    assert lengths.max() < 0.45
    if other < 1.0:
        assert (on.sum(axis=1) >= 2).mean() > 0.97


def test_it_stands_at_rest_and_walks_off_again() -> None:
    times, on = record(lambda t: 0.5 if 1.0 < t < 3.0 or t > 5.5 else 0.0)
    assert on[times < 1.0].all()
    assert (~on[(times > 1.0) & (times < 1.5)]).any(axis=0).all()
    assert on[(times > 4.5) & (times < 5.5)].all()
    assert (~on[(times > 6.0)]).any(axis=0).all()
    assert math.isclose(swings(on).min(), 0.18, abs_tol=0.02)


STEPS = Pace(0.75, 0.6, 0.06)
OFFSETS = np.array([-0.0625, 0.4375, 0.5625, 0.0625])


@pytest.mark.parametrize("seen", np.linspace(2.0, 2.4, 9))
def test_into_step_with_the_ground_and_out_two_feet_carry_nearly_always(seen: float) -> None:
    """Never more than 30 ms on less, no swing shorter than the trot's; `turning` tells when it is done."""
    there = [False]

    def choose(velocity: np.ndarray, now: str) -> Stride:
        return Stride("trot", STEPS, OFFSETS, in_step=True) if there[0] else Stride("trot", QUICK, TROT)

    gait = AdaptiveGait("trot", choose, choose(np.zeros(3), "trot"))
    times, rows, turning = np.arange(0.0, 14.0, 1e-3), [], []
    for i, t in enumerate(times.tolist()):
        there[0] = seen <= t < 9.0
        if i % 20 == 0:
            gait.follow(t, np.array([0.4, 0.0, 0.0]))
            gait.horizon(t, 0.03, 10)
        rows.append([gait.phase(k, t)[0] for k in range(4)])
        turning.append(gait.turning)
    on = np.array(rows)
    few = (on.sum(axis=1) < 2) & (times > 0.5)
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], few.astype(int), [0]]))))[::2]
    assert runs.max(initial=0) <= 30
    assert swings(on).min() >= 0.9 * QUICK.period * (1.0 - QUICK.duty)
    assert not any(turning[: int(1e3 * seen)])
    done = times[np.flatnonzero(turning)[-1]]
    assert seen + 1.0 < done < seen + 3.0
    assert gait.fits(np.array([9.0, 0.0, 0.0]))  # whatever the speed: no body waits for it
    steady = on[(times > done + 1.0) & (times < 9.0)]
    assert steady.mean(axis=0) == pytest.approx(0.6, abs=0.05)


@pytest.mark.parametrize("at", [1.0, 1.1, 1.234, 1.3])
def test_a_gait_that_is_held_lets_feet_land_and_lifts_none(at: float) -> None:
    gait = AdaptiveGait("trot", stride, stride(np.array([0.5, 0.0, 0.0]), "trot"))
    for t in np.arange(0.0, at, 0.01).tolist():
        gait.follow(t, np.array([0.5, 0.0, 0.0]))
    before = [gait.phase(k, at) for k in range(4)]
    gait.hold(at)
    for k, (on, _, end) in enumerate(before):
        assert gait.contacts(np.linspace(at, at + 3.0, 301))[0, k] == on
        assert gait.phase(k, (at if on else end) + 3.0)[0]
        if not on:
            assert gait.phase(k, at)[2] == end  # it lands when it was to
    gait.follow(at + 3.0, np.array([0.5, 0.0, 0.0]))
    assert gait.contacts(np.linspace(at + 1.0, at + 5.0, 401)).all()
    gait.held = False
    gait.follow(at + 5.0, np.array([0.5, 0.0, 0.0]))
    after = gait.contacts(np.linspace(at + 5.0, at + 7.0, 401))
    assert after[0].all()
    assert not after.all(axis=0).any()  # every foot steps again
