"""What a planned motion is told of the limits of the robot's joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.mechanics.robot import Robot, place
from surefoot.motion.planning import rollout
from surefoot.motion.planning.tasks.scheduled import OVER, beyond_limits, judge_goal
from surefoot.motion.planning.trajectory import Trajectory


@pytest.fixture(scope="module")
def still(go2: Robot) -> Trajectory:
    return rollout(go2, place(go2), np.zeros(18), np.zeros((2, 12)), dt=0.01)


def within(go2: Robot, still: Trajectory) -> Trajectory:
    """Return a motion without torques that rests in the middle of all joints."""
    q, middle = still.q.copy(), 0.5 * (go2.model.lowerPositionLimit + go2.model.upperPositionLimit)
    q[:, 7:] = middle[7:]
    return replace(still, q=q, v=np.zeros_like(still.v), torques=np.zeros_like(still.torques))


@pytest.mark.parametrize(
    ("name", "over"), [("torque", 0.5), ("torque", -0.5), ("speed", 0.5), ("speed", -0.5), ("position", 0.5),
                       ("position", -0.5)],
)  # fmt: skip
def test_each_limit_is_told_by_how_much_it_is_exceeded(
    go2: Robot, still: Trajectory, name: str, over: float
) -> None:
    motion, side = within(go2, still), np.sign(over)
    assert beyond_limits(go2, motion) == ""
    if name == "torque":
        motion.torques[1, 4] = side * go2.effort_limits[4] + over
    elif name == "speed":
        motion.v[1, 6 + 7] = side * go2.speed_limits[7] + over
    else:
        limits = go2.model.upperPositionLimit if over > 0.0 else go2.model.lowerPositionLimit
        motion.q[2, 7 + 5] = limits[12] + over
    assert beyond_limits(go2, motion) == f"joints beyond their limits: {name} by 0.5"


def test_what_rounding_adds_is_not_told(go2: Robot, still: Trajectory) -> None:
    motion = within(go2, still)
    motion.torques[0, 3] = go2.effort_limits[3] + 0.5 * OVER
    assert beyond_limits(go2, motion) == ""


def test_a_goal_that_is_reached_beyond_limits_is_not_reached(go2: Robot, still: Trajectory) -> None:
    motion = within(go2, still)
    assert judge_goal(motion, go2, lambda m: (True, "stands")) == (True, "stands")
    assert judge_goal(motion, go2, lambda m: (False, "falls")) == (False, "falls")
    motion.torques[0, 0] = go2.effort_limits[0] + 1.0
    done, said = judge_goal(motion, go2, lambda m: (True, "stands"))
    assert not done
    assert said == "stands; joints beyond their limits: torque by 1"
    motion.q[1, 9] = np.nan
    assert judge_goal(motion, go2, lambda m: (True, "stands")) == (False, "the motion is lost")
