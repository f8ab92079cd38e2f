"""Walks whose commands come late, are rare, or for which no state comes at all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.audit import WalkSummary, summarise_walk
from surefoot.cli.command_options import Wiring
from surefoot.cli.walk_output import figure_lines, headline
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import ProblemError
from surefoot.log import Log
from surefoot.robot.actuators import real_actuators
from surefoot.simulation.faults import Faults
from surefoot.simulation.run import Push, Scenario, run
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.terrain import FlatTerrain

GO2 = sf.load_robot("go2")
REAL = real_actuators(GO2)


def walk(
    wired: Wiring, duration: float = 2.5, pushes: Sequence[Push] = (), **faults: Any
) -> tuple[Log, WalkSummary]:
    """Return log and summary of a Go2's trot with motors, on an estimated state."""
    settings = WalkSettings(actuators=REAL)
    command = VelocityCommand.constant(0.5, 0.0, 0.0)
    walking = WalkingController(GO2, command, "trot", FlatTerrain(), settings, wired.dt)
    start = start_pose(GO2, FlatTerrain())
    told = Faults(dropouts=wired.dropouts, **faults)
    scenario = Scenario(duration, 0.6, pushes, start=start, sensors=SensorModel(), seed=2, faults=told)
    there = make_world("mujoco", GO2, None, 0.6, actuators="real", collision="full")
    log = run(there, wired.around(walking, GO2), scenario)
    return log, summarise_walk(log)


@pytest.mark.parametrize(
    "wired",
    [Wiring(), Wiring(targets=True, latency=0.0), Wiring(targets=True, every=4)],
    ids=["torques", "targets alone", "targets at 250 Hz"],
)
def test_five_milliseconds_late(wired: Wiring) -> None:
    _, summary = walk(wired, delay=0.005)
    assert summary.good, headline(summary)
    assert summary.velocity.forward.measured == pytest.approx(0.5, abs=0.02)
    assert max(foot.slip for foot in summary.feet) < 2e-3


def test_targets_slide_less_than_torques() -> None:
    slips = [
        max(foot.slip for foot in walk(Wiring(targets=targets, latency=0.0), delay=0.005)[1].feet)
        for targets in (False, True)
    ]
    assert slips[1] < 0.7 * slips[0]


def test_targets_do_not_slide_feet_after_a_push() -> None:
    push = Push(1.55, (-150.0, 0.0, 0.0), 0.1)
    _, summary = walk(Wiring(targets=True), 2.3, pushes=[push])
    assert summary.good, headline(summary)
    assert max(foot.slip for foot in summary.feet) < 5e-3


def test_a_short_silence_is_walked_through_and_a_long_one_told() -> None:
    log, summary = walk(Wiring(targets=True, dropouts=((1.0, 0.015), (1.5, 0.05))))
    assert summary.success
    stale = np.flatnonzero(log["stale"])
    assert len(stale) == 30  # the state is up to 50 ms old; all but the first 20
    assert summary.stale == pytest.approx(0.03)
    assert any("no fresh state" in line and "0.030 s" in line for line in figure_lines(summary))
    np.testing.assert_array_equal(log["forces_commanded"][stale], 0.0)


def test_impossible_dropouts_are_refused() -> None:
    with pytest.raises(ProblemError, match="dropout"):
        walk(Wiring(dropouts=((-1.0, 0.1),)))
