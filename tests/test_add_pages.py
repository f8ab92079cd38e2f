"""What the pages "add a ..." show from outside the package works as it stands there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.audit import log_laws
from surefoot.control import gait_library
from surefoot.control.controller import RobotState
from surefoot.log import CHANNELS, formats
from tests.pages import run_page


@pytest.fixture(autouse=True)
def tables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Leave the package's tables, and the working folder, as they were."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(formats, "FORMATS", dict(formats.FORMATS))
    monkeypatch.setitem(gait_library.PATTERNS, 4, dict(gait_library.PATTERNS[4]))


def test_a_controller_from_outside_stands_and_tells_its_own_channel() -> None:
    names = run_page("add-a-controller.md")
    log, controller, robot = names["log"], names["JointHold"], names["robot"]
    assert log.facts["outcome"] == "done"
    assert log.facts["kind"] == "hold"
    assert log["joint_error"].shape == (1000, robot.joints)
    np.testing.assert_allclose(log["joint_error"], names["q"][7:] - log["q"][:, 7:], atol=1e-15)
    assert log["push"].any()
    again = sf.read_log(log.save(Path("hold.npz")))  # the channel's definition goes with the file
    assert again.channels["joint_error"].unit == "rad"
    np.testing.assert_array_equal(again["joint_error"], log["joint_error"])
    bad = controller(robot, names["q"]).step(RobotState(names["q"] * np.nan, np.zeros(18)))
    assert not bad.attained
    assert bad.status is sf.Status.INVALID
    assert (bad.torques == 0.0).all()


def test_a_controller_whose_rows_are_not_its_channels_is_told_so() -> None:
    names = run_page("add-a-controller.md")
    robot, held = names["robot"], names["JointHold"](names["robot"], names["q"])
    held.channels = ()
    with pytest.raises(sf.ProblemError, match=r"rows for joint_error, its controller has the channels none"):
        sf.run(sf.MujocoWorld(robot), held, names["scenario"])
    held.channels = (CHANNELS["forces"],)
    with pytest.raises(sf.ProblemError, match="'forces' is one that every log has"):
        sf.run(sf.MujocoWorld(robot), held, names["scenario"])


def test_a_log_format_from_outside_comes_back_to_the_last_bit() -> None:
    names = run_page("add-a-log-format.md")
    log, again = names["log"], names["again"]
    assert set(again.arrays) == set(log.arrays)
    for name in log.arrays:
        np.testing.assert_array_equal(again[name], log[name])
    assert again.facts["feet"] == log.facts["feet"]
    assert log_laws(again).broken(157.8) == []
    with pytest.raises(sf.ProblemError, match="exists already"):
        log.save("stand.table")
    Path("broken.table").write_text("no facts\n")
    with pytest.raises(sf.ProblemError, match=r"broken.table is not a Surefoot log \(table\)"):
        sf.read_log("broken.table")
    with pytest.raises(sf.ProblemError, match=r"should end in one of \.bag, \.csv, \.db3, \.mcap, \.npz"):
        sf.read_log("log.xyz")


def test_a_gait_from_outside_walks() -> None:
    names = run_page("add-a-gait.md")
    summary, log = names["summary"], names["log"]
    assert summary.gait == "amble"
    assert summary.success
    assert summary.laws_broken == []
    planned = log["planned"][1000:].mean(axis=0)  # after the start, whole cycles of half a second
    np.testing.assert_allclose(planned, 0.6, atol=0.02)


def test_a_behaviour_from_outside_crouches_below_a_bar_and_the_log_says_who_asked() -> None:
    names = run_page("add-a-behaviour.md")
    log, walker, crouching = names["log"], names["walker"], names["crouching"]
    assert log.facts["outcome"] == "done"
    assert log.facts["behaviours"][-1] == "crouch"
    x, z = log["q"][:, 0], log["q"][:, 2]
    assert x[-1] > 1.3  # behind the bar, and up again
    below, before = np.abs(x - 0.8) < 0.2, x < 0.1
    assert z[below].max() < z[before].min() - 0.04
    assert z[-1] == pytest.approx(z[before].mean(), abs=0.01)
    own = len(walker.arbiter.behaviours) - 1
    asked = log["asked_by"][crouching]
    assert (asked[:, names["LOGGED"].index("height")] == own).all()
    assert np.median(np.gradient(x[below], 1e-3)) < 0.28
