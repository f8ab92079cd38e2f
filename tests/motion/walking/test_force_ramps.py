"""Ramps of normal forces: from touchdown to lift-off."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.force_planner import ForcePlanner, Ramps
from surefoot.motion.walking.gait_clock import GaitClock

TROT = Gait.from_phases("trot", 0.4, 0.6, [0.0, 0.5, 0.5, 0.0])
LENGTH = 0.03


class Ramped:
    """The ramps of a trot's feet, moved on step by step."""

    def __init__(self) -> None:
        mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]))
        self.planner = ForcePlanner(mpc, np.zeros((4, 2)), np.zeros(4), 1e-3, LENGTH)
        self.ramps = Ramps.of(4)

    def shares(self, time: float, stance: BoolArray, touching: BoolArray | None = None) -> FloatArray:
        self.ramps, shares = self.planner.shares(self.ramps, TROT, GaitClock(time), stance, touching)
        return shares


def walked(until: float) -> Ramped:
    ramps = Ramped()
    for time in np.arange(0.0, until, 1e-3):
        ramps.shares(float(time), TROT.contacts(time))
    return ramps


def test_the_bound_follows_the_foot_that_lands_and_lifts() -> None:
    ramps = Ramped()
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
