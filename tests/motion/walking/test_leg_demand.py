"""Joint speeds and torques of a gait against a leg that is moved along the same path."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.motion.gaits.adaptive_gait import Pace
from surefoot.motion.walking.leg_demand import LegDemand
from surefoot.motion.walking.swing import even_swing
from tests.robots import go2

HEIGHT, PACE = 0.316, Pace(0.36, 0.45, 0.05)


def solved(place: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the pose near q whose feet are at (4, 3) places, by Newton with numeric Jacobians."""
    robot, now = go2(), q.copy()
    for _ in range(6):
        here = robot.foot_positions(now)
        jacobian = np.empty((12, 12))
        for j in range(12):
            moved = now.copy()
            moved[7 + j] += 1e-6
            jacobian[:, j] = (robot.foot_positions(moved) - here).ravel() / 1e-6
        now[7:] += np.linalg.solve(jacobian, (place - here).ravel())
    return now


@pytest.mark.parametrize("velocity", [(1.2, 0.0, 0.0), (-0.6, 0.0, 0.0), (0.0, 0.5, 0.0), (0.3, 0.0, 1.0)])
def test_speeds_are_those_of_legs_moved_along_the_cycle(velocity: tuple[float, float, float]) -> None:
    table = LegDemand(go2(), np.array(velocity), HEIGHT)
    centres = go2().foot_positions(go2().nominal)
    about = centres[:, :2] - centres[:, :2].mean(axis=0)
    moves = np.column_stack(
        [velocity[0] - velocity[2] * about[:, 1], velocity[1] + velocity[2] * about[:, 0]]
    )
    air = PACE.period - PACE.stance_time
    poses, q = [], go2().nominal
    for share in np.linspace(0.0, 1.0, 61):
        place = centres.copy()
        for k in range(4):
            start = np.array([*(-0.5 * PACE.stance_time * moves[k]), 0.0])
            target = start + np.array([*(PACE.period * moves[k]), 0.0])
            place[k] += even_swing(start, target, PACE.clearance, share, air, 0.0)[0]
            place[k, :2] -= share * air * moves[k]
        q = solved(place, q)
        poses.append(q[7:].copy())
    speeds = np.abs(np.diff(np.array(poses), axis=0)).max(axis=0) / (air / 60.0)
    assert table.speeds(PACE) == pytest.approx(speeds, rel=0.05, abs=0.1)
    assert table.rates == pytest.approx(np.linalg.norm(moves, axis=1))


def test_torques_in_a_stance_hold_the_weight() -> None:
    import pinocchio

    robot = go2()
    table = LegDemand(robot, np.array([0.4, 0.0, 0.0]), HEIGHT)
    pace = Pace(0.4, 1.0, 0.05)
    up = np.array([0.0, 0.0, 1.0])
    push = robot.mass * 9.81 / 4.0
    standing = np.array(pinocchio.computeGeneralizedGravity(robot.model, robot.data, robot.nominal))[6:]
    pinocchio.computeJointJacobians(robot.model, robot.data, robot.nominal)
    robot.foot_positions(robot.nominal)
    for foot in robot.feet:
        arm = robot.data.oMf[robot.model.getFrameId(foot.name)].rotation @ foot.centre
        J = pinocchio.getFrameJacobian(
            robot.model, robot.data, robot.model.getFrameId(foot.name), pinocchio.LOCAL_WORLD_ALIGNED
        )
        standing -= push * (J[2] + np.cross(J[3:].T, arm)[:, 2])[6:]
    still = table.torques(pace, 1e-6, up, 1.0)
    assert (still >= np.abs(standing) - 1e-6).all()
    assert still == pytest.approx(np.abs(standing), rel=0.6, abs=1.5)  # the table's next places count as well
    assert (table.torques(pace, 1.0, up, 2.0) > still).all()


def test_what_legs_do_not_reach_is_infinite() -> None:
    table = LegDemand(go2(), np.array([1.0, 0.0, 0.0]), HEIGHT)
    assert np.isinf(table.speeds(Pace(0.5, 0.8, 0.05), 2.5)).any()
    assert np.isfinite(table.speeds(PACE)).all()
