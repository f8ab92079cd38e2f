from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError, ProblemError
from surefoot.motion.standing.standing_plan import Lift, StandingPlan


def plan(*lifts: Lift, degrees: float = 0.0) -> StandingPlan:
    robot, terrain = sf.load_robot("go2"), sf.SlopeTerrain(degrees)
    return StandingPlan(robot, terrain, sf.place(robot, terrain), lifts)


def test_without_lifts_everything_stands_still() -> None:
    target = plan().at(3.0)
    assert target.stance.all()
    assert not target.velocity.any()
    np.testing.assert_array_equal(target.load, 1.0)


@pytest.mark.parametrize("degrees", [0.0, 15.0])
def test_weight_moves_over_the_other_feet_before_a_lift(degrees: float) -> None:
    p = plan(Lift("FL", 1.0, 2.0), degrees=degrees)
    contacts = np.delete(p._contacts, 0, axis=0)
    com = p.com(0)
    np.testing.assert_allclose(com[:2], contacts.mean(axis=0)[:2], atol=1e-9)
    np.testing.assert_allclose(p.at(1.5).position, p.shifted(0), atol=1e-12)
    moved = p.shifted(0) - p.start
    assert abs(moved @ p.terrain.normal([0.0, 0.0])) < 1e-12  # along the ground
    assert not p.at(1.5).stance[0]
    assert p.at(0.999).stance.all()
    assert p.at(2.0).stance.all()
    assert 0.0 < p.at(0.95).load[0] < 1.0
    np.testing.assert_allclose(p.at(5.0).position, p.start)


def test_targets_are_consistent_derivatives_and_feet_come_down() -> None:
    p = plan(Lift("FL", 1.0, 2.0), Lift("RR", 4.0, 4.5))
    h = 1e-6
    for t in np.linspace(0.1, 6.0, 60):
        now, ahead, behind = p.at(t), p.at(t + h), p.at(t - h)
        np.testing.assert_allclose((ahead.position - behind.position) / (2 * h), now.velocity, atol=1e-6)
        np.testing.assert_allclose((ahead.velocity - behind.velocity) / (2 * h), now.acceleration, atol=1e-3)
    assert p.at(1.5).height[0] > 0.02
    for t in (1.0, 1.999999, 4.0, 4.4999999):
        assert p.at(t).height.max() < 1e-6


def test_impossible_plans_are_refused() -> None:
    with pytest.raises(ProblemError, match="must end after it starts"):
        plan(Lift("FL", 2.0, 1.0))
    with pytest.raises(ProblemError, match="no time to shift the weight"):
        plan(Lift("FL", 0.1, 1.0))
    with pytest.raises(ProblemError, match="no time to shift the weight"):
        plan(Lift("FL", 1.0, 2.0), Lift("FR", 2.1, 3.0))
    with pytest.raises(ModelError, match="unknown foot of go2 'left'"):
        plan(Lift("left", 1.0, 2.0))
