"""What a law's fit says of the body is not surer than what the frames after the first touch said."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.records.identification.identify import begin_fit, identify
from surefoot.records.identification.toss_model import ThrownModel
from surefoot.records.identification.toss_refit import estimate_of, wider_draws


def test_the_wider_draws_are_kept_whatever_their_order() -> None:
    rng = np.random.default_rng(0)
    narrow, wide = rng.normal(size=400), 3.0 + 2.0 * rng.normal(size=400)
    assert wider_draws(narrow, wide) is wide
    assert wider_draws(wide, narrow) is wide
    # a few that are far off, as a jagged loss has them, are no width
    narrow[:4] = 1e3
    assert wider_draws(narrow, wide) is wide


@pytest.mark.long
def test_intervals_of_the_body_do_not_shrink_with_a_law() -> None:
    """Half of the intervals of the scale did not hold it."""
    recorded, model = random_tosses(8, [0.18, 0.15, 0.0026], seed=3), ThrownModel()
    begun = begin_fit(recorded, model, resamples=40)
    fitted = identify(recorded, model, found=begun, resamples=40)
    for name in ("scale", "ground", "com_z", "spread_x"):
        before, after = begun.parameters[name], fitted[name]
        assert after.low <= after.value <= after.high
        reach = np.ptp(np.percentile(begun.draws[name], [2.5, 97.5]))
        assert after.high - after.low >= 0.99 * reach, (name, before, after)
        assert after.low <= before.low <= before.high <= after.high, (name, before, after)
    early = begun.draws["rounding"]
    assert fitted["rounding"].low <= np.percentile(early, 2.5)
    assert fitted["rounding"].high >= np.percentile(early, 97.5)


def test_an_interval_holds_its_value_and_spans_what_was_told_before() -> None:
    draws = np.linspace(0.0, 1.0, 1001)
    alone, outside = estimate_of(0.4, draws, "m"), estimate_of(2.0, draws, "m")
    assert (alone.low, alone.high) == pytest.approx((0.025, 0.975))
    assert (outside.low, outside.high) == pytest.approx((0.025, 2.0))
    both = estimate_of(0.4, draws, "m", np.linspace(-3.0, -2.0, 201))  # of fewer resamples
    assert (both.value, both.low, both.high) == pytest.approx((0.4, -2.975, 0.975))
