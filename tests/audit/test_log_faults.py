"""Seeded faults: every kind is found with its foot, time and cause. All: `python -m benchmarks.audit`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.audit import faulty_logs, judge
from benchmarks.problems.logged_runs import CleanRun, clean_runs
from surefoot.audit import SYMPTOMS, audit_log
from surefoot.audit.log_faults import LOG_FAULTS, LogFault
from tests.audit.logs import PUSHED, RUNS, log_of


def test_there_are_enough_kinds_and_each_has_its_symptom() -> None:
    names = [fault.name for fault in LOG_FAULTS]
    assert len(names) == len(set(names)) >= 25
    assert {f.symptom for f in LOG_FAULTS if f.symptom} <= {s.name for s in SYMPTOMS}


def test_clean_runs_are_many_and_different() -> None:
    runs = clean_runs(100)
    assert len({run.name for run in runs}) == 100
    assert {run.world for run in runs} == {"mujoco", "rigid"}
    assert {run.robot for run in runs} == {"go2", "a1", "anymal"}


@pytest.mark.parametrize("fault", [f for f in LOG_FAULTS if f.name != "mirror"], ids=lambda f: f.name)
def test_a_seeded_fault_is_found_with_foot_time_and_cause(fault: LogFault) -> None:
    spoilt = next(iter(faulty_logs(fault, (log_of(run) for run in (*RUNS, PUSHED)), 1)))
    report = audit_log(spoilt.log)
    assert judge(fault, spoilt, report) == (True, True, True, True), report.sentence


def test_a_leg_on_its_stop_is_no_faulty_sensor() -> None:
    log = CleanRun(push=(12.0, 0.0, 0.0), duration=1.2).make()  # it falls onto its hind legs
    report = audit_log(log)
    assert report.verdict == "broken"
    assert "joint stop" in {s.name for s in report.symptoms}
    assert "dropout" not in {s.name for s in report.symptoms}


def test_every_symptom_and_fault_is_on_the_page() -> None:
    page = (Path(__file__).parents[2] / "docs" / "audit.md").read_text(encoding="utf-8")
    for symptom in SYMPTOMS:
        assert f"| {symptom.name} | {symptom.cause} | {symptom.confirm} | {symptom.cure} |" in page
    for fault in LOG_FAULTS:
        size = f"{fault.amplitude:.3g} {fault.unit}".strip()
        row = f"| `{fault.name}` | {fault.title} | {size} |"
        assert row in page


def test_a_fault_leaves_the_clean_log_alone() -> None:
    log = log_of(RUNS[0])
    before = np.array(log["forces"])
    for fault in LOG_FAULTS:
        fault.apply(log, 0)
    np.testing.assert_array_equal(log["forces"], before)
