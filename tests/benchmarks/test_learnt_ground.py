"""Settings of learnt ground are varied over what walks have sensed; differences of walks are paired."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks import learnt_ground
from benchmarks.ablation.varying import known_settings
from benchmarks.learnt_ground import FLOORS, Sensed, changed, compare, learn, record, vary
from surefoot.base.errors import ProblemError
from surefoot.motion.ground import stair_fit

NOTHING = dict.fromkeys(FLOORS, math.nan)


def test_a_difference_counts_beyond_noise_and_where_it_matters() -> None:
    before = [{**NOTHING, "height": 0.01 * k} for k in (1, 2, 3, 4)]
    worse = [{**NOTHING, "height": 0.01 * k + 0.004} for k in (1, 2, 3, 4)]
    noisy = [{**NOTHING, "height": 0.01 * k + (0.02 if k == 2 else -0.006)} for k in (1, 2, 3, 4)]
    small = [{**NOTHING, "height": 0.01 * k + 1e-5} for k in (1, 2, 3, 4)]
    assert compare(before, worse)["height"][1:] == (True, False)
    assert compare(worse, before)["height"][1:] == (False, True)
    assert compare(before, noisy)["height"][1:] == (False, False)
    assert compare(before, small)["height"][1:] == (False, False)
    assert set(compare(before, worse)) == {"height"}, "no walk has the others"


def test_a_setting_is_changed_for_a_while() -> None:
    before = stair_fit.STAIR_FIT
    with changed("StairFitSettings.near", 0.1) as own:
        assert own is None
        assert stair_fit.STAIR_FIT.near == 0.1
    assert stair_fit.STAIR_FIT is before
    with changed("MapSettings.spacing", 0.04) as own:
        assert own.spacing == 0.04


def test_other_values_go_outwards_until_one_is_worse(monkeypatch: pytest.MonkeyPatch) -> None:
    one = known_settings()["StairFitSettings.near"]
    tried: list[float] = []

    def judged(walk: Sensed, own: object = None) -> dict[str, float]:
        tried.append(stair_fit.STAIR_FIT.near)
        return {**NOTHING, "tread": 0.01 if stair_fit.STAIR_FIT.near <= one.value else 0.03}

    monkeypatch.setattr(learnt_ground, "learn", judged)
    walks = [Sensed("map", "stairs:0.12,0.3", seed) for seed in range(3)]
    before = [judged(walk) for walk in walks]
    found = vary(one, walks, before, (2.0, 10.0))
    assert found["verdict"] == f"as good from {one.value / 10:g} to {one.value:g}"
    assert max(tried) == 2.0 * one.value, "nothing beyond a value that is worse"


@pytest.mark.parametrize("factor", ["1", "0.5", "nan", "inf"])
def test_factors_are_above_one(factor: str) -> None:
    with pytest.raises(ProblemError, match=f"--factor must be above 1 and finite, got 3, {factor}"):
        learnt_ground.main(["StairFitSettings.near", "--factor", "3", factor])


@pytest.mark.long
def test_the_ground_that_is_learnt_anew_is_that_of_the_walk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learnt_ground, "DURATION", 2.0)
    sensed = record("map", "slope:15", 1)
    assert len(sensed.steps) < len(sensed.times)
    found = learn(sensed)
    assert found["height"] < 0.02
    assert found["slope"] < 0.1
    assert found["false"] == 0.0
    assert math.isnan(found["tread"])
    np.testing.assert_equal(learn(sensed), found)  # NaN is NaN
    with changed("MapSettings.anchor", 0.0) as own:
        assert learn(sensed, own)["height"] != found["height"]
