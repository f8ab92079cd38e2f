"""Friction as the feet find it: what a slide teaches, how fast, and what it slows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.base.arrays import BoolArray
from surefoot.motion.control.controller import RobotState
from surefoot.motion.walking.behaviours.behaviour import Request
from surefoot.motion.walking.behaviours.slip import Slip
from tests.motion.walking.behaviours.views import ALL, HEIGHT, N, motion, view_of, walk_of

SHARE = 0.9


def forces(use: float) -> np.ndarray:
    """Return forces of 40 N on each foot with that use of friction."""
    return np.tile([-use * 40.0, 0.0, 40.0], (N, 1))


def slip() -> Slip:
    """Return the behaviour of a walk that watches friction."""
    one = Slip.of(walk_of(watch_friction=True))
    assert one is not None
    return one


def step(one: Slip, found: np.ndarray | None, speed: float, stance: BoolArray = ALL) -> Request:
    """Return what is asked for in a step in which the first foot moves at a speed [m/s]."""
    state = RobotState(np.zeros(19), np.zeros(18), 0.0, forces=found)
    return one.propose(view_of(state=state, now=motion(speed), stance=stance))


def test_friction_that_is_not_watched_is_nobodys_business() -> None:
    assert Slip.of(walk_of()) is None


def test_feet_that_stand_change_nothing() -> None:
    one = slip()
    for _ in range(300):
        asked = step(one, forces(0.4), 0.0)
    assert one.mu == 0.6
    assert asked.mu == pytest.approx(SHARE * 0.6)
    assert asked.speed_cap == math.inf


@pytest.mark.long
def test_a_slide_is_believed_within_twenty_milliseconds_and_forgotten_later() -> None:
    one = slip()
    for _ in range(50):
        step(one, forces(0.15), 0.0)
    for _ in range(20):
        step(one, forces(0.2), 0.4)
    assert one.mu == pytest.approx(0.18, abs=0.02)  # a tenth below what the slide showed
    assert one.sliding.tolist() == [True, False, False, False]
    for _ in range(15_000):
        step(one, forces(0.1), 0.0)
    assert one.mu > 0.55


def test_slippery_ground_slows_speed_and_its_change() -> None:
    one = slip()
    before = step(one, None, 0.0)
    for _ in range(60):
        asked = step(one, forces(0.1), 0.4)
    assert asked.speed_cap == pytest.approx(1.7 * one.mu * np.sqrt(9.80665 * HEIGHT), rel=1e-3)
    assert asked.mu == pytest.approx(SHARE * one.mu)
    assert asked.acceleration < 0.2 * before.acceleration


def test_feet_in_the_air_and_missing_forces_show_nothing() -> None:
    one = slip()
    air = ALL.copy()
    air[0] = False
    for _ in range(100):
        step(one, forces(0.1), 1.0, air)
        step(one, None, 1.0)
        step(one, np.full((N, 3), np.nan), 1.0)
    assert one.mu == 0.6
