"""Landings that are none are doubted: forces above the ground, and feet that feel nothing right after."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.motion.walking.feet_settings import TOUCHDOWN
from surefoot.motion.walking.touchdown_detection import TouchMemory, accept_landings, false_landings

DT = 1e-3
AIR = np.zeros(1, dtype=bool)
GROUND = ~AIR


class LandingWatch:
    """The sense of touch of one foot, moved on step by step."""

    def __init__(self) -> None:
        self.memory = TouchMemory.of(1)

    def believe(self, sensed: BoolArray, stance: BoolArray, above: FloatArray) -> BoolArray:
        self.memory, ground = accept_landings(self.memory, sensed, stance, above, DT)
        return ground

    def taken_back(self, stance: BoolArray) -> BoolArray:
        self.memory, false = false_landings(self.memory, stance, DT)
        return false


@pytest.mark.parametrize(
    ("above", "after"),
    [(0.0, DT), (0.9, DT), (2.0, TOUCHDOWN.lasting), (2.0 * TOUCHDOWN.far, TOUCHDOWN.lasting_far)],
)
def test_the_higher_a_force_is_felt_the_longer_it_must_last(above: float, after: float) -> None:
    watch = LandingWatch()
    heights, times = np.array([above]), []
    for k in range(200):
        if watch.believe(GROUND, AIR, heights)[0]:
            times.append((k + 1) * DT)
    assert times[0] == pytest.approx(after, abs=1.5 * DT)
    watch.believe(AIR, AIR, heights)  # a pause begins it anew
    assert watch.believe(GROUND, AIR, heights)[0] == (above < 1.0)
    assert watch.believe(GROUND, GROUND, heights)[0]  # what stands is not doubted
    assert not watch.believe(AIR, AIR, heights)[0]


def test_only_a_young_landing_is_taken_back_and_only_when_it_is_silent() -> None:
    cases = (
        (0.01, TOUCHDOWN.silent + DT, True),
        (0.01, 0.5 * TOUCHDOWN.silent, False),
        (TOUCHDOWN.young, 0.05, False),
    )
    for stood, silent, wanted in cases:
        watch = LandingWatch()
        watch.taken_back(AIR)  # it has been in the air
        backs = []
        for k in range(round((stood + silent) / DT)):
            watch.believe(GROUND if k * DT < stood else AIR, GROUND, np.zeros(1))
            backs.append(watch.taken_back(GROUND)[0])
        assert any(backs) == wanted


def test_feet_that_stood_from_the_start_are_not_doubted() -> None:
    watch = LandingWatch()
    for _ in range(30):
        watch.believe(AIR, GROUND, np.zeros(1))
        assert not watch.taken_back(GROUND)[0]
