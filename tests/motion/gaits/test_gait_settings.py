"""Settings of gaits: the values that were tuned, and the ranges outside of which they mean nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from surefoot.base.errors import ProblemError
from surefoot.motion.gaits.gait_settings import GAIT_CHANGE, GAITS, GaitChangeSettings, GaitTimings

FACTOR, SHARE, TIME, PERIOD = (1.0, math.inf), (0.0, 1.0), (0.0, math.inf), (1e-3, math.inf)
CHANGE = {
    "stance_step": (1.35, FACTOR), "air_step": (1.15, FACTOR), "offset_step": (0.07, SHARE),
    "slow_offset_step": (0.02, SHARE), "nearly": (0.08, SHARE), "unfit": (1.1, FACTOR),
    "first_lift": (0.02, TIME), "earlier": (0.25, SHARE), "least_air": (0.95, SHARE),
}  # fmt: skip
TIMINGS = {
    "trot_period": (0.4, PERIOD), "trot_duty": (0.55, SHARE), "walk_period": (0.8, PERIOD),
    "walk_duty": (0.78, SHARE), "pace_period": (0.36, PERIOD), "pace_duty": (0.6, SHARE),
    "bound_period": (0.34, PERIOD), "bound_duty": (0.55, SHARE), "flying_trot_period": (0.34, PERIOD),
    "flying_trot_duty": (0.44, SHARE), "two_feet_period": (0.7, PERIOD), "two_feet_duty": (0.6, SHARE),
    "tripod_period": (0.45, PERIOD), "tripod_duty": (0.5, SHARE), "swing_time": (0.17, PERIOD),
    "beside": (0.2, SHARE),
}  # fmt: skip
ALL = [
    (kind, name, *row)
    for kind, rows in ((GaitChangeSettings, CHANGE), (GaitTimings, TIMINGS))
    for name, row in rows.items()
]


def test_the_values_in_use_are_those_that_were_tuned() -> None:
    assert vars(GAIT_CHANGE) == {name: value for name, (value, _) in CHANGE.items()}
    assert vars(GAITS) == {name: value for name, (value, _) in TIMINGS.items()}


@pytest.mark.parametrize(("kind", "name", "value", "ends"), ALL, ids=[name for _, name, *_ in ALL])
def test_a_setting_is_taken_within_its_range_alone(
    kind: Any, name: str, value: float, ends: tuple[float, float]
) -> None:
    """Factors from one on, shares from none to all, times from zero or a millisecond on."""
    low, high = ends
    most = high if math.isfinite(high) else 1e3
    for inside in (low, value, most):
        assert getattr(kind(**{name: inside}), name) == inside
    for outside in (low - 1e-4, *([high + 1e-4] if math.isfinite(high) else []), math.nan):
        with pytest.raises(ProblemError, match=name):
            kind(**{name: outside})
