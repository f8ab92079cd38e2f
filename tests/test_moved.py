"""Names that have moved still work for this release, and say where they are now."""

from __future__ import annotations

import importlib

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
        ("simulation.walking", "WalkScenario", "surefoot.simulation.scenario.Scenario"),
    ],
)
def test_an_old_name_is_the_new_one(module: str, name: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=f"surefoot.{module}.{name} is now {new}"):
        found = getattr(importlib.import_module(f"surefoot.{module}"), name)
    home, _, last = new.rpartition(".")
    assert found is getattr(importlib.import_module(home), last)
    with pytest.raises(AttributeError, match=f"surefoot.{module}' has no attribute 'nothing'"):
        importlib.import_module(f"surefoot.{module}").nothing  # noqa: B018


def test_the_old_runs_and_summaries_still_go() -> None:
    from surefoot.simulation.standing import run_standing
    from surefoot.simulation.summary import summarise
    from surefoot.simulation.walk_summary import summarise_walk as old_walk
    from surefoot.simulation.walking import run_walking

    robot, ground, times = sf.load_robot("go2"), sf.FlatTerrain(), []
    q = sf.place(robot)
    scenario = sf.Scenario(0.1, 0.6)
    standing = sf.StandingController(robot, sf.StandingPlan(robot, ground, q), ground, q)
    with pytest.warns(DeprecationWarning, match="run_standing is now surefoot.run"):
        log = run_standing(sf.MujocoWorld(robot), standing, q, scenario, times.append)
    with pytest.warns(DeprecationWarning, match="summarise is now"):
        assert summarise(log) == summarise_stand(log).as_dict()
    assert len(times) == 5
    walking = sf.WalkingController(robot, sf.VelocityCommand.constant(0.3))
    with pytest.warns(DeprecationWarning, match="run_walking is now surefoot.run"):
        log = run_walking(sf.MujocoWorld(robot), walking, q, scenario)
    with pytest.warns(DeprecationWarning, match="summarise_walk is now"):
        assert old_walk(log) == summarise_walk(log).as_dict()
    assert np.isfinite(log["q"]).all()
