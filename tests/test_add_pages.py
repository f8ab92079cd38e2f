"""The pages "add a ..." hold whole programs: they run as shown, from outside the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.robot.catalog import CATALOG
from surefoot.mechanics.terrain import TERRAINS, read_terrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.gaits import library as gait_library
from surefoot.records.audit import log_laws
from surefoot.records.log import CHANNELS, formats
from surefoot.worlds.interface.world_names import WORLDS, make_world
from tests.pages import run_page as run_blocks


@pytest.fixture(autouse=True)
def tables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Leave the package's tables, and the working folder, as they were."""
    monkeypatch.chdir(tmp_path)
    changed = (formats.FORMATS, gait_library.PATTERNS[4], TERRAINS, WORLDS, CATALOG)
    kept = [(table, dict(table)) for table in changed]
    yield
    for table, before in kept:
        table.clear()
        table.update(before)


def run_page(name: str) -> dict[str, Any]:
    """Run a page and return its names, with the exit codes of its commands."""
    return run_blocks(
        name,
        {"codes": []},
        edit=lambda block: re.sub(r"^main\((.*)\)$", r"codes.append(main(\1))", block, flags=re.MULTILINE),
    )


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


@pytest.mark.long
def test_a_gait_from_outside_walks() -> None:
    names = run_page("add-a-gait.md")
    summary, log = names["summary"], names["log"]
    assert summary.gait == "amble"
    assert summary.success
    assert summary.laws_broken == []
    planned = log["planned"][1000:].mean(axis=0)  # after the start, whole cycles of half a second
    np.testing.assert_allclose(planned, 0.6, atol=0.02)


@pytest.mark.long
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


@pytest.mark.long
def test_a_terrain_from_outside(capfd: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-terrain.md")
    assert names["codes"] == [0]
    assert "walked" in capfd.readouterr().out
    waves, robot = read_terrain("waves:0.04,1.5"), load_robot("go2")
    places = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 2))
    coarse = super(type(waves), waves).gradient(places)
    assert waves.gradient(places) == pytest.approx(coarse, abs=1e-8)
    for name in ("mujoco", "rigid"):  # the worlds that take any surface
        world = make_world(name, robot, waves)
        world.reset(robot.nominal + np.array([0.0, 0.0, 0.1] + [0.0] * 16))
        for _ in range(400):
            world.step(np.zeros(12))
        reading = world.contacts()
        assert np.abs(reading.gaps[reading.forces[:, 2] > 1.0]).max() < 2e-3
        assert reading.forces[:, 2].sum() > 10.0


@pytest.mark.long
def test_a_world_from_outside(capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-world.md")
    assert names["codes"] == [0]
    assert "stood" in capsys.readouterr().out
    robot = load_robot("go2")
    world = make_world("springs", robot, read_terrain("slope:5"))
    assert world.contact_foot.tolist() == [0, 1, 2, 3]
    world.reset(robot.nominal)
    world.step(np.zeros(12), push=np.array([0.0, 500.0, 0.0]))
    assert world.q_v()[1][1] > 0.0
    assert world.time == pytest.approx(1e-3)


def test_a_robot_from_outside(capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-robot.md")
    assert names["codes"] == [0]
    assert names["robot"].mass == pytest.approx(3.9)
    assert load_robot("my_a1").mass == load_robot("a1").mass
    assert "front_foot:0" in capsys.readouterr().out
