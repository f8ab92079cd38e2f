"""The other half of an audit: what the controller asked for, whether the task was attained, exit codes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.app.cli.main import main
from surefoot.records import Log
from surefoot.records.audit.report import LawBroken
from tests.records.audit.broken_controllers import FAULTS, BrokenRun, broken_runs
from tests.records.audit.logs import RUNS, TROT, changed, log_of


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_a_clean_run_asks_for_what_laws_allow_and_attains_it(run: CleanRun) -> None:
    report = sf.audit_log(log_of(run))
    assert (report.task, report.task_reason, report.command) == ("attained", "", ())
    assert report.passed
    assert "the task was attained" in report.sentence


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.sampled(2)
def test_a_broken_controller_is_named(fault: str) -> None:
    run = BrokenRun("go2", "mujoco", fault, 0.4, 0.3)
    report = sf.audit_log(run.log())
    assert run.named(report), report.sentence


def test_the_controller_that_is_broken_on_purpose_stands_when_it_is_not() -> None:
    report = sf.audit_log(BrokenRun("go2", "mujoco", "", 0.5, 0.0).log())
    assert report.passed, report.sentence
    assert report.command == ()


FROZEN = 0x51869243
"""The commit that the detectors were last changed by: whoever drew the runs cannot have chosen among them."""


@pytest.mark.long
def test_thirty_six_broken_runs_drawn_by_a_seed() -> None:
    runs = broken_runs(36, seed=FROZEN)
    missed = [run for run in runs if not run.named(sf.audit_log(run.log()))]
    assert len(missed) <= 3, missed


def test_a_controller_that_knows_no_forces_is_not_asked_for_them() -> None:
    log = log_of(RUNS[1])
    silent = changed(log, forces_commanded=np.full(log["forces"].shape, np.nan))
    assert "no forces" not in {found.name for found in sf.audit_log(silent).command}


def test_a_stand_that_ends_on_its_hind_legs_says_so_first_and_fails() -> None:
    log = CleanRun(push=(12.0, 0.0, 0.0), duration=1.2).make()
    report = sf.audit_log(log)
    assert report.task == "failed"
    assert "the task failed: the base is not where it should stand" in report.sentence
    assert "motion" not in report.laws_broken  # what stops give is in the log
    kept = {name: array for name, array in log.arrays.items() if name != "other_forces"}
    symptoms = {found.name for found in sf.audit_log(Log(kept, dict(log.facts))).symptoms}
    assert "joint stop" in symptoms
    assert "dropout" not in symptoms  # a leg on its stop is no faulty sensor
    assert report.exit_code == 1
    with pytest.raises(LawBroken, match="task failed"):
        sf.assert_lawful(log)


def test_a_stranger_that_lies_on_its_side_failed_without_saying_so() -> None:
    log = log_of(RUNS[1])
    q = np.array(log["q"])
    q[-1, 3:7] = [np.sin(0.7), 0.0, 0.0, np.cos(0.7)]
    spoilt = changed(log, facts={"outcome": "done"}, q=q)
    assert "from its upright pose" in sf.audit_log(spoilt).task_reason


def test_a_walk_that_stays_where_it_is_failed() -> None:
    log = log_of(TROT)
    time = np.array(log["time"]) * 3.0
    still = changed(log, facts={"dt": 3.0 * float(log.fact("dt"))}, time=time, v=np.zeros(log["v"].shape))
    assert sf.audit_log(still).task_reason == "the robot did not follow the commanded velocity"


@pytest.mark.parametrize(("outcome", "code"), [("done", 0), ("fell", 1), ("interrupted", 0)])
def test_exit_codes_of_lawful_logs(outcome: str, code: int, tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    changed(log_of(RUNS[1]), facts={"outcome": outcome}).save(path)
    assert main(["audit", str(path)]) == code


def test_one_cannot_tell_is_exit_code_3(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    changed(log_of(RUNS[1]), keep=("forces",)).save(path)
    assert main(["audit", str(path)]) == 3


def test_a_log_without_its_robot_is_left_as_it_was() -> None:
    log = changed(log_of(TROT), facts={"robot": "nobody's"})
    before = {name: np.array(array) for name, array in log.arrays.items()}
    sf.audit_log(log)
    for name, array in before.items():
        np.testing.assert_array_equal(log[name], array)
