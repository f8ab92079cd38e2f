"""What a law's fit says of the body is not surer than what the frames after the first touch said."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.records.identification.identify import begin_fit, identify
from surefoot.records.identification.toss_model import ThrownModel
from surefoot.records.identification.toss_refit import wider_draws


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
