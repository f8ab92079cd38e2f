"""The trot in step with stairs."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import StairsTerrain, Terrain, read_terrain
from surefoot.motion.walking.pace_settings import STAIR_GAIT
from surefoot.motion.walking.stair_gait import speed_in_step, stair_gait
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController

HEIGHT, PERIOD = 0.3, 0.4


@pytest.mark.parametrize("rise", [0.12, -0.12])
@pytest.mark.parametrize("speed", [0.045, 0.18, 0.35, 0.4, 0.48, -0.4])
def test_a_tread_takes_a_whole_number_of_cycles(rise: float, speed: float) -> None:
    gait = stair_gait(StairsTerrain(rise, 0.3), VelocityCommand.constant(speed), HEIGHT, PERIOD, 4)
    assert gait is not None
    strides = 0.3 / (abs(speed) * gait.period)
    assert strides == pytest.approx(round(strides), abs=1e-9)
    assert gait.period <= STAIR_GAIT.longest_cycle * PERIOD * (1.0 + 1e-9)
    # with one stride less it would be too long
    assert round(strides) == 1 or gait.period * strides / (strides - 1.0) > STAIR_GAIT.longest_cycle * PERIOD


@pytest.mark.parametrize("terrain", ["flat", "slope:20", "stairs:0.05,0.3", "rough:1,0.03", "pit:1,0.3,0.1"])
def test_other_ground_and_low_steps_need_nothing(terrain: str) -> None:
    ground: Terrain = read_terrain(terrain, "terrain")
    assert stair_gait(ground, VelocityCommand.constant(0.4), HEIGHT, PERIOD, 4) is None


@pytest.mark.parametrize("rise", [0.08, 0.1, 0.12, -0.15])
@pytest.mark.parametrize("tread", [0.2, 0.3, 0.37, 0.5])
def test_between_one_stride_and_two_the_body_is_slowed_until_its_cycle_is_long_enough(
    rise: float, tread: float
) -> None:
    stairs = StairsTerrain(rise, tread)
    high = abs(rise) / HEIGHT
    one, more = (
        PERIOD * min(c[0] + c[1] * high, STAIR_GAIT.longest_cycle)
        for c in (STAIR_GAIT.single, STAIR_GAIT.several)
    )
    for speed in np.linspace(0.05, 1.0, 60).tolist():
        left = speed_in_step(stairs, speed, HEIGHT, PERIOD)
        gait = stair_gait(stairs, VelocityCommand.constant(left), HEIGHT, PERIOD, 4)
        assert gait is not None
        several = tread / (left * gait.period) > 1.5
        assert (more if several else one) <= gait.period * (1.0 + 1e-6)
        assert gait.period <= STAIR_GAIT.longest_cycle * PERIOD * (1.0 + 1e-6)
        assert left <= speed
        # what is left is the fastest: between it and the given speed no number of strides will do
        for between in np.linspace(left, speed, 7)[1:].tolist() if left < speed else []:
            strides = np.arange(1, 60)
            cycles, least = tread / (between * strides), np.where(strides > 1, more, one)
            short = tread / strides < STAIR_GAIT.longest_stride * HEIGHT
            assert not (short & (cycles > least) & (cycles < STAIR_GAIT.longest_cycle * PERIOD)).any()


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_who_stands_or_hurries_keeps_to_the_trot(speed: float) -> None:
    assert stair_gait(StairsTerrain(0.12, 0.3), VelocityCommand.constant(speed), HEIGHT, PERIOD, 4) is None


def test_the_controller_trots_in_step_and_says_so() -> None:
    robot, command = load_robot("go2"), VelocityCommand.constant(0.4)
    walker = WalkingController(robot, command, terrain=StairsTerrain(0.12, 0.3))
    assert walker.schedule.period == pytest.approx(0.75)  # type: ignore[attr-defined]
    assert any("0.75 s" in note for note in walker.notes)
    # on higher steps it is slowed, and in step with what is left
    for rise, tread, most in ((0.15, 0.3, 0.363), (0.12, 0.4, 0.257)):
        slow = WalkingController(robot, command, terrain=StairsTerrain(rise, tread))
        left = slow.command.at(1.0)[0]
        assert left == pytest.approx(most, abs=0.01)
        strides = tread / (slow.schedule.period * left)  # type: ignore[attr-defined]
        assert strides == pytest.approx(round(strides), abs=1e-6)
        assert sum("slowed" in note for note in slow.notes) == 1
    assert WalkingController(robot, command).schedule.period < 0.5  # type: ignore[attr-defined]
