"""A reference: what it says between its knots, moved elsewhere, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_about
from surefoot.motion.planning import PlanSearch, plan_from, rollout
from surefoot.motion.planning.tracking import Reference

ROBOT = sf.load_robot("go2")


def test_knots_are_met_and_the_way_between_is_smooth(jump: Reference) -> None:
    for k in (0, 17, 60, len(jump.time) - 1):
        sample = jump.at(float(jump.time[k]))
        np.testing.assert_allclose(sample.q, jump.q[k], atol=1e-12)
        np.testing.assert_allclose(sample.com, ROBOT.com(jump.q[k]), atol=1e-12)
    times = np.linspace(0.0, jump.duration, 400)
    steps = np.diff([jump.at(t).com for t in times], axis=0)
    assert np.abs(steps).max() < 3.0 * jump.duration / 400


def test_forces_give_the_acceleration(jump: Reference) -> None:
    """In flight nothing but gravity acts; on the ground the centre of mass obeys Newton."""
    (start, end), *_ = jump.airborne_phases()
    np.testing.assert_allclose(jump.at(0.5 * (start + end)).com_acceleration, [0.0, 0.0, -9.81])
    assert not jump.at(0.5 * (start + end)).stance.any()
    sample = jump.at(0.5 * start)
    np.testing.assert_allclose(sample.com_acceleration, sample.forces.sum(axis=0) / ROBOT.mass - [0, 0, 9.81])


def test_laid_elsewhere_is_the_same_motion(jump: Reference) -> None:
    """Moved and turned feet get the motion that goes with them: the same joints, everything else turned."""
    turn = rotation_about([0.0, 0.0, 1.0], 0.7)
    moved = jump.place_on(jump.feet[0] @ turn.T + [2.0, -1.0, 0.0])
    np.testing.assert_allclose(moved.feet[40], jump.feet[40] @ turn.T + [2.0, -1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(moved.com_velocity, jump.com_velocity @ turn.T, atol=1e-9)
    np.testing.assert_allclose(moved.forces[40], jump.forces[40] @ turn.T, atol=1e-9)
    np.testing.assert_allclose(moved.q[:, 7:], jump.q[:, 7:])
    np.testing.assert_allclose(moved.q[:, 2], jump.q[:, 2])


def test_of_a_plan() -> None:
    motion = rollout(ROBOT, sf.place(ROBOT), np.zeros(18), np.zeros((6, 12)), dt=0.01)
    plan = plan_from(motion, ROBOT, PlanSearch("fall", "none", 0.0, True, 0, 0.0))
    reference = Reference.of(plan, ROBOT)
    np.testing.assert_allclose(reference.q, motion.q)
    np.testing.assert_allclose(reference.forces * 0.01, motion.impulses)
    assert reference.duration == pytest.approx(0.06)
    assert reference.begins_standing


def test_what_is_no_reference(jump: Reference) -> None:
    parts = (jump.time, jump.q, jump.v, jump.forces)
    with pytest.raises(ProblemError, match="times"):
        Reference(ROBOT, jump.time[::-1], *parts[1:])
    with pytest.raises(ProblemError, match="q"):
        Reference(ROBOT, jump.time, jump.q[:-1], *parts[2:])
    with pytest.raises(ProblemError, match="stance"):
        Reference(ROBOT, *parts, np.ones((3, 4), dtype=bool))
    with pytest.raises(ProblemError, match="forces"):
        Reference.of(sf.Log({"time": np.zeros(2), "q": np.zeros((2, 19)), "v": np.zeros((2, 18)),
                             "torques": np.zeros((2, 12))}), ROBOT)  # fmt: skip


def test_attitudes_alone_are_those_of_the_samples(jump: Reference) -> None:
    for t in np.linspace(0.0, jump.duration, 23):
        np.testing.assert_allclose(jump.attitude_at(float(t)), jump.at(float(t)).rotation, atol=1e-9)


def test_a_motion_is_laid_on_some_feet_at_some_time(jump: Reference) -> None:
    time, which = 0.9 * jump.duration, np.array([True, True, False, False])
    turn = rotation_about([0.0, 0.0, 1.0], 0.3)
    there = jump.feet_at(time)[0] @ turn.T + [0.2, -0.1, 0.0]
    there[2:] += 5.0  # of those that do not count
    laid = jump.place_on(there, time, which)
    np.testing.assert_allclose(laid.feet_at(time)[0][:2], there[:2], atol=1e-6)
