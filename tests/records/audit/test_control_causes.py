"""Causes that torques tell of their controller: chatter, beside what noise and held torques look like."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.records.audit.story.control_causes import chatter
from surefoot.records.audit.story.signals import Signals
from tests.records.audit.made_signals import made_signals

DT, LIMIT = 0.002, 20.0


def signals(asked: np.ndarray, hold: int) -> Signals:
    """Return what is known of one motor that is asked for torques, each held for so many rows."""
    torques = np.repeat(asked, hold)[:, None]
    arrays = {
        "time": DT * np.arange(len(torques)), "torques": torques, "forces": np.zeros((len(torques), 1, 3)),
    }  # fmt: skip
    facts = {"effort_limits": np.array([LIMIT]), "mass": 10.0}
    return made_signals(arrays, facts, ("foot",), 98.1, DT)


def alternating(count: int) -> np.ndarray:
    return 0.4 * LIMIT * (-1.0) ** np.arange(count)


@pytest.mark.parametrize("seed", range(5))
def test_noise_that_is_held_is_no_chatter(seed: int) -> None:
    """Of independent torques two of three turn, far more than of those that follow a motion."""
    noise = np.random.default_rng(seed).uniform(-LIMIT, LIMIT, 200)
    assert not list(chatter(signals(noise, 10)))
    assert list(chatter(signals(noise, 1)))  # asked for anew in every row nothing but chatter turns so often


@pytest.mark.parametrize("hold", [1, 10])
def test_torques_that_turn_each_time_are_chatter_held_or_not(hold: int) -> None:
    calm = 0.4 * LIMIT + 0.01 * np.arange(60)
    (found,) = chatter(signals(np.concatenate([calm, alternating(60)]), hold))
    assert found.where == "joint 0"
    assert found.time == pytest.approx(60 * hold * DT, abs=30 * hold * DT)


def test_a_few_held_torques_that_turn_by_chance_are_no_chatter() -> None:
    steady = 0.4 * LIMIT + 0.01 * np.arange(100)
    few = np.concatenate([steady, alternating(12), steady])
    assert not list(chatter(signals(few, 10)))
