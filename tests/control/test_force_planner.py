"""Plans made over two steps of the controller, and the arrays that they need."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.mpc import BodyReference, BodyState, ConvexMpc
from surefoot.errors import ProblemError

FEET = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]


def test_another_step_length_is_that_of_a_fresh_controller() -> None:
    inertia = np.diag([0.1, 0.25, 0.3])
    state = BodyState(np.eye(3), np.array([0.0, 0.02, 0.3]), np.array([0.1, 0, 0]), np.array([0, 0.1, 0]))
    paced, fresh = (ConvexMpc(15.0, inertia, horizon=6, dt=dt) for dt in (0.03, 0.05))
    paced.solve(
        state,
        BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=6, dt=0.03),
        FEET,
        np.ones((6, 4), dtype=bool),
    )
    paced.pace(0.05)
    reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=6, dt=0.05)
    a, b = (mpc.solve(state, reference, FEET, np.ones((6, 4), dtype=bool)) for mpc in (paced, fresh))
    np.testing.assert_allclose(a.forces, b.forces, rtol=0.0, atol=0.05)
    with pytest.raises(ProblemError, match="dt"):
        paced.pace(0.0)


def test_shares_of_another_shape_are_refused() -> None:
    mpc = ConvexMpc(15.0, np.diag([0.1, 0.25, 0.3]), horizon=4)
    state = BodyState(np.eye(3), np.array([0, 0, 0.3]), np.zeros(3), np.zeros(3))
    reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=4)
    with pytest.raises(ProblemError, match="normal_share"):
        mpc.solve(state, reference, FEET, np.ones((4, 4), dtype=bool), normal_share=np.ones((3, 4)))
