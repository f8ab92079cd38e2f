"""Ramps of normal forces: from touchdown to lift-off, now and over a horizon."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.force_planner import SAMPLES, ForcePlanner
from surefoot.control.mpc import BodyReference, BodyState, ConvexMpc
from surefoot.stance.gait import Gait

TROT = Gait.from_phases("trot", 0.4, 0.6, [0.0, 0.5, 0.5, 0.0])
LENGTH = 0.03


def planner() -> ForcePlanner:
    mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]))
    return ForcePlanner(mpc, TROT, np.zeros((4, 2)), np.zeros(4), 1e-3, LENGTH)


def walked(until: float) -> ForcePlanner:
    ramps = planner()
    for time in np.arange(0.0, until, 1e-3):
        ramps.shares(float(time), TROT.contacts(time))
    return ramps


def test_the_bound_follows_the_foot_that_lands_and_lifts() -> None:
    ramps = planner()
    shares = np.array([ramps.shares(t, TROT.contacts(t)) for t in np.arange(0.0, 0.8, 1e-3)])
    since = np.arange(0.8e3) * 1e-3 - 0.4  # of the stance of the first foot that begins at 0.4 s
    expected = np.clip(np.minimum(since + 1e-3, 0.24 - since) / LENGTH, 0.0, 1.0)
    inside = (since >= 0.0) & (since < 0.24)
    assert shares[inside, 0] == pytest.approx(expected[inside], abs=1e-6)
    assert np.abs(np.diff(shares[inside, 0])).max() < 1.1e-3 / LENGTH


def test_a_foot_that_is_late_begins_its_ramp_when_it_touches() -> None:
    ramps = walked(0.4)
    off = np.array([False, True, True, False])
    ramps.shares(0.41, off)
    on = ramps.shares(0.42, np.ones(4, dtype=bool))
    assert on[0] == pytest.approx(1e-3 / LENGTH)
    assert ramps.shares(0.43, np.ones(4, dtype=bool))[0] == pytest.approx(11e-3 / LENGTH)


def test_a_foot_that_feels_nothing_after_its_landing_waits_with_its_ramp() -> None:
    ramps, on = walked(0.4), np.ones(4, dtype=bool)
    off, felt = np.array([False, True, True, True]), np.array([False, True, True, True])
    ramps.shares(0.41, off)
    first = ramps.shares(0.42, on)[0]
    for i in range(1, 8):
        assert ramps.shares(0.42 + 1e-3 * i, on, felt)[0] == pytest.approx(first)
    assert ramps.shares(0.43, on)[0] == pytest.approx(first + 3e-3 / LENGTH)
    assert ramps.shares(0.46, on)[0] == pytest.approx(1.0)
    assert ramps.shares(0.461, on, felt)[0] == pytest.approx(1.0)  # it has stood long


@pytest.mark.parametrize("time", [0.05, 0.21, 0.33, 0.4])
def test_the_mean_ahead_is_that_of_what_comes(time: float) -> None:
    ramps, step, count = walked(time), 0.02, 12
    ahead = ramps._shares_ahead(time, step, count)
    fine = time + step * (np.arange(count * SAMPLES) + 0.5) / SAMPLES
    for k in range(4):
        shares = np.ones(len(fine))
        for i, t in enumerate(fine):
            planned, begin, end = TROT.phase(k, float(t))
            if planned:
                begin = -1.0 if begin <= 0.0 else begin  # the stance that the walk began with has no ramp
                shares[i] = np.clip(min(t - begin, end - t) / LENGTH, 0.0, 1.0)
        on = TROT.contacts(fine)[:, k].reshape(count, SAMPLES).all(axis=1)
        assert ahead[on, k] == pytest.approx(shares.reshape(count, SAMPLES).mean(axis=1)[on], abs=0.06)


def test_the_plan_keeps_to_the_lowered_bounds() -> None:
    mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]), horizon=5, normal_max=200.0, normal_min=3.0)
    state = BodyState(np.eye(3), np.array([0, 0, 0.3]), np.zeros(3), np.zeros(3))
    feet = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]
    share = np.ones((5, 4))
    share[:2, 0], share[4, 3] = 0.1, 0.0
    plan = mpc.solve(
        state,
        BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=5),
        feet,
        np.ones((5, 4), dtype=bool),
        normal_share=share,
    )
    assert (plan.forces[:, :, 2] <= 200.0 * share + 1e-6).all()
    assert plan.forces[0, 0, 2] > 15.0
    assert plan.forces[4, 3] == pytest.approx(0.0)
    assert plan.forces[0, :, 2].sum() == pytest.approx(15.0 * 9.81, rel=0.05)
