"""Soft landings: legs that follow the plan down, moved where the body is off it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import quaternion_from_rotation, rotation_about
from surefoot.motion.control.whole_body import WholeBodyController
from surefoot.motion.planning.tracking import Reference
from surefoot.motion.planning.tracking.landing import BRAKE, NEAR, SLOW, gently
from surefoot.motion.planning.tracking.legs_in_air import AirborneControl, Touchdown, touchdowns

ROBOT = sf.load_robot("go2")


@pytest.fixture(scope="module")
def goal(jump: Reference) -> Touchdown:
    """The end of the jump's flight, taken for a soft one on the front feet."""
    (end,) = touchdowns(jump)
    return replace(end, soft=True, landing=np.array([True, True, False, False]))


def seen(jump: Reference, goal: Touchdown, turn: float):
    """Return what the controller sees at the touchdown, with the body turned too far in pitch."""
    sample = jump.at(goal.end - 1e-9)
    q = sample.q.copy()
    q[3:7] = quaternion_from_rotation(rotation_about(sample.rotation[:, 1], turn) @ sample.rotation)
    return q, WholeBodyController(ROBOT, 0.5, 0.0).update(q, sample.v)


def test_on_the_plan_nothing_is_moved(jump: Reference, goal: Touchdown) -> None:
    _, now = seen(jump, goal, 0.0)
    np.testing.assert_allclose(AirborneControl(ROBOT, 60.0, 0.7).level_feet(now, goal, 0.0), 0.0, atol=1e-6)


def test_a_tilted_body_still_lands_its_feet_where_planned(jump: Reference, goal: Touchdown) -> None:
    q, now = seen(jump, goal, 0.1)
    moved = q.copy()
    moved[7:] += AirborneControl(ROBOT, 60.0, 0.7).level_feet(now, goal, 0.0)
    wanted = goal.feet[:2, [0, 2]]
    off = [np.abs((ROBOT.foot_positions(c) - ROBOT.com(q))[:2][:, [0, 2]] - wanted).max() for c in (q, moved)]
    assert off[0] > 0.015
    assert off[1] < 0.3 * off[0]
    np.testing.assert_array_equal(moved[13:], q[13:])  # the rear legs, which do not land
    np.testing.assert_array_equal(moved[[7, 10]], q[[7, 10]])  # abduction


def test_feet_near_the_ground_slow_down(jump: Reference) -> None:
    q = jump.q[0].copy()
    radii = ROBOT.contact_points.foot_radii
    v = np.zeros(18)
    v[2] = -2.0
    now = WholeBodyController(ROBOT, 0.5, 0.0).update(q, v)
    np.testing.assert_allclose(gently(now, radii), BRAKE * (2.0 - SLOW), atol=1e-6)
    q[2] += 2.0 * NEAR
    now = WholeBodyController(ROBOT, 0.5, 0.0).update(q, v)
    assert np.isneginf(gently(now, radii)).all()
