"""The bound on the forces' error holds where torque limits bind; `hunt_forces.py` draws more."""

import numpy as np
from hunt_forces import hunt


def test_error_bounds_hold_where_torque_limits_bind():
    found, false = hunt(400, seed=1)
    assert len(found) > 300
    assert false == []
    claimed, true = found.T
    assert true.max() < 1e-5  # the answers themselves are good
    assert np.median(claimed) < 0.1  # and the bound says something
