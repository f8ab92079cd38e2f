"""The trot in step with stairs."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control.stair_gait import LONGEST, stair_gait
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.robot import load_robot
from surefoot.terrain import StairsTerrain, Terrain, read_terrain

HEIGHT, PERIOD = 0.3, 0.4


@pytest.mark.parametrize("rise", [0.12, -0.12])
@pytest.mark.parametrize("speed", [0.05, 0.2, 0.35, 0.4, 0.6, -0.4])
def test_a_tread_takes_a_whole_number_of_cycles(rise: float, speed: float) -> None:
    gait = stair_gait(StairsTerrain(rise, 0.3), VelocityCommand.constant(speed), HEIGHT, PERIOD, 4)
    assert gait is not None
    strides = 0.3 / (abs(speed) * gait.period)
    assert strides == pytest.approx(round(strides), abs=1e-9)
    assert gait.period <= LONGEST * PERIOD * (1.0 + 1e-9)
    # with one stride less it would be too long
    assert round(strides) == 1 or gait.period * strides / (strides - 1.0) > LONGEST * PERIOD


def test_two_feet_at_least_carry_and_half_the_time_more() -> None:
    gait = stair_gait(StairsTerrain(0.12, 0.3), VelocityCommand.constant(0.4), HEIGHT, PERIOD, 4)
    assert gait is not None
    times = (np.arange(2000) + 0.5) / 2000 * gait.period
    down = gait.contacts(times)
    assert down.mean(axis=0) == pytest.approx(0.6, abs=1e-3)
    assert down.sum(axis=1).min() == 2
    assert (down.sum(axis=1) > 2).mean() > 0.35


@pytest.mark.parametrize("terrain", ["flat", "slope:20", "stairs:0.05,0.3", "rough:1,0.03", "pit:1,0.3,0.1"])
def test_other_ground_and_low_steps_need_nothing(terrain: str) -> None:
    ground: Terrain = read_terrain(terrain, "terrain")
    assert stair_gait(ground, VelocityCommand.constant(0.4), HEIGHT, PERIOD, 4) is None


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_who_stands_or_hurries_keeps_to_the_trot(speed: float) -> None:
    assert stair_gait(StairsTerrain(0.12, 0.3), VelocityCommand.constant(speed), HEIGHT, PERIOD, 4) is None


def test_the_controller_trots_in_step_and_says_so() -> None:
    robot, command = load_robot("go2"), VelocityCommand.constant(0.4)
    walker = WalkingController(robot, command, terrain=StairsTerrain(0.12, 0.3))
    assert walker.schedule.period == pytest.approx(0.75)  # type: ignore[attr-defined]
    assert any("0.75 s" in note for note in walker.notes)
    # on steep stairs it is slowed, and in step with what is left
    steep = WalkingController(robot, command, terrain=StairsTerrain(0.13, 0.3))
    left = steep.command.at(1.0)[0]
    assert left < 0.4
    strides = 0.3 / (steep.schedule.period * left)  # type: ignore[attr-defined]
    assert strides == pytest.approx(2.0, abs=1e-6)
    assert WalkingController(robot, command).schedule.period < 0.5  # type: ignore[attr-defined]
