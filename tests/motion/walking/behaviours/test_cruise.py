"""Commands slowed by what has been learned of the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import SlopeTerrain, StairsTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.ground.mapped_ground import MappedGround
from surefoot.motion.ground.touched_ground import TouchedGround
from surefoot.motion.walking.behaviours.behaviour import NOTHING
from surefoot.motion.walking.behaviours.behaviour_settings import CruiseSettings
from surefoot.motion.walking.behaviours.cruise import Cruise
from surefoot.motion.walking.command_limits import ground_left
from surefoot.motion.walking.stair_gait import speed_in_step
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from tests.motion.walking.behaviours.views import view_of, walk_of

MU, HEIGHT, RADIUS, DT = 0.54, 0.316, 0.25, 1e-3
TROT = named_gait("trot", 4, HEIGHT)
FEET = np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]])


class Stairs(TouchedGround):
    """A belief that has found stairs of 12 cm by 30 cm."""

    steepness, highest_step = 0.4, 0.12  # type: ignore[assignment]


def begun(belief: TouchedGround, slope: float = 0.0) -> TouchedGround:
    belief.begin(RobotState(np.zeros(7), np.zeros(6)), np.c_[FEET, slope * FEET[:, 0]], HEIGHT)
    return belief


def cruise(belief: TouchedGround, schedule: ContactSchedule = TROT) -> Cruise:
    """Return the behaviour on a ground that is believed in."""
    return Cruise(walk_of(belief, schedule)._replace(mu=MU, height=HEIGHT, friction_share=1.0))


def cap(one: Cruise, command: FloatArray) -> float:
    """Return the speed that it asks not to pass [m/s]."""
    return one.propose(view_of(command)).speed_cap


def adaptive() -> ContactSchedule:
    walker = WalkingController(load_robot("go2"), VelocityCommand.constant(0.4), terrain=MappedGround())
    assert walker.schedule.adapts
    return walker.schedule


def test_a_gait_that_is_not_fit_for_more_speed_keeps_what_it_has() -> None:
    now, one = np.array([0.3, 0.0, 0.1]), Cruise(walk_of())
    assert one.propose(view_of((0.5, 0.0, 0.0), velocity=now)) is NOTHING
    unfit = one.propose(view_of((0.5, 0.0, 0.0), velocity=now, fits=False))
    assert unfit.at_most is now


def test_a_slope_that_feet_have_found_slows_as_a_known_one_does() -> None:
    one = cruise(begun(TouchedGround(), math.tan(math.radians(20.0))))
    most = CruiseSettings().slack * ground_left(SlopeTerrain(20.0), MU, HEIGHT).fastest
    assert cap(one, np.array([0.8, 0.3, 0.0])) == pytest.approx(
        most, rel=5e-3
    )  # the plane is damped a little
    assert cap(cruise(begun(TouchedGround())), np.array([0.8, 0.3, 0.0])) == math.inf


@pytest.mark.parametrize("speed", [0.15, 0.3, 0.4, 0.41, -0.6, 0.9])
@pytest.mark.sampled(2)
def test_stairs_that_have_been_found_are_taken_as_known_ones_are(speed: float) -> None:
    schedule, command = adaptive(), np.array([speed, 0.0, 0.0])
    stairs = StairsTerrain(0.12, 0.3)
    most = min(abs(speed), CruiseSettings().slack * ground_left(stairs, MU, HEIGHT).fastest)
    wanted = speed_in_step(stairs, most, HEIGHT, TROT.period)
    assert min(abs(speed), cap(cruise(begun(Stairs()), schedule), command)) == pytest.approx(wanted)
    # a gait with a timing of its own does not walk in step
    assert min(abs(speed), cap(cruise(begun(Stairs())), command)) == pytest.approx(most)
