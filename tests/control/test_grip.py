"""Friction as the feet find it: what a slide teaches, how fast, and what it slows."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.grip import Grip
from surefoot.control.whole_body_tasks import Kinematics

N, WEIGHT, HEIGHT, DT = 4, 160.0, 0.3, 0.001
FRAMES, ALL = np.tile(np.eye(3), (N, 1, 1)), np.ones(N, dtype=bool)


def moving(speed: float) -> Kinematics:
    """Return a robot whose first foot moves forward, its others at rest."""
    twists = np.zeros((N, 6))
    twists[0, 0] = speed
    z = np.zeros(3)
    return Kinematics(z, z, np.eye(3), z, np.zeros((N, 3)), twists, np.zeros((N, 6)))


def forces(use: float) -> np.ndarray:
    """Return forces of 40 N on each foot with that use of friction."""
    return np.tile([-use * 40.0, 0.0, 40.0], (N, 1))


def grip() -> Grip:
    return Grip(np.full(N, 0.02), WEIGHT, HEIGHT, DT, 0.6)


def test_feet_that_stand_change_nothing() -> None:
    one = grip()
    for _ in range(300):
        one.update(forces(0.4), moving(0.0), FRAMES, ALL)
    assert one.mu == 0.6
    assert one.limit(np.array([2.0, 0.0, 0.1])).tolist() == [2.0, 0.0, 0.1]


def test_a_slide_is_believed_within_twenty_milliseconds_and_forgotten_later() -> None:
    one = grip()
    for _ in range(50):
        one.update(forces(0.15), moving(0.0), FRAMES, ALL)
    for _ in range(20):
        one.update(forces(0.2), moving(0.4), FRAMES, ALL)
    assert one.mu == pytest.approx(0.18, abs=0.02)  # a tenth below what the slide showed
    assert one.sliding.tolist() == [True, False, False, False]
    for _ in range(15_000):
        one.update(forces(0.1), moving(0.0), FRAMES, ALL)
    assert one.mu > 0.55


def test_slippery_ground_slows_speed_and_its_change() -> None:
    one = grip()
    before = one.acceleration
    for _ in range(60):
        one.update(forces(0.1), moving(0.4), FRAMES, ALL)
    command = np.array([0.8, 0.6, 0.5])
    slowed = one.limit(command)
    assert np.cross(slowed, command) == pytest.approx(0.0)  # same direction, all of it slower
    assert np.linalg.norm(slowed[:2]) == pytest.approx(1.7 * one.mu * np.sqrt(9.80665 * HEIGHT), rel=1e-3)
    assert one.acceleration < 0.2 * before


def test_feet_in_the_air_and_missing_forces_tell_nothing() -> None:
    one = grip()
    air = ALL.copy()
    air[0] = False
    for _ in range(100):
        one.update(forces(0.1), moving(1.0), FRAMES, air)
        one.update(None, moving(1.0), FRAMES, ALL)
        one.update(np.full((N, 3), np.nan), moving(1.0), FRAMES, ALL)
    assert one.mu == 0.6


def test_reset_forgets() -> None:
    one = grip()
    for _ in range(60):
        one.update(forces(0.1), moving(0.4), FRAMES, ALL)
    one.reset()
    assert one.mu == 0.6
    assert one.update(forces(0.1), moving(0.0), FRAMES, ALL) == 0.6
