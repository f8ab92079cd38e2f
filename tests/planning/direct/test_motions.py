"""Problems from rest to rest, and finer knots for the same motion."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.errors import ProblemError
from surefoot.planning.direct import finer, plan_direct, planar_hopper, rest_to_rest
from surefoot.robot import load_robot
from surefoot.terrain import SlopeTerrain

pytest.importorskip("casadi")


def test_the_end_stands_on_the_slope_further_up() -> None:
    problem = rest_to_rest(planar_hopper(), 0.3, terrain=SlopeTerrain(10.0))
    climbed = problem.references[-1, 1] - problem.q[1]
    assert climbed == pytest.approx(0.3 * np.tan(np.radians(10.0)))
    low, high = problem.state_bounds()
    assert np.array_equal(low[0], high[0])
    assert (high[-1, :2] - low[-1, :2]).max() <= 2.001e-3


def test_a_jump_is_at_its_height_when_it_has_to_be() -> None:
    problem = rest_to_rest(planar_hopper(), 0.2, 0.15)
    found = plan_direct(problem)
    assert found.miss <= 1e-3
    (k,) = problem.windows
    assert found.trajectory.q[k, 1] >= problem.q[1] + 0.15 - 1e-6
    assert found.trajectory.gaps[k, 0] > 0.02


def test_finer_knots_are_the_same_problem() -> None:
    coarse = rest_to_rest(planar_hopper(), 0.2, 0.15, knots=20, dt=0.03)
    fine = finer(coarse, 3)
    assert (fine.knots, fine.knots * fine.dt) == (60, pytest.approx(coarse.knots * coarse.dt))
    assert set(fine.windows) == {3 * k for k in coarse.windows}
    low, high = coarse.state_bounds()
    below, above = fine.state_bounds()
    assert np.array_equal(below[::3], low)
    assert np.array_equal(above[::3], high)
    assert np.array_equal(fine.references[::3], coarse.references)


def test_what_cannot_go_anywhere() -> None:
    with pytest.raises(ProblemError, match="robots in a plane, ur5"):
        rest_to_rest(load_robot("ur5"), 0.1)
    with pytest.raises(ProblemError, match="rise must be a number"):
        rest_to_rest(planar_hopper(), 0.1, -0.1)
