"""The pages on adding things hold whole programs: they run as shown, from outside the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.robot import load_robot
from surefoot.robot.catalog import CATALOG
from surefoot.simulation.worlds import WORLDS, make_world
from surefoot.terrain import TERRAINS, read_terrain
from tests import pages


def run_page(name: str) -> dict[str, Any]:
    """Run a page and return its names, with the exit codes of its commands."""
    return pages.run_page(
        f"{name}.md",
        {"codes": []},
        edit=lambda block: re.sub(r"^main\((.*)\)$", r"codes.append(main(\1))", block, flags=re.MULTILINE),
    )


@pytest.fixture(autouse=True)
def _tables_and_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Run in a folder of its own, and leave the tables as they were."""
    monkeypatch.chdir(tmp_path)
    kept = [(table, dict(table)) for table in (TERRAINS, WORLDS, CATALOG)]
    yield
    for table, before in kept:
        table.clear()
        table.update(before)


def test_a_terrain_from_outside(capfd: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-terrain")
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


def test_a_world_from_outside(capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-world")
    assert names["codes"] == [0]
    assert "stood" in capsys.readouterr().out
    robot = load_robot("go2")
    world = make_world("springs", robot, read_terrain("slope:5"))
    assert world.contact_foot.tolist() == [0, 1, 2, 3]
    world.reset(robot.nominal)
    world.step(np.zeros(12), push=np.array([0.0, 500.0, 0.0]))
    assert world.state()[1][1] > 0.0
    assert world.time == pytest.approx(1e-3)


def test_a_robot_from_outside(capsys: pytest.CaptureFixture[str]) -> None:
    names = run_page("add-a-robot")
    assert names["codes"] == [0]
    assert names["robot"].mass == pytest.approx(3.9)
    assert load_robot("my_a1").mass == load_robot("a1").mass
    assert "front_foot:0" in capsys.readouterr().out
