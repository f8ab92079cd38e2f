"""Contact times against readings whose contacts are known."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError

GO1 = Path(__file__).resolve().parents[4] / "shared" / "data" / "go1_log" / "go1.csv"
DUTY, PERIOD, MASS, SCALE = 0.6, 0.5, 12.0, 0.125
OFFSETS = np.array([150.0, 0.0, -6.0, 40.0])


def trot(seconds: float = 15.0, rate: float = 400.0, noise: float = 1.0, seed: int = 0) -> sf.Log:
    """Return raw readings of a trot whose loads add up to m g at every instant."""
    rng = np.random.default_rng(seed)
    time = 3.7 + np.arange(0.0, seconds, 1.0 / rate)
    phase = ((time[:, None] - 3.7) / PERIOD + np.array([0.25, 0.75, 0.75, 0.25])) % 1.0
    load = np.where(phase < DUTY, np.sin(np.pi * np.minimum(phase / DUTY, 1.0)) ** 0.5 + 0.02, 0.0)
    load *= MASS * 9.81 / load.sum(axis=1, keepdims=True)
    raw = load / SCALE + OFFSETS + noise * rng.normal(size=load.shape)
    return sf.Log({"time": time, "foot_sensors": raw}, {"feet": ["FL", "FR", "RL", "RR"]})


def test_a_trots_contacts_are_found() -> None:
    times = sf.contact_times(trot())
    for foot, first in zip(times.feet, (0.75, 0.25, 0.25, 0.75), strict=True):
        assert not foot.refused
        true = 3.7 + PERIOD * (first + np.arange(len(foot.touchdowns)))
        np.testing.assert_allclose(foot.touchdowns, true, atol=0.01)
        assert foot.stride_period == pytest.approx(PERIOD, abs=2e-3)
        assert foot.duty_factor == pytest.approx(DUTY, abs=0.02)
        assert len(foot.strides) == len(foot.touchdowns) - 1 >= 28
    np.testing.assert_allclose([f.offset for f in times.feet], OFFSETS, atol=2.0)
    assert times["RL"].name == "RL"
    assert times.contacts.mean() == pytest.approx(DUTY, abs=0.02)
    with pytest.raises(ProblemError, match="unknown foot 'HL'; valid names: FL, FR"):
        times["HL"]


def change(log: sf.Log, foot: int, values: Any) -> sf.Log:
    raw = log["foot_sensors"].copy()
    raw[:, foot] = values
    return sf.Log({"time": log["time"], "foot_sensors": raw}, log.facts)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        (lambda r, n: np.full(n, 7.0), "the reading is 7 almost always"),
        (lambda r, n: 300.0 + r.normal(size=n), "times its noise"),
        (
            lambda r, n: 300.0 + 40.0 * np.sin(np.linspace(0, 3, n)) + r.normal(size=n),
            "no level of its own|noise",
        ),
        (lambda r, n: np.where(np.arange(n) == 5, np.nan, 1.0), "1 readings are not finite"),
        (lambda r, n: np.linspace(0.0, 900.0, n), "no level of its own in the air"),
    ],
)
def test_a_foot_that_tells_nothing_is_refused(values: Any, reason: str) -> None:
    log = trot()
    spoilt = change(log, 2, values(np.random.default_rng(1), len(log)))
    times = sf.contact_times(spoilt)
    assert [bool(f.refused) for f in times.feet] == [False, False, True, False]
    assert re.search(reason, times["RL"].refused)
    assert not times.contacts[:, 2].any()
    assert np.isnan(times["RL"].duty_factor)


def test_what_cannot_be_known_is_refused() -> None:
    log = trot()
    with pytest.raises(ProblemError, match="time that grows"):
        sf.contact_times(sf.Log({**log.arrays, "time": log["time"][::-1].copy()}))
    with pytest.raises(ProblemError, match="need the channel foot_sensors or forces; it has: time"):
        sf.contact_times(sf.Log({"time": log["time"]}))
    with pytest.raises(ProblemError, match="two rows"):
        sf.contact_times(log.rows(slice(0, 1)))


@pytest.mark.shared
@pytest.mark.skipif(not GO1.exists(), reason=f"no data file {GO1}")
def test_the_walking_go1() -> None:
    log = sf.read_log(GO1)
    times = sf.contact_times(log)
    for foot in times.feet:
        assert 38 <= len(foot.touchdowns) <= 50
        assert foot.stride_period == pytest.approx(0.5, abs=0.01)
        assert 0.5 < foot.duty_factor < 0.7
