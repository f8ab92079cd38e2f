"""Walks whose commands come late, are rare, or for which no state comes at all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.run_output import walk_headline, walk_lines
from surefoot.app.cli.walk_options import Wiring
from surefoot.base.errors import ProblemError
from surefoot.motion.walking.walking_controller import WalkSettings
from surefoot.records.audit import WalkSummary
from surefoot.records.log import Log
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.run import Push
from surefoot.worlds.running.sensors import SensorModel
from tests.worlds.running.walks import REAL, WHOLE, walk


def late(
    wired: Wiring, duration: float = 2.5, pushes: Sequence[Push] = (), **faults: Any
) -> tuple[Log, WalkSummary]:
    """Return log and summary of a trot with motors, on an estimated state, with late commands."""
    sensed = {"sensors": SensorModel(), "faults": Faults(dropouts=wired.dropouts, **faults)}
    motors = {"world": WHOLE, "settings": WalkSettings(actuators=REAL)}
    return walk(0.5, duration, wired=wired, pushes=pushes, seed=2, **sensed, **motors)


@pytest.mark.parametrize(
    "wired",
    [Wiring(), Wiring(targets=True, latency=0.0), Wiring(targets=True, every=4)],
    ids=["torques", "targets alone", "targets at 250 Hz"],
)
@pytest.mark.long
def test_five_milliseconds_late(wired: Wiring) -> None:
    _, summary = late(wired, delay=0.005)
    assert summary.good, walk_headline(summary)
    assert summary.velocity.forward.measured == pytest.approx(0.5, abs=0.02)
    assert max(foot.slip for foot in summary.feet) < 2e-3


@pytest.mark.long
def test_targets_slide_less_than_torques() -> None:
    slips = [
        max(foot.slip for foot in late(Wiring(targets=targets, latency=0.0), delay=0.005)[1].feet)
        for targets in (False, True)
    ]
    assert slips[1] < 0.7 * slips[0]


@pytest.mark.long
def test_targets_do_not_slide_feet_after_a_push() -> None:
    push = Push(1.55, (-150.0, 0.0, 0.0), 0.1)
    _, summary = late(Wiring(targets=True), 2.3, pushes=[push])
    assert summary.good, walk_headline(summary)
    assert max(foot.slip for foot in summary.feet) < 5e-3


@pytest.mark.long
def test_a_short_silence_is_walked_through_and_a_long_one_told() -> None:
    log, summary = late(Wiring(targets=True, dropouts=((1.0, 0.015), (1.5, 0.05))))
    assert summary.success
    stale = np.flatnonzero(log["stale"])
    assert len(stale) == 30  # the state is up to 50 ms old; all but the first 20
    assert summary.stale == pytest.approx(0.03)
    assert any("no fresh state" in line and "0.030 s" in line for line in walk_lines(summary))
    np.testing.assert_array_equal(log["forces_commanded"][stale], 0.0)


def test_impossible_dropouts_are_refused() -> None:
    with pytest.raises(ProblemError, match="dropout"):
        late(Wiring(dropouts=((-1.0, 0.1),)))
