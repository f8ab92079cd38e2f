"""Names that have moved still work for this release, and say where they are now."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.audit import summarise_stand, summarise_walk


@pytest.mark.parametrize(
    ("module", "name", "new"),
    [
        ("simulation.log", "Log", "surefoot.log.Log"),
        ("simulation.log", "read_log", "surefoot.log.read_log"),
        ("simulation.pressure", "sole_pressures", "surefoot.audit.sole_pressures"),
        ("simulation.walking", "WalkScenario", "surefoot.simulation.old.WalkScenario"),
    ],
)
def test_an_old_name_is_the_new_one(module: str, name: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"surefoot.{module}.{name} is now {new}"):
        found = getattr(importlib.import_module(f"surefoot.{module}"), name)
    home, _, last = new.rpartition(".")
    assert found is getattr(importlib.import_module(home), last)
    with pytest.raises(AttributeError, match=f"surefoot.{module}' has no attribute 'nothing'"):
        importlib.import_module(f"surefoot.{module}").nothing  # noqa: B018


def old(module: str, name: str, new: str) -> Any:
    """Return a name from where it was."""
    with pytest.warns(DeprecationWarning, match=f"surefoot.simulation.{module}.{name} is now {new}"):
        return getattr(importlib.import_module(f"surefoot.simulation.{module}"), name)


def test_the_old_runs_and_summaries_still_go() -> None:
    robot, ground, times = sf.load_robot("go2"), sf.FlatTerrain(), []
    q, scenario = sf.place(robot), sf.Scenario(0.1, 0.6)
    standing = sf.StandingController(robot, sf.StandingPlan(robot, ground, q), ground, q)
    run_standing = old("standing", "run_standing", "surefoot.simulation.old")
    log = run_standing(sf.MujocoWorld(robot), standing, q, scenario, progress=times.append)
    assert old("summary", "summarise", "surefoot.simulation.old")(log) == summarise_stand(log).as_dict()
    assert len(times) == 5
    walking = sf.WalkingController(robot, sf.VelocityCommand.constant(0.3))
    log = old("walking", "run_walking", "surefoot.simulation.old")(
        sf.MujocoWorld(robot), walking, q, scenario
    )
    summarise = old("walk_summary", "summarise_walk", "surefoot.simulation.old")
    assert summarise(log) == summarise_walk(log).as_dict()
    assert np.isfinite(log["q"]).all()
