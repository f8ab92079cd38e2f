"""What the benchmark of terrain knowledge says of a walk, also of one that ended at once."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.terrain_knowledge import _rms, _smooth


def test_motion_is_averaged_over_twenty_milliseconds() -> None:
    steady = np.arange(100.0)
    assert _smooth(steady) == pytest.approx(np.arange(9.5, 90.0))
    assert _rms(np.array([3.0, -4.0])) == pytest.approx(np.sqrt(12.5))


@pytest.mark.parametrize("length", [0, 1, 19])
def test_a_walk_that_ended_at_once_has_no_motion(length: int) -> None:
    assert _smooth(np.ones(length)).size == 0
    assert np.isnan(_rms(_smooth(np.ones(length))))
