"""Seeded faults: every kind is found with its foot, time and cause. All: `python -m benchmarks.audit`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.audit import faulty_logs, judge
from surefoot.base.errors import ProblemError
from surefoot.records.audit import SYMPTOMS, audit_log
from surefoot.records.audit.seeded_faults import LOG_FAULTS, LogFault, seeded_faults
from tests.records.audit.logs import PUSHED, RUNS, STAND, changed, log_of


def test_there_are_enough_kinds_and_each_has_its_symptom() -> None:
    names = [fault.name for fault in LOG_FAULTS]
    assert len(names) == len(set(names)) >= 25
    assert {f.symptom for f in LOG_FAULTS if f.symptom} <= {s.name for s in SYMPTOMS}


@pytest.mark.parametrize("fault", [f for f in LOG_FAULTS if f.name != "mirror"], ids=lambda f: f.name)
@pytest.mark.sampled(20)
def test_a_seeded_fault_is_found_with_foot_time_and_cause(fault: LogFault) -> None:
    spoilt = next(iter(faulty_logs(fault, (log_of(run) for run in (*RUNS, PUSHED)), 1)))
    report = audit_log(spoilt.log)
    assert judge(fault, spoilt, report) == (True, True, True, True), report.sentence


def test_every_symptom_and_fault_is_on_the_page() -> None:
    docs = Path(__file__).parents[3] / "docs"
    names = ("symptoms.md", "symptoms-of-measurements.md", "reports/audit.md")
    page = "\n".join((docs / name).read_text(encoding="utf-8") for name in names)
    for symptom in SYMPTOMS:
        assert f"| {symptom.name} | {symptom.cause} | {symptom.confirm} | {symptom.cure} |" in page
    for fault in LOG_FAULTS:
        size = f"{fault.amplitude:.3g} {fault.unit}".strip()
        row = f"| `{fault.name}` | {fault.title} | {size} |"
        assert row in page


def test_what_no_fault_can_be_seeded_into_is_refused() -> None:
    log = log_of(STAND)
    for spoilt, said in (
        (changed(log, keep=("forces", "torques")), "needs the channel '.*', which the log lacks"),
        (changed(log, {"feet": ["left", "right"]}), "on point feet"),
        (log.rows(slice(0, 300)), "200 rows and 0.25 s or more"),
    ):
        with pytest.raises(ProblemError, match=said):
            list(seeded_faults(spoilt, seed=1))


def test_a_fault_leaves_the_clean_log_alone() -> None:
    log = log_of(RUNS[0])
    before = np.array(log["forces"])
    for fault in LOG_FAULTS:
        fault.apply(log, 0)
    np.testing.assert_array_equal(log["forces"], before)
