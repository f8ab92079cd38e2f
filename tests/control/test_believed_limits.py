"""Commands slowed by what has been learned of the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.arrays import FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait
from surefoot.control.believed_limits import FOLLOW, SLACK, BelievedLimits
from surefoot.control.command_limits import ground_left
from surefoot.control.controller import RobotState
from surefoot.control.gait import ContactSchedule
from surefoot.control.gait_library import named_gait
from surefoot.control.stair_gait import speed_in_step
from surefoot.control.terrain_knowledge import MappedGround, TouchedGround
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.robot import load_robot
from surefoot.terrain import SlopeTerrain, StairsTerrain

MU, HEIGHT, RADIUS, DT = 0.54, 0.316, 0.25, 1e-3
TROT = named_gait("trot", 4, HEIGHT)
FEET = np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]])


class Stairs(TouchedGround):
    """A belief that has found stairs of 12 cm by 30 cm."""

    steepness, highest_step = 0.4, 0.12  # type: ignore[assignment]


def begun(belief: TouchedGround, slope: float = 0.0) -> TouchedGround:
    belief.begin(RobotState(np.zeros(7), np.zeros(6)), np.c_[FEET, slope * FEET[:, 0]], HEIGHT)
    return belief


def limits(belief: TouchedGround, schedule: ContactSchedule = TROT) -> BelievedLimits:
    return BelievedLimits(belief, MU, HEIGHT, RADIUS, schedule, DT)


def adaptive() -> ContactSchedule:
    walker = WalkingController(load_robot("go2"), VelocityCommand.constant(0.4), terrain=MappedGround())
    assert isinstance(walker.schedule, AdaptiveGait)
    return walker.schedule


@pytest.mark.parametrize("command", [[0.8, 0.3, 0.0], [-0.7, 0.0, 1.5], [0.2, 0.0, 0.0]])
def test_a_slope_that_feet_have_found_slows_as_a_known_one_does(command: list[float]) -> None:
    asked, one = np.array(command), limits(begun(TouchedGround(), math.tan(math.radians(20.0))))
    assert one.limit(asked) == pytest.approx(asked)  # nothing has been learned yet
    one.learn()  # it stands there
    most = SLACK * ground_left(SlopeTerrain(20.0), MU, HEIGHT).fastest
    size = math.hypot(*asked[:2]) + RADIUS * abs(asked[2])
    assert one.limit(asked) == pytest.approx(
        asked * min(1.0, most / size), rel=5e-3
    )  # the plane is damped a little
    assert bool(size > most) is (command[0] != 0.2)
    one.reset()
    assert one.limit(asked) == pytest.approx(asked)


def test_the_slope_is_followed_slowly() -> None:
    one, ground = limits(begun(TouchedGround(), 0.1)), begun(TouchedGround(), 0.4)
    one.learn()
    before, one.belief = one._slope[0], ground
    for _ in range(round(FOLLOW / DT)):
        one.learn()
    wanted = before + (1.0 - math.exp(-1.0)) * (0.4 - before)
    assert one._slope == pytest.approx([wanted, 0.0], rel=5e-3)


@pytest.mark.parametrize("speed", [0.15, 0.3, 0.4, 0.41, -0.6, 0.9])
def test_stairs_that_have_been_found_are_taken_as_known_ones_are(speed: float) -> None:
    schedule, asked = adaptive(), np.array([speed, 0.0, 0.0])
    left: FloatArray = limits(begun(Stairs()), schedule).limit(asked)
    stairs = StairsTerrain(0.12, 0.3)
    most = min(abs(speed), SLACK * ground_left(stairs, MU, HEIGHT).fastest)
    wanted = speed_in_step(stairs, most, HEIGHT, TROT.period)
    assert left == pytest.approx([math.copysign(wanted, speed), 0.0, 0.0])
    # a gait with a timing of its own does not walk in step
    assert abs(limits(begun(Stairs())).limit(asked)[0]) == pytest.approx(most)
