"""Motors, payload, latency and friction from walks in MuJoCo that hide them, and the sweep that follows."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from benchmarks.identify_walks import hidden_walk
from surefoot.base.errors import ProblemError
from surefoot.records.identification.walked_robot import identify_robot
from surefoot.records.log import Log
from surefoot.worlds.sweep import read_sweep

NAMES = {"armature", "joint_damping", "joint_friction", "payload", "delay", "mu"}


@pytest.fixture(scope="module")
def walked() -> tuple[Log, dict[str, float]]:
    return hidden_walk(6)


@pytest.mark.long
def test_a_walk_tells_what_was_hidden_in_it(
    walked: tuple[Log, dict[str, float]], tmp_path: Path, printed: Any, answer: Any
) -> None:
    log, truth = walked
    log.save(tmp_path / "log.npz")
    told = answer("identify", tmp_path / "log.npz", "--out", tmp_path)
    found = told["fit"]
    assert set(found) == NAMES
    for name in NAMES - {"mu"}:
        assert found[name]["low"] <= truth[name] <= found[name]["high"], name
        assert found[name]["value"] == pytest.approx(truth[name], abs=0.06 * max(truth[name], 0.6)), name
    assert 0.25 < found["mu"]["low"] < truth["mu"]
    assert "no foot slid" in told["notes"][0]
    sweep = read_sweep(told["sweep"])
    assert set(sweep.space.drawn) == NAMES
    assert sweep.space.ranges["mu"].ends == (pytest.approx(found["mu"]["low"], rel=1e-3), 1.0)
    said = printed("identify", tmp_path / "log.npz", "--law", "rigid", "--out", tmp_path, code=2)
    assert "--law are of tosses" in said


@pytest.mark.long
def test_what_a_simulator_knows_besides_changes_nothing(walked: tuple[Log, dict[str, float]]) -> None:
    log, robot = walked[0].rows(slice(0, 2500)), sf.load_robot("go2")
    kept = ("time", "q_estimated", "v_estimated", "torques", "normals", "forces_commanded")
    bare = Log({name: log[name] for name in kept}, {"dt": log.fact("dt")})
    assert identify_robot(robot, bare).parameters == identify_robot(robot, log).parameters
    silent = Log({name: log[name] for name in kept[:4]}, {"dt": log.fact("dt")})
    told = identify_robot(robot, silent)
    assert set(told.parameters) == NAMES - {"delay"}
    assert math.isinf(told.parameters["mu"].high)
    assert not any("below zero" in note for note in told.notes)


@pytest.mark.long
def test_another_robot_s_model_is_doubted(walked: tuple[Log, dict[str, float]]) -> None:
    """Its joints have the same names."""
    told = identify_robot(sf.load_robot("b1"), walked[0].rows(slice(0, 2500)))
    assert any("payload: below zero" in note for note in told.notes)


def test_wrong_logs_are_named(walked: tuple[Log, dict[str, float]]) -> None:
    log, robot = walked[0], sf.load_robot("go2")
    with pytest.raises(ProblemError, match="the log has 1 s"):
        identify_robot(robot, log.rows(slice(0, 1000)))
    with pytest.raises(ProblemError, match="must have shape"):
        identify_robot(sf.load_robot("g1"), log)
    with pytest.raises(ProblemError, match="floating base"):
        identify_robot(sf.load_robot("go2", fixed_base=True), log)
    with pytest.raises(ProblemError, match="the log has no torques"):
        identify_robot(robot, Log({n: log[n] for n in ("time", "q", "v")}, log.facts))
    spoilt = {**log.arrays, "torques": np.full_like(log["torques"], np.nan)}
    with pytest.raises(ProblemError, match="torques"):
        identify_robot(robot, Log(spoilt, log.facts))
