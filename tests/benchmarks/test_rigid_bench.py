from __future__ import annotations

import numpy as np
import pytest

from benchmarks.rigid_world import drop


@pytest.mark.long
def test_drop_is_measured_in_both_worlds():
    results = [drop(world, "go2", 0.05, 1.0) for world in ("rigid", "mujoco")]
    for result in results:
        assert 0.0 < result.wall < 60.0
        assert result.contacts == 4
        assert result.weight_error < 0.2
    assert results[0].energy_made <= 0.0
    assert results[0].penetration < 1e-5 < results[1].penetration
    assert np.isnan(results[1].energy_made)
